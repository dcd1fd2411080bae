import { html, nothing, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import { say } from "../words/say.ts";
import { stallRows } from "../words/stall-rows.ts";
import { Part } from "./element.ts";
import "./lots.ts";
import { sectionsTable } from "./sections-table.ts";

/** Lines that are added at a time. */
const PAGE = 50;
const COLUMNS = ["column-stall", "column-state", "column-place", "column-seen"] as const;

/** The lot's stalls and sections as tables, for those who do not see the map. */
@customElement("hawk-stalls")
export class StallsTab extends Part {
  @state() private shown = PAGE;

  override render(): TemplateResult {
    const { map, flight } = this.model;
    const lots = html`<hawk-lots .model=${this.model}></hawk-lots>`;
    const sections = sectionsTable(flight.sections);
    if (map.stalls.size === 0) return html`<div class="scroll">${lots} ${sections === nothing ? html`<p class="empty sub">${say("no-stall-yet")}</p>` : sections}</div>`;
    const { now, units } = this.model.view();
    const timeOf = (at: number): number | null => this.model.daemonClock.timeOfDay(at, this.model.seconds(), now);
    const counted = [...map.stalls.values()].filter((stall) => stall.state !== "suggested").length; // suggested ones are in no count
    const rows = stallRows(map.stalls.values(), flight.heartbeat?.Home ?? null, timeOf, units, this.shown);
    return html`<div class="scroll" tabindex="0" role="region" aria-label=${say("stalls-as-table")}>
      ${lots} ${sections}
      <table class="stalls">
        <caption class="sub">${say("stalls-caption", { stalls: counted })}</caption>
        <thead>
          <tr>${COLUMNS.map((column) => html`<th scope="col">${say(column)}</th>`)}</tr>
        </thead>
        <tbody>
          ${rows.map(
            (row) => html`<tr @click=${() => this.show(row.id)}><th scope="row"><button class="small" aria-label=${say("show-stall", { stall: row.label })}>${row.label}</button></th><td>${row.state}</td><td>${row.place}</td><td>${row.seen}</td></tr>`,
          )}
        </tbody>
      </table>
      ${map.stalls.size > this.shown ? html`<button class="small" @click=${() => (this.shown += PAGE)}>${say("show-more")}</button>` : nothing}
    </div>`;
  }

  /** Shows a stall on the map, which comes in sight for it. */
  private show(stall: number): void {
    this.dispatchEvent(new CustomEvent("open-panel", { detail: "map", bubbles: true }));
    this.model.showStall(stall);
  }
}
