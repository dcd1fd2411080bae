import { html, LitElement, nothing, svg, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { type Ground, groundOf, originOf, type Point } from "../views/ground.ts";
import type { Feature } from "../views/survey-source.ts";
import { byState, type Shade } from "../views/plan-view.ts";
import "../views/plan-view.ts";
import { stateLegend } from "../views/surveys-view.ts";
import { wordsOf } from "../views/view.ts";
import { read } from "../link/api.ts";
import { number, say } from "../words/say.ts";
import { clockOf, type Event, lastAt, type Line, SPEEDS, stateAt } from "./line.ts";

/** A recorded flight: picture, map, messages and decisions at a time. Nothing is commanded here. */
@customElement("hawk-replay")
export class Replay extends LitElement {
  /** Seconds between two draws while it plays. */
  @property({ attribute: false }) every: (draw: (passed: number) => void) => () => void = () => () => undefined;
  @state() private line: Line | null = null;
  @state() private problem = "";
  @state() private at = 0;
  @state() private speed = 1;
  @state() private stop: (() => void) | null = null;
  @state() private map: { number: number; features: Feature[] } | null = null;
  private asked = -1;
  private drawn: Drawn | null = null;
  /** Times of the track and of the events, listed once: they are searched at every frame. */
  private times: { track: number[]; events: number[] } = { track: [], events: [] };

  protected override createRenderRoot(): HTMLElement {
    return this;
  }

  async begin(): Promise<void> {
    try {
      const line = await read<Line>("api/replay.json");
      this.times = { track: line.track.map(([at]) => at), events: line.events.map(({ at }) => at) };
      this.line = line;
    } catch (error) {
      this.problem = wordsOf(error);
    }
  }

  /** Draws again: in another language, say. */
  drawAgain(): void {
    this.requestUpdate();
  }

  override disconnectedCallback(): void {
    this.pause();
    super.disconnectedCallback();
  }

  override willUpdate(): void {
    if (this.line === null) return;
    const wanted = lastAt(this.line.maps, this.at);
    if (wanted === this.asked || wanted < 0) return;
    this.asked = wanted;
    void read<{ features: Feature[] }>(`api/replay/maps/${wanted}`).then(
      ({ features }) => {
        if (wanted === this.asked) this.map = { number: wanted, features };
      },
      () => undefined, // the map of before stays
    );
  }

  /** The list follows what is played. */
  override updated(): void {
    const now = this.querySelector<HTMLElement>("li.on");
    const list = now?.parentElement;
    if (!now || !list || this.stop === null) return;
    if (now.offsetTop < list.scrollTop || now.offsetTop > list.scrollTop + list.clientHeight - now.offsetHeight) list.scrollTop = now.offsetTop;
  }

  override render(): TemplateResult {
    const { line } = this;
    if (this.problem !== "") return html`<p role="alert">${this.problem}</p>`;
    if (line === null) return html`<p>${say("archive-asking")}</p>`;
    return html`<header><h1><span class="mark">${say("archive-replay-mark")}</span> ${line.name}</h1><p class="sub">${line.utc} · ${line.maker}</p></header>
      ${line.damage === "" ? nothing : html`<p class="warning">${say("archive-replay-damage", { why: line.damage })}</p>`}
      ${this.bar(line)}
      <main><div class="views">${this.picture(line)} ${this.plan(line)}</div>${this.events(line)}</main>`;
  }

  private bar(line: Line): TemplateResult {
    const height = line.track[lastAt(this.times.track, this.at)]?.[3];
    const drone = [stateAt(line.events, this.at), height === undefined ? "" : say("archive-replay-height", { height: number(height, 1) })].filter((each) => each !== "").join(" · ");
    return html`<section class="bar" aria-label=${say("archive-replay-mark")}>
      <button class="primary" @click=${() => this.playOrPause()}>${say(this.stop === null ? "archive-replay-play" : "archive-replay-pause")}</button>
      <label class="time"><span>${clockOf(this.at)} / ${clockOf(line.seconds)}</span>
        <input type="range" min="0" max=${line.seconds} step="0.1" .value=${String(this.at)} aria-label=${say("archive-replay-time")} aria-valuetext=${clockOf(this.at)} @input=${(event: InputEvent) => this.go(Number((event.target as HTMLInputElement).value))} /></label>
      <label>${say("archive-replay-speed")} <select @change=${(event: InputEvent) => (this.speed = Number((event.target as HTMLSelectElement).value))}>${SPEEDS.map((each) => html`<option value=${each} ?selected=${each === this.speed}>${number(each, 2, 0)} ×</option>`)}</select></label>
      <b>${drone}</b>
    </section>`;
  }

  private picture(line: Line): TemplateResult {
    const shown = lastAt(line.pictures, this.at);
    if (shown < 0) return html`<p class="none">${say("archive-replay-no-picture")}</p>`;
    return html`<img class="picture" src="api/replay/pictures/${shown}" alt=${say("archive-replay-picture", { time: clockOf(line.pictures[shown] ?? 0) })} />`;
  }

  private plan(line: Line): TemplateResult {
    const flown = lastAt(this.times.track, this.at) + 1;
    const drawn = this.map === null && flown === 0 ? null : this.drawnOf(line);
    if (drawn === null) return html`<p class="none">${say("archive-replay-no-map")}</p>`;
    const { ground, shades, places } = drawn;
    const label = say("archive-replay-map", { stalls: ground.stalls.length });
    return html`<div class="map"><archive-plan .ground=${ground} .shades=${shades} .label=${label} .over=${track(places.slice(0, flown))}></archive-plan>${stateLegend()}</div>`;
  }

  /** Once for each map: a frame of the replay only moves the drone. */
  private drawnOf(line: Line): Drawn | null {
    const { map } = this;
    if (this.drawn?.map === map) return this.drawn;
    const [first] = line.track;
    const origin = originOf(map?.features ?? []) ?? (first ? { latitude: first[1], longitude: first[2] } : null);
    if (origin === null) return null;
    const marks = line.track.map(([, latitude, longitude]): Feature => ({ id: "", geometry: { type: "Polygon", coordinates: [[[longitude, latitude], [longitude, latitude]]] }, properties: {} }));
    const flight = groundOf(marks, origin);
    const ground = withBox(groundOf(map?.features ?? [], origin), flight.box);
    this.drawn = { map, ground, shades: byState(ground.stalls), places: flight.stalls.flatMap(({ corners }) => corners.slice(0, 1)) };
    return this.drawn;
  }

  private events(line: Line): TemplateResult {
    const now = lastAt(this.times.events, this.at);
    return html`<section class="events" aria-label=${say("archive-replay-events")}><h2>${say("archive-replay-events")}</h2>
      <ol>${line.events.map((event, k) => html`<li class=${k === now ? "on" : ""}>${this.event(event, k === now)}</li>`)}</ol></section>`;
  }

  private event(event: Event, isNow: boolean): TemplateResult {
    return html`<button class="plain link" aria-current=${isNow ? "true" : "false"} @click=${() => this.go(event.at)}>${clockOf(event.at)}</button>
      <span class="kind">${say(`archive-replay-${event.kind}`)}</span> <span lang="en" class=${event.level}>${event.text}</span>`;
  }

  private go(at: number): void {
    this.at = Math.min(Math.max(0, at), this.line?.seconds ?? 0);
  }

  private playOrPause(): void {
    if (this.stop !== null) {
      this.pause();
      return;
    }
    if (this.line !== null && this.at >= this.line.seconds) this.go(0);
    this.stop = this.every((passed) => {
      this.go(this.at + passed * this.speed);
      if (this.line !== null && this.at >= this.line.seconds) this.pause();
    });
  }

  private pause(): void {
    this.stop?.();
    this.stop = null;
  }
}

/** A map with the whole track in its box, which does not move while it plays, and the places of the track. */
interface Drawn {
  map: { features: Feature[] } | null;
  ground: Ground;
  shades: readonly Shade[];
  places: readonly Point[];
}

function withBox(ground: Ground, box: Ground["box"]): Ground {
  const [left, top] = [Math.min(ground.box.left, box.left), Math.min(ground.box.top, box.top)];
  const [right, bottom] = [Math.max(ground.box.left + ground.box.width, box.left + box.width), Math.max(ground.box.top + ground.box.height, box.top + box.height)];
  return { ...ground, box: { left, top, width: right - left, height: bottom - top } };
}

/** The path that was flown so far, and the drone at its end. */
function track(places: readonly Point[]): TemplateResult | typeof nothing {
  const last = places.at(-1);
  if (last === undefined) return nothing;
  return svg`<path class="track" d=${`M${places.map(([x, y]) => `${x.toFixed(2)} ${y.toFixed(2)}`).join("L")}`}></path><circle class="drone" cx=${last[0]} cy=${last[1]} r="1.2"></circle>`;
}
