import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import type { Figures, SurveyUse, SurveysUse } from "../api.ts";
import { say } from "../words/say.ts";
import { behind, curves, partsTable, useTable } from "./figures-view.ts";
import { moment, share } from "./figures.ts";
import { groundOf, originOf } from "./ground.ts";
import type { Features } from "./survey-source.ts";
import { byState } from "./plan-view.ts";
import "./plan-view.ts";
import { sourceOf, stateLegend, warning } from "./surveys-view.ts";
import { Asked, View } from "./view.ts";

/** A lot on paper: map, counts with intervals, curves, zones, method and limits. */
@customElement("archive-report")
export class ReportView extends View {
  private readonly found = new Asked<Figures>(this);
  private readonly listed = new Asked<SurveysUse>(this);
  private readonly shown = new Asked<Features>(this);

  override willUpdate(): void {
    const { from, to, lot } = this.place;
    const key = JSON.stringify([lot, from, to, this.revision]);
    this.found.ask(key, () => this.source.statistics({ from, to }, "zone"));
    this.listed.ask(key, () => this.source.surveys({ from, to }));
    const row = this.row();
    if (row) this.shown.ask(row.id, () => this.source.features(row.id));
  }

  /** The survey that was chosen; else the newest one that counts. */
  private row(): SurveyUse | undefined {
    const surveys = this.listed.value?.surveys ?? [];
    return surveys.find(({ id }) => id === this.place.survey) ?? surveys.find((row) => row.left_out_code === "");
  }

  override render(): TemplateResult {
    const problem = this.found.problem || this.listed.problem || this.shown.problem;
    if (problem !== "") return html`<p role="alert">${problem}</p>`;
    const [found, listed] = [this.found.value, this.listed.value];
    if (found === null || listed === null) return html`<p>${say("archive-asking")}</p>`;
    const row = this.row();
    return html`<article class="report">
        <h2>${listed.name}</h2>
        <p>${behind(found)}</p>
        ${row ? this.newest(row) : nothing}
        ${found.whole === null ? html`<p>${say("archive-none-counts")}</p>` : html`${useTable(found.whole)} ${curves(found, listed)}`}
        ${found.parts.length < 2 ? nothing : html`<h3>${say("archive-by-zone")}</h3>${partsTable(found)}`}
        <h3>${say("archive-method")}</h3><p>${method(listed.surveys, listed.clock)} ${say("archive-method-words")}</p>
        <h3>${say("archive-limits")}</h3><p>${say("archive-limits-words")}</p>
        <p class="sub">${row?.program ?? ""}</p>
      </article>`;
  }

  private newest(row: SurveyUse): TemplateResult {
    const origin = originOf(this.shown.value?.features ?? []);
    const ground = origin === null ? null : groundOf(this.shown.value?.features ?? [], origin);
    const counts = say("archive-counts", { free: row.free, taken: row.taken, unknown: row.unknown });
    return html`<h3>${say("archive-survey-of", { when: moment(row.ended, this.listed.value?.clock) })}</h3>${warning(row)}
      <p><b>${counts}</b> · ${say("archive-occupancy")} ${share(row.occupancy)}</p>
      ${ground === null ? nothing : html`<archive-plan .ground=${ground} .shades=${byState(ground.stalls)} .label=${counts}></archive-plan>${stateLegend()}`}`;
  }
}

/** Who took the pictures: the drone, or others, with their dates. */
function method(surveys: SurveyUse[], clock: string): string {
  const taken = surveys.filter(({ source }) => source !== "").map((row) => say("archive-method-source", { source: sourceOf(row), when: moment(row.ended, clock) }));
  const flown = surveys.some(({ source }) => source === "") ? [say("archive-method-flown")] : [];
  return [...flown, ...taken].join(" ");
}
