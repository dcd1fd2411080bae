import { html, nothing, type PropertyValues, svg, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import type { DroneProposals, Proposals, SurveyProposals } from "../api.ts";
import { dropChanges, dropDrone, fetchProposals, takeOver, takeOverDrone } from "../link/lots.ts";
import { isViewer } from "../words/actions.ts";
import * as format from "../words/format.ts";
import { say } from "../words/say.ts";
import { Part } from "./element.ts";
import "./lot-doubt.ts";
import { drone } from "./quoting.ts";

const BEGINS = svg`<svg class="swatch" viewBox="0 0 32 20" aria-hidden="true"><rect x="2" y="2" width="28" height="16" class="begins"/></svg>`;
const ENDS = svg`<svg class="swatch" viewBox="0 0 32 20" aria-hidden="true"><path d="M2 2H30V18H2ZL30 18M30 2L2 18" class="ends"/></svg>`;

type Changes = SurveyProposals | DroneProposals;

const named = ({ drone, base }: DroneProposals): string => `${drone} ${base}`;

/** Proposed changes of a lot, by its surveys and by drones, and surveys whose place is not certain. Sends "lot-changed". */
@customElement("hawk-lot-changes")
export class LotChangesList extends Part {
  @property() lot = "";
  /** Another one when the lot was surveyed or changed. */
  @property() stamp = "";
  @state() private found: Proposals | null = null;
  @state() private shown: string | null = null;
  @state() private withConfirmed = false;
  @state() private problem = "";

  override disconnectedCallback(): void {
    if (this.shown !== null) this.model.showChanges(null);
    super.disconnectedCallback();
  }

  override render(): TemplateResult | typeof nothing {
    const { found } = this;
    if (found === null || found.surveys.length + found.drones.length + found.doubtful.length === 0) return nothing;
    return html`<div class="changes">${found.doubtful.map((doubtful) => html`<hawk-lot-doubt .model=${this.model} .doubtful=${doubtful} @place-chosen=${this.changed}></hawk-lot-doubt>`)}
      ${found.surveys.map((survey) => this.proposal(survey))}
      ${found.drones.map((changes) => this.ofDrone(changes))}
      <div role="alert" class="sub">${this.problem === "" ? nothing : drone(this.problem)}</div></div>`;
  }

  protected override updated(changed: PropertyValues<this>): void {
    if (changed.has("lot") || changed.has("stamp")) void this.ask();
  }

  private async ask(): Promise<void> {
    this.found = (await fetchProposals(this.lot)) ?? this.found;
    if (this.shown === null) return;
    const survey = this.found?.surveys.find(({ survey }) => survey === this.shown);
    const drone = this.found?.drones.find((changes) => named(changes) === this.shown);
    this.show(this.shown, survey ?? drone ?? null);
  }

  private proposal(changes: SurveyProposals): TemplateResult {
    const confirmed = changes.end.filter((stall) => stall.is_confirmed).length;
    const what = [
      ...(changes.begin.length > 0 ? [say("stalls-begin", { stalls: changes.begin.length })] : []),
      ...(changes.end.length > 0 ? [say("stalls-end", { stalls: changes.end.length })] : []),
    ].join(", ");
    const of = say("survey-of", { when: format.day(changes.ended) });
    return this.row(what, of, changes.survey, changes, this.choices(changes, confirmed));
  }

  private ofDrone(changes: DroneProposals): TemplateResult {
    const what = [
      ...(changes.begin.length > 0 ? [say("stalls-added", { stalls: changes.begin.length })] : []),
      ...(changes.end.length > 0 ? [say("stalls-removed", { stalls: changes.end.length })] : []),
      ...(changes.change.length > 0 ? [say("stalls-changed", { stalls: changes.change.length })] : []),
      ...(changes.areas.length > 0 ? [say("areas-changed", { names: changes.areas.join(", ") })] : []),
    ].join(", ");
    const choices = html`<button @click=${() => this.act(takeOverDrone(this.lot, changes))}>${say("take-over-changes")}</button>
      <button @click=${() => this.act(dropDrone(this.lot, changes))}>${say("drop-changes")}</button>`;
    return this.row(what, say("changed-on-drone", { drone: changes.drone }), named(changes), changes, choices);
  }

  private row(what: string, of: string, name: string, changes: Changes, choices: TemplateResult): TemplateResult {
    const shown = this.shown === name;
    return html`<div class="which" role="group" aria-label=${what}>
      <span><b>${what}</b><span class="sub">${of}</span></span>
      <div class="choices">
        <button aria-pressed=${shown} @click=${() => this.show(name, shown ? null : changes)}>${say("show-on-map")}</button>
        ${this.mayChange() ? choices : nothing}
      </div>
      ${shown ? html`<div class="sub marks">${BEGINS} ${say("begins")} ${ENDS} ${say("ends")}</div>` : nothing}
    </div>`;
  }

  private choices(changes: SurveyProposals, confirmed: number): TemplateResult {
    const tick = (event: Event): void => void (this.withConfirmed = (event.currentTarget as HTMLInputElement).checked);
    return html`<button @click=${() => this.act(takeOver(this.lot, changes, this.withConfirmed))}>${say("take-over-changes")}</button>
      <button @click=${() => this.act(dropChanges(this.lot, changes.survey))}>${say("drop-changes")}</button>
      ${
        confirmed === 0
          ? nothing
          : html`<label><input type="checkbox" .checked=${this.withConfirmed} @change=${tick} /> ${say("end-confirmed", { stalls: confirmed })}</label>`
      }`;
  }

  private show(name: string, changes: Changes | null): void {
    this.shown = changes === null ? null : name;
    const places = (stalls: readonly { corners: [number, number][] }[]): { Latitude: number; Longitude: number }[][] =>
      stalls.map(({ corners }) => corners.map(([Latitude, Longitude]) => ({ Latitude, Longitude })));
    const other = changes !== null && "change" in changes ? changes.change : [];
    this.model.showChanges(changes && { begin: places([...changes.begin, ...other]), end: places(changes.end) });
  }

  private mayChange(): boolean {
    return !isViewer(this.model.view());
  }

  private async act(asked: Promise<string>): Promise<void> {
    this.problem = await asked;
    if (this.problem === "") this.withConfirmed = false;
    await this.ask();
    this.changed();
  }

  private readonly changed = (): void => void this.dispatchEvent(new CustomEvent("lot-changed", { bubbles: true }));
}
