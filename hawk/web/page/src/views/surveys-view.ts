import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import type { SurveyUse, SurveysUse } from "../api.ts";
import { post } from "../link/api.ts";
import { SURVEY_FILES } from "../link/lots.ts";
import { number, say } from "../words/say.ts";
import { moment, share } from "./figures.ts";
import { groundOf, originOf } from "./ground.ts";
import type { Features } from "./link.ts";
import { byState } from "./plan-view.ts";
import "./plan-view.ts";
import { Asked, View, wordsOf } from "./view.ts";

/** The surveys of a lot by date, and one of them. */
@customElement("archive-surveys")
export class SurveysView extends View {
  private readonly listed = new Asked<SurveysUse>(this);
  private readonly shown = new Asked<Features>(this);

  override willUpdate(): void {
    const { from, to, lot } = this.place;
    this.listed.ask(JSON.stringify([lot, from, to, this.revision]), () => this.source.surveys({ from, to }));
    const { survey } = this.place;
    if (survey !== "") this.shown.ask(`${lot} ${survey}`, () => this.source.features(survey));
  }

  override render(): TemplateResult {
    const { value, problem } = this.listed;
    if (problem !== "") return html`<p role="alert">${problem}</p>`;
    if (value === null) return html`<p>${say("archive-asking")}</p>`;
    if (value.surveys.length === 0) return html`<p>${say("archive-no-survey")}</p>`;
    const chosen = value.surveys.find(({ id }) => id === this.place.survey);
    return html`${chosen ? this.one(chosen) : nothing} ${this.table(value.surveys)}`;
  }

  private table(surveys: SurveyUse[]): TemplateResult {
    return html`<div class="wide" tabindex="0" role="region" aria-label=${say("archive-surveys")}><table class="cards">
      <thead><tr>${(["archive-when", "archive-free", "archive-taken", "archive-unknown", "archive-occupancy", "archive-note"] as const).map((key) => html`<th scope="col">${say(key)}</th>`)}</tr></thead>
      <tbody>${surveys.map(
        (row) => html`<tr class=${row.id === this.place.survey ? "on" : ""}>
          <th scope="row"><button class="plain link" aria-pressed=${row.id === this.place.survey} @click=${() => this.go({ survey: row.id })}>${moment(row.ended)}</button></th>
          ${named("archive-free", row.free)}${named("archive-taken", row.taken)}${named("archive-unknown", row.unknown)}
          ${named("archive-occupancy", share(row.occupancy))}<td>${notes(row)}</td>
        </tr>`,
      )}</tbody>
    </table></div>`;
  }

  private one(row: SurveyUse): TemplateResult {
    const { value, problem } = this.shown;
    return html`<section class="card" aria-label=${say("archive-survey-of", { when: moment(row.ended) })}>
      <h2>${say("archive-survey-of", { when: moment(row.ended) })}</h2>
      ${warning(row)}
      <p><b>${say("archive-counts", { free: row.free, taken: row.taken, unknown: row.unknown })}</b> · ${say("archive-occupancy")} ${share(row.occupancy)}</p>
      ${problem === "" ? nothing : html`<p role="alert">${problem}</p>`}
      ${value === null ? nothing : drawn(value, row)}
      <p class="sub">${[sourceOf(row), row.program].filter((each) => each !== "").join(" · ")}</p>
      ${this.mayChange ? this.actions(row) : nothing}
    </section>`;
  }

  private actions(row: SurveyUse): TemplateResult {
    return html`<p class="choices">
      <span role="group" aria-label=${say("archive-files")}>${SURVEY_FILES.map((kind) => html`<a href="api/v1/surveys/${row.id}/files/${kind}" download>${kind}</a> `)}</span>
      <button class="small" @click=${() => void this.delete(row)}>${say("archive-delete-survey")}</button>
    </p>`;
  }

  private async delete(row: SurveyUse): Promise<void> {
    try {
      const { seq } = await post<{ seq: number }>(`surveys/${row.id}/delete`);
      this.go({ survey: "" });
      this.changed();
      this.said(say("archive-survey-deleted", { when: moment(row.ended) }), () => post(`changes/${seq}/undo`));
    } catch (error) {
      this.said(wordsOf(error));
    }
  }
}

/** A cell that says its column's name where the table is shown as cards: on a phone. */
function named(column: "archive-free" | "archive-taken" | "archive-unknown" | "archive-occupancy", value: number | string): TemplateResult {
  return html`<td data-column=${say(column)}>${value}</td>`;
}

function drawn(features: Features, row: SurveyUse): TemplateResult | typeof nothing {
  const origin = originOf(features.features);
  if (origin === null) return nothing;
  const ground = groundOf(features.features, origin);
  const label = say("archive-counts", { free: row.free, taken: row.taken, unknown: row.unknown });
  return html`<archive-plan .ground=${ground} .shades=${byState(ground.stalls)} .label=${label}></archive-plan>${stateLegend()}`;
}

/** What the colours of states mean. */
export function stateLegend(): TemplateResult {
  return html`<p class="legend">${(["free", "taken", "unknown"] as const).map((name) => html`<span><i class="key ${name}"></i>${say(`archive-${name}`)}</span>`)}</p>`;
}

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
