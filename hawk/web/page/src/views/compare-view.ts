import { html, nothing, type TemplateResult } from "lit";
import { customElement, query, state } from "lit/decorators.js";
import type { Changed, ListedSection, SectionChange, SeenSections, StateChange, SurveyUse, SurveysUse } from "../api.ts";
import { icon } from "../ui/icons.ts";
import { cssVars } from "../ui/css-vars.ts";
import { swatch } from "../ui/swatch.ts";
import { whenIdle } from "../ui/when-idle.ts";
import { language, say } from "../words/say.ts";
import { changeWords, parkedInAll, parkedWords } from "../words/section.ts";
import { became, byRow, headline, inOrder, interval, notCompared } from "./compare-words.ts";
import { dayAndTime } from "./figures.ts";
import { sectionChanges } from "./sections.ts";
import "./survey-map.ts";
import type { By, SideCard, SurveyMap } from "./survey-map.ts";
import type { SurveyOnMap } from "./survey-source.ts";
import { warning } from "./surveys-view.ts";
import "./time-bar.ts";
import { Asked, View } from "./view.ts";

const NO_SECTIONS: readonly ListedSection[] = [];
const NO_CHANGES: readonly SectionChange[] = [];

type End = "before" | "after";
const ENDS = ["before", "after"] as const;
const NO_STALLS: ReadonlySet<string> = new Set();
/** Changed stalls that are listed before the map is drawn; the rest is once it is. */
const FIRST_LISTED = 40;

/** Two surveys of a lot over their pictures, and every stall that changed. */
@customElement("archive-compare")
export class CompareView extends View {
  /** Which end a press on the bar chooses. */
  @state() private end: End = "after";
  @query("hawk-survey-map") private map!: SurveyMap | null;
  @state() private listsAll = false;
  private readonly newest = new Asked<SurveysUse>(this);
  private readonly named = { before: new Asked<SurveysUse | null>(this), after: new Asked<SurveysUse | null>(this) };
  private readonly maps = { before: new Asked<SurveyOnMap | null>(this), after: new Asked<SurveyOnMap | null>(this) };
  private readonly found = new Asked<Changed>(this);
  /** Where the sections are that both surveys are compared by. */
  private readonly sections = new Asked<SeenSections>(this);
  /** Both surveys; those before stay until others are there, and the map with its place and zoom. */
  private shown: Record<End, SurveyUse> | null = null;
  private shownLot = "";
  private ids: readonly string[] = [];
  private shownOf: { changed: Changed | null; marked: ReadonlySet<string>; earlier: ReadonlyMap<string, string> } = { changed: null, marked: NO_STALLS, earlier: new Map() };

  override connectedCallback(): void {
    super.connectedCallback();
    whenIdle(() => (this.listsAll = true));
  }

  override willUpdate(): void {
    const { lot } = this.place;
    this.newest.ask(`${lot} ${this.revision}`, () => this.source.newest(), lot);
    for (const end of ENDS) {
      const id = this.place[end];
      this.named[end].ask(`${lot} ${id} ${this.revision}`, () => (id === "" ? Promise.resolve(null) : this.source.survey(id)), lot);
    }
    this.shown = this.pair() ?? (this.isWaiting() && this.shownLot === lot ? this.shown : null);
    this.shownLot = lot;
    const pair = this.shown;
    if (pair === null) return;
    for (const end of ENDS) this.maps[end].ask(`${lot} ${pair[end].id}`, () => this.source.onMap(pair[end].id));
    if ((this.found.value?.sections.length ?? 0) > 0) this.sections.ask(`${pair.after.id} ${this.revision}`, () => this.source.sections(pair.after.id));
    this.found.ask(`${pair.before.id} ${pair.after.id} ${this.revision}`, () => this.source.between(pair.before.id, pair.after.id));
  }

  private isWaiting(): boolean {
    return ENDS.some((end) => this.place[end] !== "" && this.named[end].waiting);
  }

  /** Whether the lot has no survey that the address names: it was deleted, or moved to another lot. */
  private isGone(end: End): boolean {
    return this.place[end] !== "" && !this.named[end].waiting && this.named[end].value?.surveys.length === 0;
  }

  /** Those that the address names; else the newest two that count. The earlier one is before. */
  private pair(): Record<End, SurveyUse> | null {
    const newest = this.newest.value?.surveys ?? [];
    const counted = newest.filter((row) => row.left_out_code === "");
    const of = (end: End): SurveyUse | undefined => (this.place[end] === "" ? undefined : this.named[end].value?.surveys.find(({ id }) => id === this.place[end]));
    const after = of("after") ?? (this.place.after === "" || this.isGone("after") ? counted.find(({ id }) => id !== this.place.before) : undefined);
    const before = of("before") ?? (this.place.before === "" || this.isGone("before") ? counted.find((row) => row.id !== after?.id && (after === undefined || row.at <= after.at)) : undefined);
    if (!before || !after || before.id === after.id) return null;
    return Date.parse(before.at) <= Date.parse(after.at) ? { before, after } : { before: after, after: before };
  }

