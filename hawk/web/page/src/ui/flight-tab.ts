import { html, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import type { Heartbeat } from "../protocol.ts";
import type { Sample } from "../state/flight.ts";
import * as format from "../words/format.ts";
import { healthSummary, partName } from "../words/health.ts";
import { ageNow, STALE_S, type View } from "../words/view.ts";
import { Part } from "./element.ts";
import { icon } from "./icons.ts";
import type { Series } from "./plot.ts";
import "./plot.ts";

/** Mode, place, speed, health of each part, and how height and battery went. */
@customElement("hawk-flight")
export class FlightTab extends Part {
  private plotted: { at: number; height: Series; battery: Series } | null = null;

  override render(): TemplateResult {
    const view = this.model.view();
    const heartbeat = view.heartbeat;
    if (!heartbeat) return html`<p class="empty sub">Nothing known yet.</p>`;
    const samples = this.model.flight.samples;
    const plots = this.plots(samples);
    return html`<div class="scroll">
      ${facts(view, heartbeat)}
      <ul class="parts" aria-label="Health of each part">
        ${heartbeat.Health.map(
          (item) => html`<li class=${item.Healthy ? "ok" : "bad"}>
            ${icon(item.Healthy ? "check" : "warn")}<span>${partName(item)}</span>
            <span class="sub">${item.Healthy ? "working" : item.Reason}</span>
          </li>`,
        )}
      </ul>
      <hawk-plot label="Height, m" .series=${plots.height} .top=${topHeight(heartbeat)} .theme=${this.theme()}></hawk-plot>
      <hawk-plot label="Battery, %" .series=${plots.battery} .top=${100} .theme=${this.theme()}></hawk-plot>
    </div>`;
  }

  /** Series change only with a new sample, about once a second. */
  private plots(samples: Sample[]): { height: Series; battery: Series } {
    const now = samples.at(-1)?.at ?? 0;
    if (this.plotted?.at === now) return this.plotted;
    const recent = samples.filter((sample) => now - sample.at <= 600);
    const seconds = recent.map((sample) => sample.at - now);
    this.plotted = {
      at: now,
      height: [seconds, recent.map((sample) => sample.height)],
      battery: [seconds, recent.map((sample) => sample.battery)],
    };
    return this.plotted;
  }

  private theme(): string {
    return document.documentElement.dataset.theme ?? "";
  }
}

function topHeight(heartbeat: Heartbeat): number {
  return Math.max(15, Math.ceil((heartbeat.Heights[2] ?? 60) / 15) * 15);
}

function facts(view: View, heartbeat: Heartbeat): TemplateResult {
  const age = ageNow(view, heartbeat["Pose Age"]);
  const stale = age !== null && age > STALE_S;
  const poseClass = stale ? "stale t" : "";
  const { North, East, Home } = heartbeat;
  const fromHome = North !== null && East !== null && Home ? format.offset(North - Home.North, East - Home.East) : "–";
  const local = place(heartbeat["Local Position X"], heartbeat["Local Position Y"]);
  return html`<dl class="facts2">
    ${fact("Autopilot", heartbeat["Ardupilot State"] ?? "–", "")}
    ${fact("Speed", format.speed(heartbeat.Speed), poseClass)} ${fact("From home", fromHome, poseClass)}
    ${fact("Since armed here", local, poseClass)}
    ${fact("Place", format.place(heartbeat.Latitude, heartbeat.Longitude), poseClass)}
    ${fact("GPS", heartbeat.Satellites === null ? "–" : format.count(heartbeat.Satellites, "satellite", "satellites"), "")}
    ${fact("Climbing", format.speed(heartbeat.Climb), poseClass)}
    ${fact("Battery", heartbeat.Voltage === null ? "–" : `${heartbeat.Voltage.toFixed(1)} V`, "")}
    ${fact("Stalls looked for", heartbeat["Vision Rate"] === null ? "–" : `${heartbeat["Vision Rate"].toFixed(1)} times/s`, "")}
    ${fact("Parts", healthSummary(heartbeat.Health), "")}
  </dl>`;
}

function place(x: number | null, y: number | null): string {
  return x === null || y === null ? "–" : format.offset(x, y);
}

function fact(name: string, value: string, className: string): TemplateResult {
  return html`<div><dt>${name}</dt><dd class=${className}>${value}</dd></div>`;
}
