import { html, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import type { DayPlan, DayRound, ListedLot } from "../api.ts";
import { Refused } from "../link/api.ts";
import { type Forecast, planDay } from "../link/lots.ts";
import { clockWords, timeOnClock } from "../words/clock.ts";
import * as format from "../words/format.ts";
import { say } from "../words/say.ts";
import { Part } from "./element.ts";
import { drone } from "./quoting.ts";

const HOUR_MS = 3_600_000;
/** Hours of weather that the form gives: rounds of the next 24 hours, and their flights. */
const WHOLE_DAY_H = 30;
const FIELDS = ["wind", "gust", "cloud", "rain"] as const;
const HIGHEST = { wind: 100, gust: 100, cloud: 100, rain: 500 };

/** The rounds of the next 24 hours, by the schedule of the settings and a forecast. It proposes: "round-chosen" has the lots of one. */
@customElement("hawk-day-plan")
export class DayPlanForm extends Part {
  @property({ attribute: false }) lots: ListedLot[] = [];
  @state() private plan: DayPlan | null = null;
  @state() private problem = "";

  override render(): TemplateResult {
    return html`<details class="day-plan">
      <summary>${say("day-plan")}</summary>
      <form @submit=${(event: SubmitEvent) => void this.ask(event)}>
        <label class="sub">${say("day-plan-batteries")}<input type="number" name="batteries" min="1" max="100" step="1" required value="1" /></label>
        ${FIELDS.map((name) => html`<label class="sub">${say(`day-plan-${name}`)}<input type="number" name=${name} min="0" max=${HIGHEST[name]} step="any" /></label>`)}
        <label class="sub">${say("day-plan-file")}<input type="file" name="file" accept=".json,application/json" /></label>
        <button type="submit">${say("day-plan-ask")}</button>
      </form>
      <div role="status">${this.plan === null ? nothing : this.shown(this.plan)}</div>
      <div role="alert" class="sub">${this.problem === "" ? nothing : drone(this.problem)}</div>
    </details>`;
  }

  private shown(plan: DayPlan): TemplateResult {
    return html`${plan.problems.map((problem) => html`<p class="sub">${drone(problem)}</p>`)}
      ${plan.rounds.length === 0 ? html`<p class="sub">${say("day-plan-none")}</p>` : nothing}
      <ul>${plan.rounds.map((round) => this.round(round, plan.problems))}</ul>`;
  }

  private round(round: DayRound, problems: string[]): TemplateResult {
    const time = (moment: string): string => timeOnClock(moment, this.zoneOf(round), { hour: "2-digit", minute: "2-digit" });
    const names = round.lots.map(({ name }) => name).join(", ");
    const title = round.start === null || round.end === null ? say("day-plan-no-start", { names }) : say("day-plan-start", { start: time(round.start), end: time(round.end), names });
    const need = { time: format.duration(round.seconds), distance: format.distance(round.distance_m, this.model.view().units), batteries: round.batteries };
    const problem = problems.includes(round.problem) ? "" : round.problem;
    return html`<li><span><b>${title}</b><span class="sub">${say("day-plan-due", { due: time(round.due) })} · ${clockWords(this.zoneOf(round))}${round.distance_m > 0 ? ` · ${say("day-plan-need", need)}` : nothing}</span>
      ${problem === "" ? nothing : html`<span class="sub">${drone(problem)}</span>`}
      ${refused(round).map(({ from, reasons }) => html`<span class="sub">${say("day-plan-not-at", { times: from.map(time).join(", ") })} ${reasons.map((each, number) => html`${number > 0 ? "; " : ""}${drone(each)}`)}</span>`)}</span>
      ${round.start === null ? nothing : html`<button aria-label=${say("day-plan-choose-of", { names })} @click=${() => this.choose(round)}>${say("day-plan-choose")}</button>`}</li>`;
  }

  private zoneOf(round: DayRound): string {
    return this.lots.find(({ id }) => id === round.lots[0]?.id)?.time_zone ?? "UTC";
  }

  private choose(round: DayRound): void {
    this.dispatchEvent(new CustomEvent("round-chosen", { detail: round.lots.map(({ id }) => id), bubbles: true }));
  }

  private async ask(event: SubmitEvent): Promise<void> {
    event.preventDefault();
    const { elements } = event.currentTarget as HTMLFormElement;
    const field = (name: string): HTMLInputElement => elements.namedItem(name) as HTMLInputElement;
    this.plan = null;
    this.problem = "";
    try {
      const [file] = field("file").files ?? [];
      const forecast = file ? await read(file) : this.weather((name) => field(name).value);
      this.plan = await planDay(Number(field("batteries").value), forecast);
    } catch (error) {
      this.problem = error instanceof SyntaxError ? say("day-plan-no-json") : (error instanceof Refused && error.message) || say("file-unanswered");
    }
  }

  /** The weather of the fields from this hour on; null while wind or gusts are missing. The drone's clock says the time: it judges the age. */
  private weather(value: (name: string) => string): Forecast | null {
    if (value("wind") === "" || value("gust") === "") return null;
    const made = this.model.view().heartbeat?.Utc ?? new Date().toISOString();
    const begin = new Date(Math.floor(Date.parse(made) / HOUR_MS) * HOUR_MS).toISOString();
    const [wind, gust, cloud, rain] = FIELDS.map((name) => Number(value(name))) as [number, number, number, number];
    return { made, hours: [{ begin, hours: WHOLE_DAY_H, wind, gust, cloud, rain }] };
  }
}

async function read(file: File): Promise<Forecast> {
  return JSON.parse(await file.text()) as Forecast;
}

/** Times at which a round does not fit, those that follow each other with the same reasons as one. */
function refused(round: DayRound): { from: string[]; reasons: string[] }[] {
  const found: { from: string[]; reasons: string[] }[] = [];
  for (const { at, reasons } of round.hours) {
    const last = found.at(-1);
    if (reasons.length === 0) continue;
    if (last?.reasons.join() === reasons.join()) last.from.push(at);
    else found.push({ from: [at], reasons });
  }
  return found;
}