  override render(): TemplateResult {
    const problem = this.newest.problem || this.named.before.problem || this.named.after.problem;
    if (problem !== "") return html`<p role="alert">${problem}</p>`;
    const { value } = this.newest;
    if (value === null) return html`<p>${say("archive-asking")}</p>`;
    const pair = this.shown;
    if (pair === null && this.isWaiting()) return html`<p>${say("archive-asking")}</p>`;
    if (pair === null) return html`<p>${say(this.place.before !== "" && this.place.before === this.place.after ? "compare-same" : "archive-two-needed")}</p>`;
    const ids = ENDS.map((end) => pair[end].id);
    if (ids.join() !== this.ids.join()) this.ids = ids;
    return html`<div class="lot compare">${this.shownMap(pair, value.clock)} ${this.about(pair, value)}
      <hawk-time-bar .source=${this.source} lot=${this.place.lot} .revision=${this.revision} .chosen=${this.ids} .ends=${ENDS.map((end) => say(`compare-end-${end}`))} .mayChange=${this.mayChange} .spoken=${language()} @survey=${(event: CustomEvent<string>) => this.choose(pair, event.detail)}></hawk-time-bar>
    </div>`;
  }

  private shownMap(pair: Record<End, SurveyUse>, clock: string): TemplateResult {
    const cards = ENDS.map((end): SideCard => ({ title: dayAndTime(pair[end].at, clock), detail: this.counted(pair[end], end) }));
    const { marked, earlier } = this.changedOnMap();
    const { by, at, stall, section } = this.place;
    const { before, after } = this.maps;
    const areHere = [before, after].every(({ value, waiting }) => value !== null || !waiting); // both are drawn at once
    return html`<hawk-survey-map .source=${areHere ? before.value : null} .later=${areHere ? after.value : null} .cards=${cards} .by=${by || "swipe"} .at=${at === "" ? 0.5 : Number(at)} .marked=${marked} .earlier=${earlier} .chosen=${stall}
      .sections=${this.sections.value?.sections ?? NO_SECTIONS} .changes=${this.found.value?.sections ?? NO_CHANGES} .section=${section} @section=${(event: CustomEvent<string>) => this.go({ section: event.detail, stall: "" })}
      .theme=${document.documentElement.dataset.theme ?? ""} @stall=${(event: CustomEvent<string>) => this.go({ stall: event.detail, section: "" })}
      @by=${(event: CustomEvent<By>) => this.go({ by: event.detail })} @at=${(event: CustomEvent<number>) => this.go({ at: String(event.detail).replace(/^0(?=\.)/, "") })}></hawk-survey-map>`;
  }

  /** Free stalls of a survey; the vehicles of the sections where the lot has no stalls. */
  private counted({ free, taken, unknown }: SurveyUse, end: End): string {
    const stalls = free + taken + unknown;
    const parked = stalls > 0 ? null : parkedInAll((this.found.value?.sections ?? []).map((each) => each[end] && { parked: each[end].parked, capacity: each.capacity }));
    return parked === null ? say("compare-free-of", { free, stalls }) : parkedWords(parked);
  }

  /** Stalls that are framed, and those with another id before: the same values while the same changes are shown. */
  private changedOnMap(): { marked: ReadonlySet<string>; earlier: ReadonlyMap<string, string> } {
    const changed = this.found.value;
    if (this.shownOf.changed !== changed) {
      const stalls = changed?.stalls ?? [];
      this.shownOf = { changed, marked: new Set(stalls.flatMap(({ id, former }) => [id, former])), earlier: new Map(stalls.map(({ id, former }) => [id, former])) };
    }
    return this.shownOf;
  }

