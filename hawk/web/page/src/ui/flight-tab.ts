import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import type { HealthItem, Heartbeat } from "../protocol.ts";
import type { Sample } from "../state/flight.ts";
import * as format from "../words/format.ts";
import { healthSummary, partName } from "../words/health.ts";
import { heightsOf, topHeight } from "../words/plot.ts";
import { number, say } from "../words/say.ts";
import { SCALES, type Units } from "../words/units.ts";
import { ageNow, STALE_S, type View } from "../words/view.ts";
import { Part } from "./element.ts";
import { icon } from "./icons.ts";
import "./battery-bar.ts";
import { drone } from "./quoting.ts";
import type { Series } from "./plot.ts";
import "./plot.ts";

/** Mode, place, speed, health of each part, and how height and battery went. */
@customElement("hawk-flight")
export class FlightTab extends Part {
  private plotted: { at: number; units: Units; height: Series; battery: Series } | null = null;

  override render(): TemplateResult {
    const view = this.model.view();
    const heartbeat = view.heartbeat;
    if (!heartbeat) return html`<p class="empty sub">${say("nothing-known-yet")}</p>`;
    const samples = this.model.flight.samples;
    const plots = this.plots(samples, view.units);
    return html`<div tabindex="0" role="region" aria-label=${say("flight")} class="scroll">
      ${mainFacts(view, heartbeat)} ${parts(heartbeat.Health.filter((item) => !item.Healthy))}
      <hawk-battery .model=${this.model}></hawk-battery>
      <hawk-plot label=${say("plot-height", { unit: SCALES[view.units].symbol })} .series=${plots.height} .top=${topHeight(heartbeat.Heights[2], view.units)} .theme=${this.theme()}></hawk-plot>
      <hawk-plot label=${say("plot-battery")} .series=${plots.battery} .top=${100} .theme=${this.theme()}></hawk-plot>
      ${moreFacts(view, heartbeat)} ${parts(heartbeat.Health.filter((item) => item.Healthy))}
    </div>`;
  }

  /** Series change only with a new sample, about once a second. */
  private plots(samples: Sample[], units: Units): { height: Series; battery: Series } {
    const now = samples.at(-1)?.at ?? 0;
    if (this.plotted?.at === now && this.plotted.units === units) return this.plotted;
    const recent = samples.filter((sample) => now - sample.at <= 600);
    const seconds = recent.map((sample) => sample.at - now);
    this.plotted = {
      at: now,
      units,
      height: [seconds, heightsOf(recent, units)],
      battery: [seconds, recent.map((sample) => sample.battery)],
    };
    return this.plotted;
  }

  private theme(): string {
    return document.documentElement.dataset.theme ?? "";
  }
}

function parts(items: HealthItem[]): TemplateResult | typeof nothing {
  if (items.length === 0) return nothing;
  return html`<ul class="parts" aria-label=${say("health-of-parts")}>
    ${items.map(
      (item) => html`<li class=${item.Healthy ? "ok" : "bad"}>
        ${icon(item.Healthy ? "check" : "warn")}<span>${partName(item)}</span>
        <span class="sub">${item.Healthy ? say("part-working") : drone(item.Reason)}</span>
      </li>`,
    )}
  </ul>`;
}

function poseClass(view: View, heartbeat: Heartbeat): string {
  const age = ageNow(view, heartbeat["Pose Age"]);
  return age !== null && age > STALE_S ? "stale t" : "";
}

function mainFacts(view: View, heartbeat: Heartbeat): TemplateResult {
  const { North, East, Home } = heartbeat;
  const fromHome = North !== null && East !== null && Home ? format.offset(North - Home.North, East - Home.East, view.units) : "–";
  const stale = poseClass(view, heartbeat);
  return html`<dl class="pairs">
    ${fact(say("fact-autopilot"), heartbeat["Ardupilot State"] ?? "–", "")} ${fact(say("fact-speed"), format.speed(heartbeat.Speed, view.units), stale)}
    ${fact(say("fact-from-home"), fromHome, stale)} ${fact(say("fact-parts"), healthSummary(heartbeat.Health), "")}
  </dl>`;
}

function moreFacts(view: View, heartbeat: Heartbeat): TemplateResult {
  const stale = poseClass(view, heartbeat);
  const { Satellites, Voltage, "Vision Rate": rate } = heartbeat;
  return html`<dl class="pairs list">
    ${fact(say("fact-place"), format.place(heartbeat.Latitude, heartbeat.Longitude), stale)}
    ${fact(say("fact-from-armed"), place(heartbeat["Local Position X"], heartbeat["Local Position Y"], view.units), stale)}
    ${aboveGround(heartbeat["Height Above Ground"], view.units, stale)} ${fact(say("fact-climbing"), format.speed(heartbeat.Climb, view.units), stale)}
    ${fact(say("fact-wind"), format.wind(heartbeat["Wind Speed"], heartbeat["Wind From"], view.units), stale)}
    ${fact(say("fact-gps"), Satellites === null ? "–" : say("satellites", { satellites: Satellites }), "")}
    ${fact(say("fact-voltage"), format.volts(Voltage), "")}
    ${fact(say("fact-pictures"), rate === null ? "–" : say("each-second", { value: number(rate, 1) }), "")}
  </dl>`;
}

/** Only with a rangefinder: every other height counts above the arm place. */
function aboveGround(metres: number | null, units: Units, stale: string): TemplateResult | typeof nothing {
  return metres === null ? nothing : fact(say("fact-above-ground"), format.height(metres, units), stale);
}

function place(x: number | null, y: number | null, units: Units): string {
  return x === null || y === null ? "–" : format.offset(x, y, units);
}

function fact(name: string, value: string, className: string): TemplateResult {
  return html`<div><dt>${name}</dt><dd class=${className}>${value}</dd></div>`;
}
