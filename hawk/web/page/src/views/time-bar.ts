import { html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import type { DirectiveResult } from "lit/directive.js";
import type { Recording, SurveyUse, SurveysUse } from "../api.ts";
import { post } from "../link/api.ts";
import { cssVars } from "../ui/css-vars.ts";
import { icon } from "../ui/icons.ts";
import { whenIdle } from "../ui/when-idle.ts";
import { onClock } from "../words/clock.ts";
import * as format from "../words/format.ts";
import { number, say } from "../words/say.ts";
import { dayWords, share, timeWords } from "./figures.ts";
import { type DeletedSurvey, type LotSource, type Period, recordingsOf } from "./link.ts";
import { type Caption, type Day, DAY_MS, dayOf, daysOf, fitting, HOUR_MS, type Hours, hoursOf, isOn, leftOf, midnightsOf, type Span, SPANS, type Tick } from "./time-bar-days.ts";
import { Asked } from "./view.ts";

/** A bar that is narrower shows three days in place of a week. */
const NARROW_PX = 560;
/** Before the bar was measured. */
const USUAL_PX = 900;
/** Days that are narrower have no hours below them; those that are still narrower a number alone. */
const HOURS_PX = 90;
const NAME_PX = 54;
const TODAY_PX = 140;
const MINUTE_MS = 60_000;
/** What is due is asked again so often: a survey may have been flown since, or none for so long that it is due no more. */
const DUE_MS = 5 * MINUTE_MS;

/** The surveys of a lot as ticks by day and hour, each filled by the share that was taken. It asks for the days that it shows. */
@customElement("hawk-time-bar")
export class TimeBar extends LitElement {
  @property({ attribute: false }) source!: LotSource;
  @property() lot = "";
  /** Rises when something was changed. */
  @property({ attribute: false }) revision = 0;
  /** Ids of the surveys that are shown: one, or two that are compared; none: the newest one's days. */
  @property({ attribute: false }) chosen: readonly string[] = [];
  /** What the chosen ones are called: before, after. */
  @property({ attribute: false }) ends: readonly string[] = [];
  /** Ids of the surveys that count for what is asked; null: all. */
  @property({ attribute: false }) marked: ReadonlySet<string> | null = null;
  /** Share that is taken of what is asked, 0 to 1, by survey; null: of the lot. */
  @property({ attribute: false }) shares: ReadonlyMap<string, number> | null = null;
  @property({ attribute: false }) mayChange = false;
  /** Draws the bar again in another language. */
  @property() spoken = "";
  @state() private span: Span = "week";
  /** A moment of the lot's clock in the days that are shown; null: that of what was chosen last. */
  @state() private anchor: number | null = null;
  @state() private width = USUAL_PX;
  private followed = "";
  /** A survey whose tick gets the focus when it is there. */
  private awaited = "";
  private zone = "UTC";
  private shown = "";
  private ticking = 0;
  /** What the view is for is drawn first. */
  private mayAsk = false;
  private readonly about = new Asked<SurveysUse>(this);
  private readonly listed = new Asked<SurveysUse>(this);
  private readonly deleted = new Asked<DeletedSurvey[]>(this);
  private readonly due = new Asked<string[]>(this);
  private readonly films = new Asked<Recording[]>(this);
  private readonly watch = new ResizeObserver(([entry]) => {
    const width = entry?.contentRect.width ?? 0;
    if (width > 0) this.width = width;
  });

  protected override createRenderRoot(): HTMLElement {
    return this;
  }

  override connectedCallback(): void {
    super.connectedCallback();
    this.ticking = window.setInterval(() => this.requestUpdate(), MINUTE_MS);
    whenIdle(() => {
      this.mayAsk = true;
      this.requestUpdate();
    });
  }

  override disconnectedCallback(): void {
    clearInterval(this.ticking);
    this.watch.disconnect();
    super.disconnectedCallback();
  }

  override willUpdate(changed: PropertyValues<this>): void {
    if (changed.has("chosen")) {
      const before = changed.get("chosen") ?? [];
      const other = this.chosen.find((id) => !before.includes(id));
      if (other !== undefined) [this.followed, this.anchor] = [other, null];
      if (!this.chosen.includes(this.followed)) this.followed = this.chosen.at(-1) ?? "";
    }
    const { source, lot, revision, followed } = this;
    this.about.ask(`${lot} ${followed} ${revision}`, () => (followed === "" ? source.newest() : source.survey(followed)));
    this.zone = this.about.value?.clock ?? this.zone;
    if (this.about.value === null || !this.mayAsk) return;
    const period = this.period();
    const key = JSON.stringify([lot, period, revision]);
    this.listed.ask(key, () => source.surveys(period));
    this.deleted.ask(key, () => source.deleted(period));
    this.due.ask(`${lot} ${revision} ${Math.floor(Date.now() / DUE_MS)}`, () => source.due());
    this.films.ask(lot, () => source.recordings());
  }

  private midnights(): number[] {
    const survey = this.about.value?.surveys[0];
    const at = this.anchor ?? onClock(survey?.at ?? Date.now(), this.zone);
    return midnightsOf(at, this.span, this.width < NARROW_PX);
  }

  private period(): Period {
    const all = this.midnights();
    return { from: dayOf(all[0] ?? 0), to: dayOf(all.at(-1) ?? 0) };
  }

  override updated(): void {
    const days = this.querySelector(".days");
    if (days) this.watch.observe(days);
    this.focusAwaited();
    if (this.about.value === null || !this.mayAsk) return;
    const period = this.period();
    if (JSON.stringify(period) === this.shown) return;
    this.shown = JSON.stringify(period);
    this.dispatchEvent(new CustomEvent<Period>("period", { detail: period, bubbles: true }));
  }

  private focusAwaited(): void {
    const tick = this.awaited === "" || !this.chosen.includes(this.awaited) ? null : this.querySelector<HTMLElement>(`[data-surveys~="${this.awaited}"]`);
    if (!tick) return;
    this.awaited = "";
    tick.focus();
  }

  override render(): TemplateResult | typeof nothing {
    const problem = this.about.problem || this.listed.problem;
    if (problem !== "") return html`<p role="alert">${problem}</p>`;
    if (this.about.value === null || !this.mayAsk) return html`<section class="timebar" aria-label=${say("time-bar")} aria-busy="true"></section>`;
    const midnights = this.midnights();
    const dayWidth = this.width / midnights.length;
    const inSight = (clock: number): boolean => clock >= (midnights[0] ?? 0) && clock < (midnights.at(-1) ?? 0) + DAY_MS;
    const clocks = (all: readonly string[]): number[] => all.map((each) => onClock(each, this.zone)).filter(inSight);
    const surveys = (this.listed.value?.surveys ?? []).filter(({ at }) => inSight(onClock(at, this.zone)));
    const due = clocks(this.due.value ?? []);
    const hours = hoursOf([...clocks([...surveys.map(({ at }) => at), ...(this.deleted.value ?? []).map(({ ended }) => ended)]), ...due]);
    const days = daysOf(surveys, midnights, this.zone, hours, dayWidth, (each) => this.shareOf(each));
    const isKnown = this.listed.value !== null;
    return html`<section class="timebar" aria-label=${say("time-bar")}>
      ${this.steps(midnights)}
      <div class="frame"><ol class="days ${this.span}" @keydown=${(event: KeyboardEvent) => this.key(event)}>${days.map((day) => this.day(day, { hours, dayWidth, due, isKnown }))}</ol>
      <div class="captions" aria-hidden="true">${this.captions(days, hours, dayWidth, due).map(({ left, text, tone }) => html`<span class=${tone} ${atPx(left)}>${text}</span>`)}</div></div>
    </section>`;
  }

  private steps(midnights: readonly number[]): TemplateResult {
    const to = (clock: number): void => {
      this.anchor = clock;
    };
    const film = this.film(this.followed);
    const names: Record<Span, string> = { day: say("time-bar-day"), week: this.width < NARROW_PX ? say("time-bar-few") : say("time-bar-week"), month: say("time-bar-month") };
    return html`<div class="steps">
      <div class="spans" role="group" aria-label=${say("time-bar-span")}>${SPANS.map(
        (span) => html`<button aria-pressed=${span === this.span} @click=${() => [this.anchor, this.span] = [this.anchor ?? this.clockOf(this.followed), span]}>${names[span]}</button>`,
      )}</div>
      <button class="icononly" aria-label=${say("time-bar-before")} @click=${() => to((midnights[0] ?? 0) - 1)}>${icon("left")}</button>
      ${this.films.value?.length ? html`<button class="icononly" aria-label=${say("time-bar-play")} ?disabled=${film === undefined} @click=${() => this.play()}>${icon("play")}</button>` : nothing}
      <button class="icononly" aria-label=${say("time-bar-after")} @click=${() => to((midnights.at(-1) ?? 0) + DAY_MS)}>${icon("next")}</button>
    </div>`;
  }

  private day({ date, ticks }: Day, { hours, dayWidth, due, isKnown }: { hours: Hours; dayWidth: number; due: readonly number[]; isKnown: boolean }): TemplateResult {
    const now = onClock(Date.now(), this.zone);
    const isToday = isOn(now, date);
    const deleted = (this.deleted.value ?? []).map((each) => ({ ...each, clock: onClock(each.ended, this.zone) })).filter(({ clock }) => isOn(clock, date));
    const isEmpty = isKnown && ticks.length === 0 && deleted.length === 0 && date + DAY_MS <= now;
    const words = dayWords(date, dayWidth < NAME_PX ? { day: "numeric", ...(new Date(date).getUTCDate() === 1 ? { month: "short" } : {}) } : { weekday: "short", day: "numeric", ...(dayWidth < HOURS_PX ? {} : { month: "short" }) });
    const name = isToday && dayWidth >= TODAY_PX ? say("time-bar-today", { day: words }) : words;
    const left = (clock: number): DirectiveResult => atPx(leftOf(clock, hours, dayWidth));
    return html`<li class="${isEmpty ? "none" : ""} ${isToday ? "today" : ""}"><b>${name}</b>
      <div class="hours">${isEmpty ? html`<span class="unseen">${say("time-bar-nobody")}</span>` : nothing}
        ${ticks.map((tick) => this.tick(tick, date))}
        ${deleted.map((each) => this.deletedTick(each, leftOf(each.clock, hours, dayWidth)))}
        ${due.filter((clock) => isOn(clock, date)).map((clock) => html`<span class="tick due" role="img" aria-label=${this.dueWords(clock)} title=${this.dueWords(clock)} ${left(clock)}><i></i></span>`)}
        ${isToday && leftOf(now, hours, dayWidth) >= 0 && leftOf(now, hours, dayWidth) <= dayWidth ? html`<span class="now" ${left(now)}></span>` : nothing}
      </div>
      <div class="axis" aria-hidden="true">${dayWidth < HOURS_PX ? nothing : axisOf(hours, dayWidth).map((hour) => html`<span ${left(date + hour * HOUR_MS)}>${number(hour)}</span>`)}</div></li>`;
  }

  private tick(tick: Tick, date: number): TemplateResult {
    const { survey, left, clock, ids, share: part } = tick;
    const on = this.chosen.some((id) => ids.includes(id));
    const counts = this.marked === null || ids.some((id) => this.marked?.has(id));
    const isMany = ids.length > 1;
    const words = this.shares ? share0(part) : survey.left_out_code === "" ? `${say("archive-occupancy")} ${share(survey.occupancy)}` : say("time-bar-not-counted");
    const end = this.ends.filter((_, index) => ids.includes(this.chosen[index] ?? "")).join(", ");
    const label = isMany && this.span !== "day" ? say("time-bar-open-day", { count: ids.length, time: clock }) : [end, clock, words, isMany ? say("time-bar-more", { count: ids.length - 1 }) : ""].filter((each) => each !== "").join(", ");
    return html`<button class="tick ${on ? "on" : ""} ${counts ? "" : "pale"}" aria-pressed=${on} data-surveys=${ids.join(" ")} title=${label} aria-label=${label}
      ${cssVars({ "--at": `${left}px`, "--full": `${100 * (part ?? 0)}%` })} @click=${() => this.press(tick, date)}>
      <i class=${part === null ? "unknown" : ""}></i>${isMany ? html`<span class="count" aria-hidden="true">${number(ids.length)}</span>` : nothing}</button>`;
  }

  private deletedTick({ ended, seq }: DeletedSurvey, left: number): TemplateResult {
    const words = say("time-bar-deleted", { time: timeWords(onClock(ended, this.zone)) });
    const back = async (): Promise<void> => {
      await post(`changes/${seq}/undo`);
    };
    const said = (): boolean => this.dispatchEvent(new CustomEvent("archive-said", { detail: { text: words, undo: back, name: say("time-bar-bring-back") }, bubbles: true }));
    const label = this.mayChange ? `${words}. ${say("time-bar-bring-back")}` : words;
    return html`<button class="tick deleted" title=${label} aria-label=${label} ?disabled=${!this.mayChange} ${atPx(left)} @click=${said}><i></i></button>`;
  }

  /** The chosen ones first, then what is due next, then what was deleted. */
  private captions(days: readonly Day[], hours: Hours, dayWidth: number, due: readonly number[]): Caption[] {
    const placed = (clock: number): number => dayWidth * days.findIndex(({ date }) => isOn(clock, date)) + leftOf(clock, hours, dayWidth);
    const on = days.flatMap(({ ticks }, index) =>
      ticks.filter(({ ids }) => this.chosen.some((id) => ids.includes(id))).map(({ ids, left }): Caption => {
        const time = ids.filter((id) => this.chosen.includes(id)).map((id) => timeWords(this.clockOf(id) ?? 0)).join(", ");
        const end = this.ends.filter((_, each) => ids.includes(this.chosen[each] ?? "")).join(", ");
        return { left: index * dayWidth + left, text: end === "" ? time : `${end} ${time}`, tone: "on" };
      }),
    );
    const next = due.length === 0 ? [] : [{ left: placed(due[0] ?? 0), text: this.dueWords(due[0] ?? 0), tone: "due" as const }];
    const gone = (this.deleted.value ?? []).map(({ ended }): Caption => ({ left: placed(onClock(ended, this.zone)), text: say("time-bar-deleted", { time: timeWords(onClock(ended, this.zone)) }), tone: "" }));
    return fitting([...on.reverse(), ...next, ...(dayWidth < NAME_PX ? [] : gone)], this.width);
  }

  private clockOf(id: string): number | null {
    const row = [...(this.listed.value?.surveys ?? []), ...(this.about.value?.surveys ?? [])].find((each) => each.id === id);
    return row ? onClock(row.at, this.zone) : null;
  }

  private dueWords(clock: number): string {
    const left = (clock - onClock(Date.now(), this.zone)) / 1000;
    if (left < 0) return say("time-bar-due-since", { time: timeWords(clock) });
    const minutes = Math.ceil(left / 60);
    return left < DAY_MS / 1000 ? say("time-bar-due-in", { hours: Math.floor(minutes / 60), minutes: minutes % 60 }) : say("time-bar-due", { time: timeWords(clock) });
  }

  private shareOf(row: SurveyUse): number | null {
    return this.shares ? (this.shares.get(row.id) ?? null) : row.occupancy.value;
  }

  /** Of several that lie too near each other: their day opens; in that day one is chosen after the other. */
  private press({ ids }: Tick, date: number): void {
    if (ids.length > 1 && this.span !== "day") {
      [this.span, this.anchor] = ["day", date];
      return;
    }
    const at = ids.findIndex((id) => this.chosen.includes(id));
    this.pick(ids[(at + 1) % ids.length] ?? "");
  }

  /** Arrows go from survey to survey, whatever days they lie in; Enter on the one that is chosen plays it. */
  private key(event: KeyboardEvent): void {
    if (event.key === "Enter" && (event.target as HTMLElement).matches(".tick.on") && this.film(this.followed)) {
      event.preventDefault();
      this.play();
      return;
    }
    const step = event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0;
    if (step === 0) return;
    event.preventDefault();
    const next = this.beside(step);
    if (next === undefined) return;
    this.awaited = next;
    this.pick(next);
  }

  private beside(step: 1 | -1): string | undefined {
    const all = (this.listed.value?.surveys ?? []).toSorted((one, other) => Date.parse(one.at) - Date.parse(other.at));
    const at = all.findIndex(({ id }) => id === this.followed);
    if (at >= 0 && all[at + step]) return all[at + step]?.id;
    const { before, after } = (at >= 0 ? this.listed.value : this.about.value) ?? {};
    return (step > 0 ? after : before)?.id;
  }

  private pick(survey: string): void {
    this.dispatchEvent(new CustomEvent<string>("survey", { detail: survey, bubbles: true }));
  }

  /** The recording of a survey's flight. */
  private film(id: string): Recording | undefined {
    return recordingsOf(this.films.value ?? [], id)[0];
  }

  private play(): void {
    const recording = this.film(this.followed)?.name;
    this.dispatchEvent(new CustomEvent("archive-go", { detail: { view: "recordings", recording, stall: "", section: "", t: "" }, bubbles: true }));
  }
}

/** Puts a mark so far from its day's begin. */
const atPx = (left: number): DirectiveResult => cssVars({ "--at": `${left}px` });

/** Hours that have room below a day. */
function axisOf([first, last]: Hours, width: number): number[] {
  const step = [1, 2, 4, 6, 12].find((each) => (width * each) / (last - first) >= 32) ?? 12;
  return Array.from({ length: 24 / step }, (_, index) => index * step).filter((hour) => hour > first && hour < last);
}

function share0(part: number | null): string {
  return part === null ? say("time-bar-not-counted") : `${say("archive-occupancy")} ${format.percent(100 * part)}`;
}