  private about(pair: Record<End, SurveyUse>, { clock, interval: level }: SurveysUse): TemplateResult {
    const problems = [this.maps.before.problem, this.maps.after.problem, this.found.problem].filter((each) => each !== "");
    const { value } = this.found;
    return html`<section class="card about" aria-label=${say("archive-changes")}>
      <h2 class="unseen">${say("archive-changes")}</h2>
      <div class="ends" role="group" aria-label=${say("compare-ends")}>${ENDS.map(
        (end) => html`<button aria-pressed=${end === this.end} @click=${() => (this.end = end)}><span class="sub">${say(`archive-${end}`)}</span> <b>${dayAndTime(pair[end].at, clock)}</b></button>`,
      )}</div>
      <p class="sub hint">${say("compare-choose", { end: say(`archive-${this.end}`) })}</p>
      ${ENDS.map((end) => (this.isGone(end) ? html`<p role="alert">${say("compare-end-gone", { end: say(`archive-${end}`) })}</p>` : nothing))}
      ${ENDS.map((end) => warning(pair[end]))} ${problems.map((problem) => html`<p role="alert">${problem}</p>`)}
      ${value === null ? nothing : this.summary(value, level)}
    </section>`;
  }

  /** Changes by the labels that the map shows: those of the later survey's time. */
  private labelled(stalls: readonly StateChange[]): StateChange[] {
    const { ids, stalls: shown } = this.maps.after.value ?? { ids: [], stalls: [] };
    const labels = new Map(ids.map((id, k) => [id, shown[k]?.label]));
    return stalls.map((each) => ({ ...each, label: labels.get(each.id) ?? each.label })).sort((one, other) => inOrder(one.label, other.label));
  }

  private summary(found: Changed, level: number): TemplateResult {
    const { free, compared, sections } = found;
    const ofSections = sectionChanges(sections, this.place.section, (section) => this.go({ section, stall: "" }));
    const hasStalls = compared + found.unknown + found.begin.length + found.gone.length > 0;
    if (!hasStalls && sections.length > 0) return html`<p class="large"><b>${totalWords(sections)}</b></p>${ofSections}`;
    const stalls = this.labelled(found.stalls);
    let left = this.listsAll ? stalls.length : FIRST_LISTED;
    const row = (name: string, all: readonly StateChange[]): TemplateResult => {
      const listed = all.slice(0, Math.max(0, left));
      left -= listed.length;
      return html`<h3>${name === "" ? say("compare-row-none", { count: all.length }) : say("compare-row", { row: name, count: all.length })}</h3>
        <ul class="changed" ${cssVars({ "--rows": String(all.length) })}>${listed.map((each) => this.change(each))}</ul>`;
    };
    return html`<p class="large"><b>${headline(free)}</b> ${free.value === null ? nothing : say("compare-of", { stalls: compared })}</p>
      <p>${[interval(free, level), became(stalls)].filter((each) => each !== "").join(" ")}</p>
      ${notCompared(found).map((words) => html`<p class="sub">${words}</p>`)}
      ${ofSections}
      ${stalls.length === 0 ? html`<p>${say("compare-nothing")}</p>` : byRow(stalls).map(([name, all]) => row(name, all))}`;
  }

  private change({ id, label, before, after }: StateChange): TemplateResult {
    const on = id === this.place.stall;
    return html`<li><button class="plain ${on ? "on" : ""}" aria-pressed=${on} @click=${() => this.look(id)}>
      <b>${label}</b> <span class="states" aria-hidden="true">${swatch(before)}${icon("arrow")}${swatch(after)}</span> <span class="sub">${say("compare-states", { before: say(before), after: say(after) })}</span></button></li>`;
  }

  /** Shows a stall on the map, with its card. */
  private look(stall: string): void {
    this.go({ stall });
    this.map?.lookAt(stall);
  }

  /** A press on the bar: the survey becomes the end that is chosen; the other end is left alone. */
  private choose(pair: Record<End, SurveyUse>, id: string): void {
    const other = pair[this.end === "before" ? "after" : "before"].id;
    if (id === other) return;
    this.go(this.end === "before" ? { before: id, after: other } : { before: other, after: id });
  }

  /** The address says which survey is which: the earlier one is before. */
  override updated(): void {
    const pair = this.pair();
    const { before, after } = this.place;
    if (pair && !ENDS.some((end) => this.isGone(end)) && before !== "" && after !== "" && (pair.before.id !== before || pair.after.id !== after)) {
      this.end = this.end === "before" ? "after" : "before";
      this.go({ before: pair.before.id, after: pair.after.id });
    }
  }
}

/** Vehicles of all sections that both surveys saw: "9, then 12 of 20 parked". */
function totalWords(sections: readonly SectionChange[]): string {
  const both = sections.filter(({ before, after }) => before !== null && after !== null);
  const [before, after] = ENDS.map((end) => parkedInAll(both.map((each) => each[end] && { parked: each[end].parked, capacity: each.capacity })));
  if (!before || !after) return say("compare-none-seen");
  const counts = ({ parked }: { parked: number }): SectionChange["before"] => ({ parked, least: parked, most: parked });
  return changeWords({ id: "", name: "", capacity: after.capacity, before: counts(before), after: counts(after), is_changed: null });
}
