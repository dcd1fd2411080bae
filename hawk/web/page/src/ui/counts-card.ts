import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import type { Heartbeat } from "../protocol.ts";
import type { CountedState } from "../state/map-store.ts";
import { isFlying } from "../state/flight.ts";
import * as format from "../words/format.ts";
import { number, say } from "../words/say.ts";
import { linkOf, stallCount, type View } from "../words/view.ts";
import { seenPercent } from "../words/glance.ts";
import { Part } from "./element.ts";
import { swatch } from "./swatch.ts";

/** How many stalls of each kind, with the map's symbols as a legend. */
@customElement("hawk-counts")
export class CountsCard extends Part {
  override render(): TemplateResult | typeof nothing {
    const view = this.model.view();
    const heartbeat = view.heartbeat;
    if (!heartbeat || stallCount(view) + heartbeat.Suggested === 0) return nothing;
    return html`<section class="card counts" aria-label=${say("stalls")}>
      ${count("free", heartbeat.Free)} ${count("taken", heartbeat.Taken)} ${count("unknown", heartbeat.Unknown)}
      <span class="sub w">
        <span>${summary(view)}</span>
        ${between(view)} ${suggested(view)}
        ${isFlying(heartbeat) ? nothing : html`<button class="small" @click=${() => this.showSurvey()}>${say("show-survey")}</button>`}
      </span>
    </section>`;
  }

  private showSurvey(): void {
    this.dispatchEvent(new CustomEvent("open-panel", { detail: "survey", bubbles: true }));
  }
}

function count(state: CountedState, stalls: number): TemplateResult {
  return html`<div class="ct" data-count=${state}>
    ${swatch(state)}
    <div><b>${number(stalls)}</b><span class="sub">${say(`legend-${state}`)}</span></div>
  </div>`;
}

/** Explored, and seen but for a few patches: the drone gives bounds then. */
export function isSeenWhole(heartbeat: Heartbeat | null): boolean {
  return heartbeat?.["Explore Done"] === true && heartbeat["Free Range"] !== null;
}

/** The bounds of the number of free stalls, where they differ from it. */
export function between(view: View): TemplateResult | typeof nothing {
  const bounds = view.heartbeat?.["Explore Done"] === true ? view.heartbeat["Free Range"] : null; // nothing is said of ground not seen
  if (!bounds || bounds[0] === bounds[1] || linkOf(view) === "lost") return nothing;
  return html`<span data-between>${say("free-between", { low: bounds[0], high: bounds[1] })}</span>`;
}

/** The number of suggested stalls, which are in no other count. */
export function suggested(view: View): TemplateResult | typeof nothing {
  const stalls = view.heartbeat?.Suggested ?? 0;
  return stalls === 0 ? nothing : html`<span data-suggested>${swatch("suggested")} ${say("suggested-too", { stalls })}</span>`;
}

function summary(view: View): string {
  if (linkOf(view) === "lost" && view.silence !== null) {
    return say("counted-up-to", { time: format.clock(view.now - view.silence * 1000) });
  }
  const stalls = stallCount(view);
  if (isSeenWhole(view.heartbeat)) return say("stalls-found-all", { stalls });
  // while it explores the share falls when more lot comes in sight
  const seen = view.heartbeat?.["Explore Done"] === true ? seenPercent(view.heartbeat) : null;
  return seen === null ? say("stalls-found", { stalls }) : say("stalls-found-seen", { stalls, percent: format.percent(seen) });
}
