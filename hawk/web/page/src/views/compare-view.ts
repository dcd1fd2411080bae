import { html, nothing, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import type { Changed, SurveyUse, SurveysUse } from "../api.ts";
import { cssVars } from "../ui/css-vars.ts";
import { percent } from "../words/format.ts";
import { say } from "../words/say.ts";
import { amount, moment } from "./figures.ts";
import { type Ground, groundOf, originOf } from "./ground.ts";
import type { Features } from "./survey-source.ts";
import { byState } from "./plan-view.ts";
import "./plan-view.ts";
import { stateLegend, warning } from "./surveys-view.ts";
import { Asked, View } from "./view.ts";

/** Two surveys of a lot, by swipe and by list. */
@customElement("archive-compare")
export class CompareView extends View {
  @state() private share = 50;
  private readonly listed = new Asked<SurveysUse>(this);
  private readonly one = new Asked<Features>(this);
  private readonly other = new Asked<Features>(this);
  private readonly found = new Asked<Changed>(this);

  override willUpdate(): void {
    const { from, to, lot } = this.place;
    this.listed.ask(JSON.stringify([lot, from, to, this.revision]), () => this.source.surveys({ from, to }));
    const pair = this.pair();
    if (pair === null) return;
    const [before, after] = pair;
    this.one.ask(before.id, () => this.source.features(before.id));
    this.other.ask(after.id, () => this.source.features(after.id));
    this.found.ask(`${before.id} ${after.id} ${this.revision}`, () => this.source.between(before.id, after.id));
  }

  /** Those that were chosen; else the newest two that count. */
  private pair(): [SurveyUse, SurveyUse] | null {
    const surveys = this.listed.value?.surveys ?? [];
    const counted = surveys.filter((row) => row.left_out_code === "");
    const named = (id: string): SurveyUse | undefined => surveys.find((row) => row.id === id);
    const after = named(this.place.after) ?? counted[0];
    const before = named(this.place.before) ?? counted.find((row) => row.id !== after?.id && (after === undefined || row.ended <= after.ended));
    return before && after ? [before, after] : null;
  }

  override render(): TemplateResult {
    const { value, problem } = this.listed;
    if (problem !== "") return html`<p role="alert">${problem}</p>`;
    if (value === null) return html`<p>${say("archive-asking")}</p>`;
    const pair = this.pair();
    if (pair === null) return html`<p>${say("archive-two-needed")}</p>`;
    const [before, after] = pair;
    return html`<div class="fields">
        ${this.choice("before", before, value.surveys)} ${this.choice("after", after, value.surveys)}
      </div>
      ${[before, after].map((row) => warning(row))} ${this.swipe(before, after)} ${this.list()}`;
  }

  private choice(end: "before" | "after", chosen: SurveyUse, surveys: SurveyUse[]): TemplateResult {
    return html`<label>${say(`archive-${end}`)}
      <select @change=${(event: Event) => this.go({ [end]: (event.target as HTMLSelectElement).value })}>
        ${surveys.map((row) => html`<option value=${row.id} ?selected=${row.id === chosen.id}>${moment(row.ended, this.listed.value?.clock)}</option>`)}
      </select></label>`;
  }

  private swipe(before: SurveyUse, after: SurveyUse): TemplateResult | typeof nothing {
    const [one, other] = [this.one.value, this.other.value];
    const origin = originOf([...(one?.features ?? []), ...(other?.features ?? [])]);
    const problem = this.one.problem || this.other.problem;
    if (problem !== "") return html`<p role="alert">${problem}</p>`;
    if (one === null || other === null || origin === null) return nothing;
    const [first, second] = [groundOf(one.features, origin), groundOf(other.features, origin)];
    const ground = [first, second].map((each): Ground => ({ ...each, box: around(first, second) }));
    const label = (row: SurveyUse): string => `${moment(row.ended, this.listed.value?.clock)}: ${say("archive-counts", { free: row.free, taken: row.taken, unknown: row.unknown })}`;
    return html`<div class="swipe" ${cssVars({ "--share": `${this.share}%` })}>
        <archive-plan .ground=${ground[0]} .shades=${byState(first.stalls)} .label=${label(before)}></archive-plan>
        <archive-plan class="over" .ground=${ground[1]} .shades=${byState(second.stalls)} .label=${label(after)}></archive-plan>
      </div>
      <label class="slider"><span>${say("archive-swipe", { before: moment(before.ended, this.listed.value?.clock), after: moment(after.ended, this.listed.value?.clock) })}</span>
        <input type="range" min="0" max="100" .value=${String(this.share)} @input=${(event: Event) => (this.share = Number((event.target as HTMLInputElement).value))} /></label>
      ${stateLegend()}`;
  }

  private list(): TemplateResult | typeof nothing {
    const { value, problem } = this.found;
    if (problem !== "") return html`<p role="alert">${problem}</p>`;
    if (value === null) return nothing;
    const named = (taken: boolean): string => value.stalls.filter((each) => each.taken === taken).map(({ label }) => label).join(", ");
    return html`<section class="card"><h2>${say("archive-changes")}</h2>
      <p>${say("archive-compared", { compared: value.compared, unknown: value.unknown })}</p>
      <dl>
        <dt>${say("archive-came")}: ${amount(value.came)}</dt><dd>${named(true)}</dd>
        <dt>${say("archive-went")}: ${amount(value.left)}</dt><dd>${named(false)}</dd>
      </dl>
      <div class="wide" tabindex="0" role="region" aria-label=${say("archive-changes")}><table>
        <thead><tr><th scope="col">${say("archive-stall")}</th><th scope="col">${say("archive-now")}</th><th scope="col">${say("archive-both-right")}</th></tr></thead>
        <tbody>${value.stalls.map((each) => html`<tr><th scope="row">${each.label}</th><td>${say(each.taken ? "archive-state-taken" : "archive-state-free")}</td><td>${percent(100 * each.chance)}</td></tr>`)}</tbody>
      </table></div></section>`;
  }
}

function around({ box: a }: Ground, { box: b }: Ground): Ground["box"] {
  const [left, top] = [Math.min(a.left, b.left), Math.min(a.top, b.top)];
  return { left, top, width: Math.max(a.left + a.width, b.left + b.width) - left, height: Math.max(a.top + a.height, b.top + b.height) - top };
}
