import { html, nothing, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import type { Figures, SurveysUse, Use } from "../api.ts";
import { number, say } from "../words/say.ts";
import "./curve.ts";
import { amount, bracket, share } from "./figures.ts";
import { Asked, View } from "./view.ts";

const PARTS = ["row", "zone", "kind"] as const;
type By = (typeof PARTS)[number];

/** Occupancy of a lot over the day and over weeks, and its figures by row, zone and kind. */
@customElement("archive-figures")
export class FiguresView extends View {
  @state() private by: By = "zone";
  private readonly found = new Asked<Figures>(this);
  private readonly listed = new Asked<SurveysUse>(this);

  override willUpdate(): void {
    const { from, to, lot } = this.place;
    const key = JSON.stringify([lot, from, to, this.revision]);
    this.found.ask(`${key} ${this.by}`, () => this.source.statistics({ from, to }, this.by));
    this.listed.ask(key, () => this.source.surveys({ from, to }));
  }

  override render(): TemplateResult {
    const { value, problem } = this.found;
    if (problem !== "") return html`<p role="alert">${problem}</p>`;
    if (value === null) return html`<p>${say("archive-asking")}</p>`;
    if (value.whole === null) return html`<p>${say("archive-none-counts")}</p>`;
    return html`<p>${behind(value)}</p>
      ${curves(value, this.listed.value)}
      <section class="card"><h2>${say("archive-figures")}</h2>${useTable(value.whole)}</section>
      <section class="card"><h2>${say("archive-parts")}</h2>
        <div class="segments" role="radiogroup" aria-label=${say("archive-parts")}>${PARTS.map((by) => html`<label class=${by === this.by ? "on" : ""}><input type="radio" name="by" .checked=${by === this.by} @change=${() => (this.by = by)} />${say(`archive-by-${by}`)}</label>`)}</div>
        ${partsTable(value)}
      </section>`;
  }
}

/** How many surveys stand behind the figures, and how many are left out. */
export function behind(value: Figures): string {
  const dates = { first: (value.first ?? "").slice(0, 10), last: (value.last ?? "").slice(0, 10) };
  const left = value.left_out.length === 0 ? "" : say("archive-left-out-count", { surveys: value.left_out.length });
  return `${say("archive-behind", { surveys: value.surveys, clock: value.clock, ...dates })} ${left}`.trim();
}

/** The curves of the hours of the day, and of every survey. Hours that nobody flew stay empty. */
export function curves(value: Figures, listed: SurveysUse | null): TemplateResult {
  const hours = Array.from({ length: 24 }, (_, hour) => hour);
  const none = { value: null, low: null, high: null, surveys: 0 };
  const shares = hours.map((hour) => value.hours.find((each) => each.hour === hour)?.occupancy ?? none);
  const counted = (listed?.surveys ?? []).filter((row) => row.left_out_code === "").toSorted((a, b) => a.ended.localeCompare(b.ended));
  return html`<section class="card"><h2>${say("archive-over-day")}</h2><archive-curve .at=${hours} .shares=${shares} .label=${say("archive-over-day")}></archive-curve></section>
    ${counted.length < 2 ? nothing : html`<section class="card"><h2>${say("archive-over-time")}</h2><archive-curve isTime .zone=${value.clock} .at=${counted.map((row) => Date.parse(row.ended) / 1000)} .shares=${counted.map((row) => row.occupancy)} .label=${say("archive-over-time")}></archive-curve></section>`}`;
}

/** The figures of a lot or a part of it, each with its interval. */
export function useTable(use: Use): TemplateResult {
  const { turnover, peak } = use;
  const rows: [string, string][] = [
    [say("archive-capacity"), number(use.capacity)],
    [say("archive-occupancy"), share(use.occupancy)],
    [say("archive-accumulation"), amount(use.accumulation)],
    [say("archive-load"), amount(use.load_space_hours)],
    [say("archive-peak"), peak === null ? "–" : `${peak.begin.replace("T", " ")} · ${share(peak.occupancy)}${peak.rivals > 0 ? `; ${say("archive-rivals", { hours: peak.rivals })}` : ""}`],
    ...Object.entries(use.above).map(([limit, each]): [string, string] => [say("archive-above", { limit: number(100 * Number(limit)) }), share(each)]),
    [say("archive-never"), amount(use.never_taken)],
    [say("archive-always"), amount(use.always_taken)],
    [say("archive-arrivals", { hours: number(turnover.hours, 1) }), bracket(turnover.arrivals)],
    [say("archive-stay"), bracket(turnover.stay_hours, 1)],
  ];
  return html`<table class="figures"><tbody>${rows.map(([name, words]) => html`<tr><th scope="row">${name}</th><td>${words}</td></tr>`)}</tbody></table>`;
}

/** The drone's names of what has none. */
const NAMELESS: Readonly<Record<string, () => string>> = { "": () => say("archive-unnamed"), "no zone": () => say("archive-no-zone") };

function partName(name: string): string {
  return NAMELESS[name]?.() ?? name;
}

/** A line a row, zone or kind. */
export function partsTable(value: Figures): TemplateResult {
  if (value.parts.length === 0) return html`<p>${say("archive-no-parts")}</p>`;
  return html`<div class="wide" tabindex="0" role="region" aria-label=${say("archive-parts")}><table>
    <thead><tr>${(["archive-part", "archive-capacity", "archive-occupancy", "archive-load", "archive-arrivals-short"] as const).map((key) => html`<th scope="col">${say(key)}</th>`)}</tr></thead>
    <tbody>${value.parts.map((use) => html`<tr><th scope="row">${partName(use.name)}</th><td>${number(use.capacity)}</td><td>${share(use.occupancy)}</td><td>${amount(use.load_space_hours)}</td><td>${bracket(use.turnover.arrivals)}</td></tr>`)}</tbody>
  </table></div>`;
}
