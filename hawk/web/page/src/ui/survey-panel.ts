import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import type { CountedState } from "../state/map-store.ts";
import * as format from "../words/format.ts";
import { seenPercent } from "../words/glance.ts";
import { heightsOf, topHeight } from "../words/plot.ts";
import { number, say } from "../words/say.ts";
import { SCALES, type Units } from "../words/units.ts";
import { stallCount, type View } from "../words/view.ts";
import { between, flownRoom, flownWords, isSeenWhole, suggested } from "./counts-card.ts";
import { cssVars } from "./css-vars.ts";
import "./downloads.ts";
import { Part } from "./element.ts";
import { icon } from "./icons.ts";
import "./lots.ts";
import type { Series } from "./plot.ts";
import "./plot.ts";
import { swatch } from "./swatch.ts";
import { sectionsTable } from "./sections-table.ts";

/** What the survey found, once the drone is down again. */
@customElement("hawk-survey")
export class SurveyPanel extends Part {
  private plotted: { now: number; units: Units; height: Series; battery: Series } | null = null;

  override render(): TemplateResult {
    const view = this.model.view();
    const heartbeat = view.heartbeat;
    const all = stallCount(view);
    const counts: [CountedState, number][] = [
      ["free", heartbeat?.Free ?? 0],
      ["taken", heartbeat?.Taken ?? 0],
      ["unknown", heartbeat?.Unknown ?? 0],
    ];
    return html`<section class="card survey" aria-label=${say("survey")}>
      <section>
        <div class="rh">
          <span class="sub">${headline(view)}</span>
          <button class="plain" aria-label=${say("close-survey")} @click=${() => this.close()}>${icon("close")}</button>
        </div>
        ${all === 0 && view.sections.length > 0 ? html`<div class="hero">${flownWords(view)}</div>` : this.stalls(view, counts)}
        ${view.sections.length > 0 ? html`<div class="sub">${flownRoom(view)}</div>` : nothing} ${sectionsTable(view.sections)}
      </section>
      <hawk-downloads .model=${this.model}></hawk-downloads>
      <hawk-lots .model=${this.model}></hawk-lots>
      <section class="facts">
        ${fact(this.model.flight.airTime, format.longDuration, say("in-the-air"))} ${fact(heartbeat?.["Distance Flown"], (metres) => format.distance(metres, view.units), say("flown"))}
        ${fact(heartbeat?.["Lot Area"], (squareMetres) => format.area(squareMetres, view.units), say("lot-found"))}
        ${fact(heartbeat ? seenPercent(heartbeat) : null, format.percent, say("of-it-seen"))}
      </section>
      <section class="plots">${this.plots(view)}</section>
    </section>`;
  }

  private stalls(view: View, counts: readonly [CountedState, number][]): TemplateResult {
    const all = stallCount(view);
    return html`<div class="hero">${say("hero-free", { free: view.heartbeat?.Free ?? 0 })} <small>${say("hero-of", { stalls: all })}</small></div>
      <div class="sub">${between(view)} ${suggested(view)}</div>
      <div class="stack" aria-hidden="true">
        ${counts.filter(([, stalls]) => stalls > 0).map(([state, stalls]) => html`<i class=${state} ${cssVars({ "--share": String(stalls) })}></i>`)}
      </div>
      <div class="keys">
        ${counts.map(
          ([state, stalls]) => html`<div class="ct" data-count=${state}>
            ${swatch(state)}
            <div><b>${number(stalls)}</b><span class="sub">${say(`${state}-share`, { percent: format.percent((100 * stalls) / Math.max(1, all)) })}</span></div>
          </div>`,
        )}
      </div>`;
  }

  private plots(view: View): TemplateResult {
    const samples = this.model.flight.samples;
    const now = samples.at(-1)?.at ?? 0;
    const { units } = view;
    if (this.plotted?.now !== now || this.plotted.units !== units) {
      const seconds = samples.map((sample) => sample.at - now);
      const height: Series = [seconds, heightsOf(samples, units)];
      this.plotted = { now, units, height, battery: [seconds, samples.map((sample) => sample.battery)] };
    }
    const theme = document.documentElement.dataset.theme ?? "";
    const top = topHeight(view.heartbeat?.Heights[2], units);
    return html`<hawk-plot label=${say("plot-height", { unit: SCALES[units].symbol })} .series=${this.plotted.height} .top=${top} .theme=${theme}></hawk-plot>
      <hawk-plot label=${say("plot-battery")} .series=${this.plotted.battery} .top=${100} .theme=${theme}></hawk-plot>`;
  }

  private close(): void {
    this.dispatchEvent(new CustomEvent("open-panel", { detail: "close", bubbles: true }));
  }
}

function headline(view: View): string {
  const isDone = isSeenWhole(view.heartbeat);
  if (view.landedAt === null) return say(isDone ? "survey-so-far-all" : "survey-so-far");
  return say(isDone ? "landed-at-all" : "landed-at", { time: format.clock(view.landedAt) });
}

function fact(value: number | null | undefined, words: (value: number) => string, label: string): TemplateResult {
  return html`<div><b>${value == null ? "–" : words(value)}</b><span class="sub">${label}</span></div>`;
}
