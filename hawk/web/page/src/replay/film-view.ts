import { html, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import type { Film, FilmMessage, Recording, SurveysUse } from "../api.ts";
import { API, read, Refused } from "../link/api.ts";
import { icon, type IconName } from "../ui/icons.ts";
import { drone } from "../ui/quoting.ts";
import { swatch } from "../ui/swatch.ts";
import { moment } from "../views/figures.ts";
import type { LotSource } from "../views/link.ts";
import type { Feature } from "../views/survey-source.ts";
import "../views/survey-map.ts";
import "../views/time-bar.ts";
import { Asked, View } from "../views/view.ts";
import { learn } from "../words/drone.ts";
import * as format from "../words/format.ts";
import { language, number, say } from "../words/say.ts";
import { beginOf, clockAt, instantAt, type Instant, lastAt, messageAt, seenBy, seenWords, spanOf } from "./film.ts";
import type { FilmAsked } from "./film-bar.ts";
import "./film-bar.ts";
import { expected, type Expected, extentOfFilm, filmOnMap, type Outcome, sceneAt } from "./film-map.ts";
import { everyFrame, Player } from "./player.ts";

const ICONS: Record<FilmMessage["level"], IconName> = { info: "info", ok: "check", warning: "warn", error: "warn" };
/** A flight that has just landed: its survey is in the store so much later. */
const STORED_MS = 4000;
/** Seconds that an arrow key goes. */
const STEP_S = 5;

/** A recording that is played: the map as it was known at a moment, the camera's picture, figures and messages. */
@customElement("archive-film")
export class FilmView extends View {
  /** All recordings, the oldest first. */
  @property({ attribute: false }) recordings: readonly Recording[] = [];
  /** Reads of a lot: the same for one lot, whichever view asks. */
  @property({ attribute: false }) sourceOf!: (lot: string) => LotSource;
  /** The clock of a film over no lot. */
  @property() zone: string | undefined;
  every = everyFrame;
  @state() private isWeek = false;
  private readonly film = new Asked<Film>(this);
  private readonly outcome = new Asked<Outcome | null>(this);
  /** The newest surveys of the lot: whether there are any. */
  private readonly surveys = new Asked<SurveysUse | null>(this);
  private readonly map = new Asked<Feature[]>(this);
  private readonly player = new Player(this, (work) => this.every(work));
  private all: readonly Expected[] = [];
  private shown: { key: string; map: ReturnType<typeof filmOnMap> } = { key: "", map: null };
  private extent: ReturnType<typeof extentOfFilm> = null;
  private waiting = 0;
  /** Number of the picture that is shown; another one is asked for when it is there. */
  private picture = -1;
  private isLoading = false;
  private isMissed = false;
  @state() private chosen = "";
  /** The message that the list was scrolled to. */
  private followed: HTMLElement | null = null;

  override connectedCallback(): void {
    super.connectedCallback();
    document.addEventListener("keydown", this.key);
  }

  override disconnectedCallback(): void {
    document.removeEventListener("keydown", this.key);
    clearTimeout(this.waiting);
    this.player.pause();
    super.disconnectedCallback();
  }

  private get row(): Recording | undefined {
    return this.recordings.find(({ name }) => name === this.place.recording);
  }

  /** Deleted meanwhile, or never there. An empty list is none that was read. */
  private get isGone(): boolean {
    return this.recordings.length > 0 && !this.row && (this.film.value?.name !== this.place.recording || this.isMissed);
  }

  private get clock(): string | undefined {
    return this.row?.lot?.time_zone ?? this.zone;
  }

  /** Recordings of the same lot, or all without one. */
  private get others(): readonly Recording[] {
    const lot = this.row?.lot?.id;
    return this.recordings.filter((each) => !each.under_way && (lot === undefined || each.lot?.id === lot));
  }

  override willUpdate(changed: PropertyValues<this>): void {
    const before = changed.get("place");
    if (before && before.recording !== this.place.recording) this.another();
    const name = this.place.recording;
    const film = this.film.value;
    this.film.ask(name, () => this.readFilm(name));
    const { lot } = this.row ?? {};
    if (lot) {
      const source = this.sourceOf(lot.id);
      this.outcome.ask(`${lot.id} ${lot.survey}`, () => outcomeOf(source, lot.survey));
      this.surveys.ask(lot.id, () => source.newest());
    } else if (this.row?.survey && this.waiting === 0) this.waiting = window.setTimeout(() => this.changed(), STORED_MS);
    if (film?.name !== name) return;
    this.player.film(film, this.place.t === "" ? beginOf(film) : Number(this.place.t));
    const wanted = lastAt(film.maps, this.player.at);
    this.map.ask(`${name} ${wanted}`, async () => (wanted < 0 ? [] : (await read<{ features: Feature[] }>(`${API}/recordings/${name}/film/maps/${wanted}`)).features));
    this.placed(film);
    this.nextPicture(film);
  }

  private another(): void {
    this.player.pause();
    this.film.value = null;
    this.outcome.value = null;
    this.map.value = null;
    this.shown = { key: "", map: null };
    this.extent = null;
    this.picture = -1;
    this.isLoading = false;
    this.isMissed = false;
    this.chosen = "";
  }

  /** Asks again while the recording is being read. */
  private async readFilm(name: string): Promise<Film> {
    for (;;) {
      try {
        const film = await read<Film>(`${API}/recordings/${name}/film`);
        learn(film.messages.flatMap(({ sentences }) => sentences.map(({ text, code, values }) => ({ Text: text, Code: code, Values: values }))));
        return { ...film, name };
      } catch (error) {
        if (!(error instanceof Refused && error.isBusy) || !this.isConnected) throw error;
      }
    }
  }

  /** Stalls change with the map of the drone; what was seen between two maps changes nothing of it. */
  private placed(film: Film): void {
    const key = `${film.name} ${lastAt(film.maps, this.player.at)} ${this.outcome.value?.survey ?? ""} ${this.map.value?.length ?? -1}`;
    if (key === this.shown.key) return;
    this.all = expected(film, this.outcome.value);
    this.extent ??= extentOfFilm(film, this.all);
    this.shown = { key, map: filmOnMap(film, this.map.value ?? [], this.all, this.outcome.value, seenBy(film, this.player.at)) };
  }

  private nextPicture(film: Film): void {
    const wanted = lastAt(film.pictures, this.player.at);
    if (this.isLoading || wanted === this.picture) return;
    this.picture = wanted;
    this.isLoading = wanted >= 0;
  }

  /** The list follows the film; a hand that scrolls it is left alone. */
  override updated(): void {
    const now = this.querySelector<HTMLElement>(".said .on");
    const list = now?.closest<HTMLElement>(".said");
    if (!now || !list || now === this.followed || list.matches(":hover, :focus-within")) return;
    this.followed = now;
    list.scrollTop = now.offsetTop - list.clientHeight / 2;
  }

  override render(): TemplateResult {
    const back = html`<p class="filmback"><button class="small" @click=${() => this.go({ recording: "", t: "" })}>${icon("left")} ${say("film-all")}</button></p>`;
    const film = this.film.value;
    if (this.isGone) return html`${back}<p role="alert">${say("film-gone")}</p>`;
    if (this.film.problem !== "") return html`${back}<p role="alert">${this.film.problem}</p>`;
    if (film?.name !== this.place.recording) return html`${back}<p role="status">${say("film-reading")}</p>`;
    const { at } = this.player;
    const instant = instantAt(film, at);
    return html`<div class="lot film">
      ${this.ground(film, instant)}
      <div class="about">${this.about(film)} ${this.camera(film)} ${this.figures(instant)} ${this.messages(film)}</div>
      ${this.isWeek ? this.week() : this.bar(film)}
    </div>`;
  }

  private ground(film: Film, instant: Instant): TemplateResult {
    const { map } = this.shown;
    if (map === null) return html`<p class="card none">${say("film-no-map")}</p>`;
    const scene = sceneAt(film, this.player.at, instant, map.unseen);
    const label = say("film-map", { stalls: seenWords(instant, this.all.length) });
    return html`<hawk-survey-map .source=${map.shown} .scene=${scene} .extent=${this.extent} .chosen=${this.chosen} .label=${label} .theme=${document.documentElement.dataset.theme ?? ""} @stall=${(event: CustomEvent<string>) => (this.chosen = event.detail)}></hawk-survey-map>`;
  }

  private about(film: Film): TemplateResult {
    const { row } = this;
    const zone = this.clock;
    const until = row?.keep ? say("film-kept") : row?.keep_end ? say("film-kept-until", { day: moment(row.keep_end, zone).slice(0, 10) }) : "";
    const began = row?.began ?? film.began ?? null; // that of the list
    const facts = [row?.lot?.name ?? "", began === null ? "" : moment(began, zone), format.longDuration(film.seconds), row ? format.bytes(row.bytes) : "", until, film.footprints.length > 0 ? say("film-pale") : ""];
    return html`<section class="card not-live" aria-label=${say("film-not-live")}>
      <button class="small" @click=${() => this.go({ recording: "", t: "" })}>${say("film-all")}</button>
      <h2>${say("film-not-live")}</h2>
      <p class="sub">${facts.filter((each) => each !== "").join(" · ")}</p>
      ${film.problem === "" ? nothing : html`<p class="warning">${say("film-damage", { span: spanOf(film.seconds) })} <span lang="en">${film.problem}</span></p>`}
    </section>`;
  }

  private camera(film: Film): TemplateResult {
    if (this.picture < 0) return html`<section class="camera none"><p>${say("film-no-picture")}</p></section>`;
    const clock = clockAt(film, film.pictures[this.picture] ?? 0, this.clock);
    const words = say("film-recorded", { clock });
    return html`<section class="camera" aria-label=${say("camera-picture")}>
      <img src="${API}/recordings/${film.name}/film/pictures/${this.picture}" alt=${words} @load=${() => this.loaded()} @error=${() => this.missed()} />
      <span class="tag">${words}</span></section>`;
  }

  /** A picture that does not come: the list says whether the recording is there still. */
  private missed(): void {
    this.player.pause();
    if (!this.isMissed) this.changed();
    this.isMissed = true;
    this.loaded();
  }

  private loaded(): void {
    this.isLoading = false;
    this.requestUpdate();
  }

  private figures(instant: Instant): TemplateResult {
    const count = (name: "free" | "taken" | "unknown"): TemplateResult => html`<div class="ct">${swatch(name)}<div><b>${number(instant[name])}</b><span class="sub">${say(`legend-${name}`)}</span></div></div>`;
    const left = instant.left === null ? "" : say("film-left", { time: format.timeLeft(instant.left) });
    const value = (shown: string, words: string): TemplateResult => html`<div><b>${shown}</b><span class="sub">${words}</span></div>`;
    return html`<section class="card counts" aria-label=${say("stalls")}>${count("free")} ${count("taken")} ${count("unknown")}<span class="sub w">${seenWords(instant, this.all.length)}</span></section>
      <section class="card values" aria-label=${say("film-values")}>
        ${value(format.percent(instant.battery), [say("battery"), left].filter((each) => each !== "").join(", "))}
        ${value(format.height(instant.height, "metres"), say("height"))}
        ${value(instant.fromHome === null ? "–" : format.distance(instant.fromHome, "metres"), say("film-from-home"))}
      </section>`;
  }

  private messages(film: Film): TemplateResult {
    const now = messageAt(film.messages, this.player.at);
    const zone = this.clock;
    return html`<section class="card said" aria-label=${say("messages")} tabindex="0"><ol class="log">${film.messages.map(
      ({ at, level, text, details }, k) => html`<li data-level=${level} class="${k === now ? "on" : ""} ${k > now ? "later" : ""}"><button class="plain link" aria-current=${k === now} @click=${() => this.seek(at)}>${clockAt(film, at, zone)}</button>${icon(ICONS[level])}
        <div>${drone(text)}${details === "" ? nothing : html`<details><summary>${say("details")}</summary><span class="sub">${drone(details)}</span></details>`}</div></li>`,
    )}</ol></section>`;
  }

  private bar(film: Film): TemplateResult {
    const { others } = this;
    const index = others.findIndex(({ name }) => name === film.name);
    const has = { before: index > 0, after: index >= 0 && index < others.length - 1, week: (this.surveys.value?.surveys.length ?? 0) > 0 };
    return html`<hawk-film-bar .film=${film} .at=${this.player.at} .playing=${this.player.isPlaying} .speed=${this.player.speed} .zone=${this.clock} .has=${has} .spoken=${language()} @film=${(event: CustomEvent<FilmAsked>) => this.asked(event.detail)}></hawk-film-bar>`;
  }

  /** The surveys of the lot: one leads to its recording, and to itself where there is none. */
  private week(): TemplateResult {
    const { lot } = this.row ?? {};
    if (!lot) return html``;
    const pick = ({ detail }: CustomEvent<string>): void => {
      const found = this.recordings.find((each) => each.lot?.survey === detail);
      this.isWeek = false;
      if (!found) this.go({ view: "lots", lot: lot.id, survey: detail, recording: "", t: "" });
      else if (found.name !== this.place.recording) this.go({ recording: found.name, t: "" });
    };
    return html`<hawk-time-bar .source=${this.sourceOf(lot.id)} lot=${lot.id} .chosen=${[lot.survey]} .spoken=${language()} @survey=${pick}></hawk-time-bar>`;
  }

  private asked({ what, value }: FilmAsked): void {
    if (what === "play") this.playOrPause();
    else if (what === "week") this.showWeek();
    else if (what === "speed") this.player.play(value, this.player.isPlaying);
    else if (what === "seek") this.seek(value, false);
    else if (what === "stay") this.keep();
    else this.beside(what === "before" ? -1 : 1);
  }

  private playOrPause(): void {
    this.player.play(this.player.speed, !this.player.isPlaying);
    if (!this.player.isPlaying) this.keep();
  }

  private showWeek(): void {
    this.player.pause();
    this.isWeek = true;
  }

  private beside(step: number): void {
    const found = this.others[this.others.findIndex(({ name }) => name === this.place.recording) + step];
    if (found) this.go({ recording: found.name, t: "" });
  }

  private seek(at: number, keep = true): void {
    this.player.seek(at);
    if (keep) this.keep();
  }

  /** The address leads to this moment. */
  private keep(): void {
    this.go({ t: String(Math.round(10 * this.player.at) / 10) });
  }

  /** Space plays, arrows go some seconds; a field, a list and the map keep their own keys. */
  private readonly key = (event: KeyboardEvent): void => {
    const target = event.target instanceof Element ? event.target : null;
    if (this.film.value === null || this.isWeek || event.ctrlKey || event.altKey || event.metaKey) return;
    const isSlider = target?.matches("input[type=range]") === true;
    if (target?.closest(".ol, select, input:not([type=range]), textarea, dialog") != null) return;
    if (event.key === " " && target?.closest("button, summary, a") == null) this.playOrPause();
    else if (!isSlider && event.key === "ArrowRight") this.seek(this.player.at + STEP_S);
    else if (!isSlider && event.key === "ArrowLeft") this.seek(this.player.at - STEP_S);
    else return;
    event.preventDefault();
  };
}

async function outcomeOf(source: LotSource, survey: string): Promise<Outcome | null> {
  const [map, ground] = await Promise.all([source.map(survey), source.ground(survey)]);
  return { survey, map, ground };
}

