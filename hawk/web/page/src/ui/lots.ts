import { html, nothing, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import type { ListedLot, Survey } from "../api.ts";
import { chooseClock, fetchLots, type Lots, moveSurvey, nameLot } from "../link/lots.ts";
import { cannot, isViewer } from "../words/actions.ts";
import { clockNames, clockWords, timeOnClock } from "../words/clock.ts";
import { withWords } from "../words/find.ts";
import * as format from "../words/format.ts";
import { say } from "../words/say.ts";
import "./day-plan.ts";
import { Part } from "./element.ts";
import "./lot-changes.ts";
import { drone } from "./quoting.ts";

/** As the drone allows. */
export const LONGEST_LOT_NAME = 80;

/** Rows that are shown at once: each asks the drone for the proposals of its lot. */
const FIRST = 30;

/** A row stays that of its lot when another one comes: a press must not fall on the next. */
const ID = ({ id }: { id: string }): string => id;

/** The lots that last: their names, and the question which of them a survey means. */
@customElement("hawk-lots")
export class LotsList extends Part {
  @state() private known: Lots | null = null;
  @state() private renamed: string | null = null;
  @state() private problem = "";
  /** Ids of the lots that are chosen for one flight. */
  @state() private chosen: ReadonlySet<string> = new Set();
  @state() private wanted = "";
  private askedFor = "";

  override render(): TemplateResult | typeof nothing {
    const { known } = this;
    if (known === null || known.lots.length + known.undecided.length === 0) return nothing;
    const found = withWords(known.lots, this.wanted, ({ name }) => name);
    return html`<section class="lots" aria-label=${say("lots")}>
      <div class="head"><b>${say("lots")}</b> <a class="button" href="#/lots">${say("lots-over-time")}</a></div>
      ${repeat(known.undecided, ID, (survey) => this.question(survey, known.lots))}
      ${known.lots.length > FIRST ? this.search(Math.min(found.length, FIRST), known.lots.length) : nothing}
      <ul @lot-changed=${() => this.ask()}>${repeat(
        found.slice(0, FIRST),
        ID,
        (lot) => html`<li>${this.renamed === lot.id ? this.form(lot) : this.row(lot)}
        <hawk-lot-changes .model=${this.model} .lot=${lot.id} .stamp=${known.stamp}></hawk-lot-changes></li>`,
      )}</ul>
      ${this.round(known.lots)}
      <div role="alert" class="sub">${this.problem === "" ? nothing : drone(this.problem)}</div>
    </section>`;
  }

  private search(lots: number, all: number): TemplateResult {
    return html`<label>${say("all-lots-search")} <input type="search" .value=${this.wanted} @input=${(event: Event) => (this.wanted = (event.target as HTMLInputElement).value)} /></label>
      <span class="sub" role="status">${say("all-lots-found", { lots, all })}</span>`;
  }

  /** Asks again when a message has come: each survey that was stored is one. Proposals cost the drone seconds: nothing is asked while another view is shown. */
  protected override updated(): void {
    const wanted = JSON.stringify([this.model.view().landedAt, this.model.flight.lines.length]);
    if (wanted === this.askedFor || this.closest(".away")) return;
    this.askedFor = wanted;
    void this.ask();
  }

  private async ask(): Promise<void> {
    this.known = (await fetchLots()) ?? this.known;
    if (this.known) this.dispatchEvent(new Event("lots-listed", { bubbles: true }));
  }

  private row(lot: ListedLot): TemplateResult {
    const seen = lot.last_survey === null ? "" : say("lot-seen", { when: timeOnClock(lot.last_survey.ended, lot.time_zone, { day: "numeric", month: "short", year: "numeric" }) });
    const parts = lot.stalls === 0 && lot.sections > 0 ? say("lot-sections", { sections: lot.sections }) : say("lot-stalls", { stalls: lot.stalls });
    return html`${this.choice(lot)}<span><b>${lot.name}</b><span class="sub">${parts} · ${say("lot-surveys", { surveys: lot.survey_count })} ${seen} · ${clockWords(lot.time_zone)}</span></span>
      <span class="choices">${lot.last_survey === null ? nothing : html`<a class="button" href="#/lots/${lot.id}/${lot.last_survey.id}" aria-label=${say("newest-survey-of", { name: lot.name })}>${say("newest-survey")}</a>`}
        ${this.mayChange() ? this.changing(lot) : nothing}</span>`;
  }

  private changing(lot: ListedLot): TemplateResult {
    const { plan, drawing } = this.model;
    return html`${
        this.mayFly()
          ? html`<button aria-label=${say("survey-again-of", { name: lot.name })} @click=${() => void this.again({ Lots: [lot.id] }, say("survey-again-taken", { name: lot.name }))}>${say("survey-again")}</button>`
          : nothing
      }
      <button aria-label=${say("correct-plan-of", { name: lot.name })} ?disabled=${plan.open || plan.opening || drawing !== null} @click=${() => this.correct(lot)}>${say("correct-plan")}</button>
      <button aria-label=${say("rename-lot", { name: lot.name })} @click=${() => (this.renamed = lot.id)}>${say("rename")}</button>`;
  }

  private choice(lot: ListedLot): TemplateResult | typeof nothing {
    if (!this.mayFly()) return nothing;
    return html`<input type="checkbox" aria-label=${say("choose-for-round", { name: lot.name })} .checked=${this.chosen.has(lot.id)} @change=${() => this.choose(lot.id)} />`;
  }

  private choose(lot: string): void {
    const { chosen } = this;
    this.chosen = new Set(chosen.has(lot) ? [...chosen].filter((each) => each !== lot) : [...chosen, lot]);
  }

  /** Several lots in one flight: those that are chosen, or all whose survey is due. */
  private round(lots: ListedLot[]): TemplateResult | typeof nothing {
    if (!this.mayFly() || !this.mayChange()) return nothing;
    const chosen = lots.filter((lot) => this.chosen.has(lot.id));
    const taken = say("round-taken");
    return html`<div class="choices">
      ${chosen.length > 1 ? html`<button @click=${() => void this.again({ Lots: chosen.map((lot) => lot.id) }, taken)}>${say("survey-again-round", { lots: chosen.length })}</button>` : nothing}
      <button @click=${() => void this.again({ Due: true }, taken)}>${say("survey-again-due")}</button>
    </div>
    <hawk-day-plan .model=${this.model} .lots=${lots} @round-chosen=${(event: CustomEvent<string[]>) => (this.chosen = new Set(event.detail))}></hawk-day-plan>`;
  }

  private mayFly(): boolean {
    return cannot(this.model.view(), "Survey Again") === "";
  }

  /** The drone says whether it can; take-off stays a slide. What comes next is on the map and in the bar, which a list may cover. */
  private async again(asked: { Lots?: string[]; Due?: boolean }, taken: string): Promise<void> {
    if (!(await this.model.command({ Type: "Survey Again", ...asked }, say("survey-again")))) return;
    this.chosen = new Set();
    for (const detail of ["close", "map"]) this.dispatchEvent(new CustomEvent("open-panel", { detail, bubbles: true }));
    this.model.toasts.show({ level: "info", text: taken });
  }

  /** The map comes in sight for it. */
  private correct(lot: ListedLot): void {
    this.dispatchEvent(new CustomEvent("open-panel", { detail: "map", bubbles: true }));
    this.model.editPlan(lot.id);
  }

  private form(lot: ListedLot): TemplateResult {
    return html`<form @submit=${(event: SubmitEvent) => this.save(event, lot)}>
      <input type="text" name="lot-name" aria-label=${say("name-of-lot")} maxlength=${LONGEST_LOT_NAME} .defaultValue=${lot.name} />
      <label class="sub">${say("lot-clock")}<select name="lot-clock">
        <option value="">${say("lot-clock-of-place")}</option>
        ${[...new Set([lot.time_zone, ...clockNames()])].map((zone) => html`<option ?selected=${zone === lot.time_zone}>${zone}</option>`)}
      </select></label>
      <button type="submit">${say("save")}</button>
    </form>`;
  }

  private question(survey: Survey, lots: ListedLot[]): TemplateResult {
    const candidates = lots.filter((lot) => survey.candidates.includes(lot.id));
    const choose = (lot: string | null): Promise<void> => this.change(moveSurvey(survey.id, lot));
    return html`<div class="which" role="group" aria-label=${say("which-lot")}>
      <span><b>${say("which-lot")}</b><span class="sub">${say("survey-of", { when: format.day(survey.ended) })}</span></span>
      ${
        this.mayChange()
          ? html`<div class="choices">
              ${candidates.map((lot) => html`<button @click=${() => choose(lot.id)}>${lot.name}</button>`)}
              <button @click=${() => choose(null)}>${say("a-new-lot")}</button>
            </div>`
          : nothing
      }
    </div>`;
  }

  private mayChange(): boolean {
    return !isViewer(this.model.view());
  }

  private async save(event: SubmitEvent, lot: ListedLot): Promise<void> {
    event.preventDefault();
    const fields = (event.currentTarget as HTMLFormElement).elements;
    const of = (name: string): string => (fields.namedItem(name) as HTMLInputElement | HTMLSelectElement).value;
    const [name, clock] = [of("lot-name"), of("lot-clock")];
    if (name !== lot.name) await this.change(nameLot(lot.id, name));
    else this.problem = "";
    if (clock !== lot.time_zone && this.problem === "") await this.change(chooseClock(lot.id, clock));
    if (this.problem === "") this.renamed = null;
  }

  private async change(asked: Promise<string>): Promise<void> {
    this.problem = await asked;
    await this.ask();
  }
}
