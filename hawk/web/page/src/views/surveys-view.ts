import { html, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import type { ListedSection, Recording, SeenSections, SurveyUse, SurveysUse } from "../api.ts";
import { post } from "../link/api.ts";
import { SURVEY_FILES } from "../link/lots.ts";
import type { Operator } from "../state/operator.ts";
import "../ui/plan-panel.ts";
import type { CountedState, Stall } from "../state/map-store.ts";
import { language, number, say } from "../words/say.ts";
import { byRow, inOrder } from "./compare-words.ts";
import { moment, share } from "./figures.ts";
import { type Period, recordingsOf } from "./link.ts";
import "./asked-recordings.ts";
import "./changes-list.ts";
import { sectionsTable } from "../ui/sections-table.ts";
import { parkedInAll, parkedWords } from "../words/section.ts";
import "./survey-map.ts";
import type { SurveyOnMap } from "./survey-source.ts";
import "./time-bar.ts";
import { asking, Asked, View, wordsOf } from "./view.ts";

/** The surveys of a lot by date, and one of them. */
@customElement("archive-surveys")
export class SurveysView extends View {
  /** The survey that the address names, or the newest ones. */
  private readonly about = new Asked<SurveysUse>(this);
  /** Those of the days that the bar shows. */
  private readonly listed = new Asked<SurveysUse>(this);
  private period: Period | null = null;
  private readonly shown = new Asked<SurveyOnMap | null>(this);
  private readonly sections = new Asked<SeenSections>(this);
  private readonly films = new Asked<Recording[]>(this);
  @property({ attribute: false }) operator: Operator | null = null;
  /** Id of the survey whose deletion is asked about. */
  private asked = "";
  private wasPlanning = false;
  private ids: readonly string[] = [];

  override willUpdate(): void {
    const { lot, survey: named } = this.place;
    const { period } = this;
    this.about.ask(JSON.stringify([lot, named, this.revision]), () => this.read(named), lot);
    if (period) this.listed.ask(JSON.stringify([lot, period, this.revision]), () => this.source.surveys(period));
    // one that the address names is asked for at once: nobody waits for the list
    const survey = this.chosen()?.id ?? (this.about.problem === "" ? named : "");
    if (survey === "") return;
    this.shown.ask(`${lot} ${survey}`, () => this.source.onMap(survey));
    const isThere = !this.about.waiting || this.about.value === null; // it may be the one that was just deleted
    if (isThere) this.sections.ask(`${lot} ${survey} ${this.revision}`, () => this.source.sections(survey));
    this.films.ask(`${lot} ${this.revision}`, () => this.source.recordings());
  }

  override connectedCallback(): void {
    super.connectedCallback();
    this.operator?.addEventListener("change", this.planChanged);
  }

  override disconnectedCallback(): void {
    this.operator?.removeEventListener("change", this.planChanged);
    super.disconnectedCallback();
  }

  /** The plan of this lot is open: it is corrected on the survey's map. */
  private get isPlanning(): boolean {
    const { open = false, lot = null } = this.operator?.plan ?? {};
    return this.mayChange && open && lot?.id === this.place.lot;
  }

  /** What was corrected is in every list and count: they are read again when the editor is closed. */
  private readonly planChanged = (): void => {
    if (this.isPlanning === this.wasPlanning) return;
    this.wasPlanning = this.isPlanning;
    if (!this.wasPlanning) this.changed();
    this.requestUpdate();
  };

  /** A survey; the newest ones where none is named, or the lot does not have it any more. */
  private async read(named: string): Promise<SurveysUse> {
    const { source } = this;
    const one = named === "" ? null : await source.survey(named);
    return one && one.surveys.length > 0 ? one : source.newest();
  }

  /** The survey that the address names; else the newest one that counts. */
  private chosen(): SurveyUse | undefined {
    const surveys = this.about.value?.surveys ?? [];
    return surveys.find(({ id }) => id === this.place.survey) ?? surveys.find((row) => row.left_out_code === "") ?? surveys[0];
  }

  /** Whether the lot has no survey that the address names: another one is shown. */
  private isGone(shown: SurveyUse): boolean {
    return this.place.survey !== "" && shown.id !== this.place.survey && !this.about.waiting;
  }

  override render(): TemplateResult {
    const { value, problem } = this.about;
    if (problem !== "") return html`<p role="alert">${problem}</p>`;
    if (value === null) return html`<p>${say("archive-asking")}</p>`;
    if (value.surveys.length === 0) return html`<p>${say("archive-no-survey")}</p>${this.changes(value.clock)}`;
    const chosen = this.chosen();
    return html`<div class="lot">
        ${chosen ? this.one(chosen) : nothing}
        <hawk-time-bar .source=${this.source} lot=${this.place.lot} .revision=${this.revision} .chosen=${this.chosenIds(chosen)} .mayChange=${this.mayChange} .spoken=${language()}
          @survey=${(event: CustomEvent<string>) => this.go({ survey: event.detail })} @period=${(event: CustomEvent<Period>) => this.show(event.detail)}></hawk-time-bar>
      </div>
      <details class="card"><summary>${say("archive-list")}</summary>${this.table(this.listed.value?.surveys ?? [])}</details>`;
  }

  /** They undo a deletion also where it was that of the only survey. */
  private changes(clock: string): TemplateResult | typeof nothing {
    return this.mayChange ? html`<hawk-changes .source=${this.source} .place=${this.place} .revision=${this.revision} .clock=${clock} mayChange></hawk-changes>` : nothing;
  }

  private show(period: Period): void {
    this.period = period;
    this.requestUpdate();
  }

  /** The same list while the same survey is shown. */
  private chosenIds(chosen: SurveyUse | undefined): readonly string[] {
    if (this.ids[0] !== chosen?.id) this.ids = chosen ? [chosen.id] : [];
    return this.ids;
  }

  private table(surveys: SurveyUse[]): TemplateResult {
    return html`<div class="wide" tabindex="0" role="region" aria-label=${say("archive-surveys")}><table class="cards">
      <thead><tr>${(["archive-when", "archive-free", "archive-taken", "archive-unknown", "archive-occupancy", "archive-note"] as const).map((key) => html`<th scope="col">${say(key)}</th>`)}</tr></thead>
      <tbody>${surveys.map(
        (row) => html`<tr class=${row.id === this.place.survey ? "on" : ""}>
          <th scope="row"><button class="plain link" aria-pressed=${row.id === this.place.survey} @click=${() => this.go({ survey: row.id })}>${moment(row.at, this.about.value?.clock)}</button></th>
          ${named("archive-free", row.free)}${named("archive-taken", row.taken)}${named("archive-unknown", row.unknown)}
          ${named("archive-occupancy", share(row.occupancy))}<td>${notes(row)}</td>
        </tr>`,
      )}</tbody>
    </table></div>`;
  }

  private one(row: SurveyUse): TemplateResult {
    const { value } = this.shown;
    const problem = this.shown.problem || this.sections.problem;
    const sections = this.sections.value?.survey === row.id ? this.sections.value.sections : NO_SECTIONS;
    const counts = say("archive-counts", { free: row.free, taken: row.taken, unknown: row.unknown });
    const stalls = row.free + row.taken + row.unknown;
    const parked = stalls > 0 ? null : parkedInAll(sections.map(({ look }) => look)); // a lot of sections alone
    const title = say("archive-survey-of", { when: moment(row.at, this.about.value?.clock) });
    return html`<hawk-survey-map .source=${value} .chosen=${this.place.stall} .label=${parked ? parkedWords(parked) : counts} .theme=${document.documentElement.dataset.theme ?? ""} .operator=${this.operator} .isPlanning=${this.isPlanning} .sections=${sections} .section=${this.place.section} @section=${(event: CustomEvent<string>) => this.go({ section: event.detail, stall: "" })} @stall=${(event: CustomEvent<string>) => this.go({ stall: event.detail, section: "" })}></hawk-survey-map>
      ${this.isPlanning ? html`<hawk-plan .model=${this.operator} placed="survey"></hawk-plan>` : html`<section class="card about" aria-label=${title}>
        ${this.isGone(row) ? html`<p role="alert">${say("survey-gone")}</p>` : nothing}
        <h2>${title}</h2>
        ${parked ? html`<p class="large"><b>${parkedWords(parked)}</b></p>` : html`<p class="large"><b>${number(row.free)}</b> ${say("archive-free-of", { stalls })}</p>`}
        ${row.found === stalls ? nothing : html`<p class="sub">${say("survey-found", { found: row.found, stalls })}</p>`}
        ${parked ? nothing : html`<p>${counts} · ${say("archive-occupancy")} ${share(row.occupancy)}</p>`}
        ${warning(row)} ${problem === "" ? nothing : html`<p role="alert">${problem}</p>`}
        ${value === null ? nothing : rows(value)} ${sectionsTable(sections, this.place.section, (section) => this.go({ section, stall: "" }))}
        ${value?.ground?.tiles.length === 0 ? html`<p class="sub">${say("archive-no-picture")}</p>` : nothing}
        <p class="sub">${[sourceOf(row), say("archive-program", { program: row.program })].filter((each) => each !== "").join(" · ")}</p>
        ${this.recordings(row)}
        ${this.mayChange && this.source.hasRecordings ? html`<archive-asked-recordings survey=${row.id} .revision=${this.revision}></archive-asked-recordings>` : nothing}
        ${this.mayChange ? this.actions(row) : nothing}${this.changes(this.about.value?.clock ?? "UTC")}
      </section>`}`;
  }

  /** Each flight of the survey can be watched again. */
  private recordings(row: SurveyUse): TemplateResult | typeof nothing {
    const found = recordingsOf(this.films.value ?? [], row.id);
    if (found.length === 0) return nothing;
    const watch = (recording: string): void => this.go({ view: "recordings", survey: "", stall: "", section: "", show: "", recording, t: "" });
    return html`<p>${found.map(({ name, began }) => html`<button class="small" @click=${() => watch(name)}>${say("film-watch", { when: began === null ? name : moment(began, this.listed.value?.clock) })}</button> `)}</p>`;
  }

  private actions(row: SurveyUse): TemplateResult {
    const { operator } = this;
    return html`<p class="choices">
      ${operator === null ? nothing : html`<button class="small" @click=${() => operator.editPlan(this.place.lot)}>${say("edit-plan")}</button>`}
      <button class="small" @click=${() => this.go({ show: "links" })}>${say("share-lot")}</button>
      <details class="files"><summary class="small">${say("export-survey")}</summary><span role="group" aria-label=${say("archive-files")}>${SURVEY_FILES.map((kind) => html`<a class="button" href="api/v1/surveys/${row.id}/files/${kind}" download>${kind}</a>`)}</span></details>
      ${asking(this.asked === row.id, { ask: say("archive-delete-survey"), sure: say("archive-delete-survey-surely") }, (isAsked) => this.askDelete(isAsked ? row.id : ""), () => void this.delete(row))}
    </p>`;
  }

  private askDelete(id: string): void {
    this.asked = id;
    this.requestUpdate();
  }

  private async delete(row: SurveyUse): Promise<void> {
    this.asked = "";
    try {
      const { seq } = await post<{ seq: number }>(`surveys/${row.id}/delete`);
      this.go({ survey: "" });
      this.changed();
      this.said(say("archive-survey-deleted", { when: moment(row.at, this.about.value?.clock) }), () => post(`changes/${seq}/undo`));
    } catch (error) {
      this.said(wordsOf(error));
    }
  }
}

/** A cell that says its column's name where the table is shown as cards: on a phone. */
function named(column: "archive-free" | "archive-taken" | "archive-unknown" | "archive-occupancy", value: number | string): TemplateResult {
  return html`<td data-column=${say(column)}>${value}</td>`;
}

/** Counts of each row, in the order in which people count. */
function rows({ stalls }: SurveyOnMap): TemplateResult | typeof nothing {
  const found = byRow(stalls).sort(([one], [other]) => inOrder(one, other));
  if (found.length < 2) return nothing;
  const count = (all: readonly Stall[], of: CountedState): string => number(all.filter(({ state }) => state === of).length);
  return html`<table class="rows"><thead><tr><th scope="col">${say("archive-row")}</th>${COUNTED.map((state) => html`<th scope="col">${say(state)}</th>`)}</tr></thead>
    <tbody>${found.map(([row, all]) => html`<tr><th scope="row">${row || "–"}</th>${COUNTED.map((state) => html`<td>${count(all, state)}</td>`)}</tr>`)}</tbody></table>`;
}

const NO_SECTIONS: readonly ListedSection[] = [];

const COUNTED: readonly CountedState[] = ["free", "taken", "unknown"];

/** A survey that took longer than this, minutes, shows no moment: cars came and went meanwhile. */
const LONG_MIN = 30;

/** The pictures that a survey was made of, "" for a flight. */
export function sourceOf(row: SurveyUse): string {
  return row.source === "" ? "" : say(`archive-of-${row.source}`, { name: row.source_name });
}

/** The source of a survey and what limits it, why no figure uses it, that it took a long time or was seen blurred, and that it was a simulation. */
export function notes(row: SurveyUse): string {
  const why = row.left_out_code === "" ? "" : say(`archive-why-${row.left_out_code === "no_time" ? "time" : row.left_out_code === "no_looks" ? "looks" : "unregistered"}`);
  const minutes = (Date.parse(row.ended) - Date.parse(row.began)) / 60_000;
  const long = minutes > LONG_MIN ? say("archive-long", { minutes: number(minutes) }) : "";
  const blurred = row.blurred ? say("archive-blurred", { blurred: row.blurred, stalls: row.free + row.taken + row.unknown }) : "";
  return [row.simulated ? say("archive-simulated") : "", sourceOf(row), ...row.limits.map((each) => say(each === "by_gps" ? "archive-limit-by-gps" : `archive-limit-${each}`)), long, blurred, why].filter((each) => each !== "").join(" · ");
}

/** The same as a line that nobody overlooks. */
export function warning(row: SurveyUse): TemplateResult | typeof nothing {
  const words = notes({ ...row, simulated: false, source: "" });
  if (words === "") return nothing;
  return html`<p class="warning">${row.left_out_code === "" ? words : say("archive-left-out", { why: words })}</p>`;
}
