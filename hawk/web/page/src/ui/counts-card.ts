import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import type { Heartbeat } from "../protocol.ts";
import type { CountedState } from "../state/map-store.ts";
import { isFlying } from "../state/flight.ts";
import * as format from "../words/format.ts";
import { number, say } from "../words/say.ts";
import { parkedInAll, parkedWords, roomInAll, roomWords } from "../words/section.ts";
import { linkOf, stallCount, type View } from "../words/view.ts";
import { seenPercent } from "../words/glance.ts";
import { Part } from "./element.ts";
import { swatch } from "./swatch.ts";

/** How many stalls of each kind, with the map's symbols as a legend; of a lot of sections alone how many vehicles are parked. */
@customElement("hawk-counts")
export class CountsCard extends Part {
  override render(): TemplateResult | typeof nothing {
    const view = this.model.view();
    const heartbeat = view.heartbeat;
    const hasStalls = heartbeat !== null && stallCount(view) + heartbeat.Suggested > 0;
    if (heartbeat === null || (!hasStalls && view.sections.length === 0)) return nothing;
    const stalls = hasStalls
      ? html`${count("free", heartbeat.Free)} ${count("taken", heartbeat.Taken)} ${count("unknown", heartbeat.Unknown)}`
      : html`<div class="ct" data-count="sections"><div><b>${flownWords(view)}</b></div></div>`;
    return html`<section class="card counts" aria-label=${say(hasStalls ? "stalls" : "sections")}>
      ${stalls}
      <span class="sub w">
        ${hasStalls ? html`<span>${summary(view)}</span> ${between(view)} ${suggested(view)}` : nothing}
        ${view.sections.length > 0 ? html`<span data-sections>${hasStalls ? `${say("sections")}: ${flownWords(view)}. ` : ""}${flownRoom(view)}</span>` : nothing}
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

/** Vehicles of all sections that were seen so far, and how many sections were not. */
export function flownWords({ sections }: View): string {
  const seen = sections.filter(({ look }) => look !== null).length;
  const words = parkedWords(parkedInAll(sections.map(({ look }) => look)));
  return seen === 0 || seen === sections.length ? words : say("sections-seen", { words, seen, sections: sections.length });
}

/** Room in all sections that were seen; "" where it is not known. */
export function flownRoom({ sections }: View): string {
  return roomWords({ room: roomInAll(sections.map(({ look }) => look)) });
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
