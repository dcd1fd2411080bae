import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { type BatteryPart, batteryWords } from "../words/battery.ts";
import * as format from "../words/format.ts";
import { say } from "../words/say.ts";
import { ageNow, BATTERY_STALE_S } from "../words/view.ts";
import { cssVars } from "./css-vars.ts";
import { Part } from "./element.ts";
import { icon } from "./icons.ts";

/** The battery: what the flight home needs, what the survey needs, what is left. */
@customElement("hawk-battery")
export class BatteryBar extends Part {
  override render(): TemplateResult | typeof nothing {
    const view = this.model.view();
    const heartbeat = view.heartbeat;
    const words = heartbeat ? batteryWords(heartbeat) : null;
    if (!heartbeat || !words) return nothing;
    const age = ageNow(view, heartbeat["Battery Age"]);
    const stale = age !== null && age > BATTERY_STALE_S;
    return html`<section class="battery ${stale ? "stale" : ""}" aria-label=${say("battery-for-survey")}>
      <div class="hd">
        <b>${say("battery-charge", { percent: format.percent(heartbeat["Battery Percentage"]) })}</b>
        <span class=${words.short ? "short" : "sub"}>${words.short ? icon("warn") : nothing}${words.verdict}</span>
        ${stale ? html`<span class="age">${say("age", { age: format.age(age) })}</span>` : nothing}
      </div>
      <div class="charge" role="img" aria-label=${words.spoken}>
        ${words.parts.map((part) => html`<i class=${part.name} ${cssVars({ "--share": String(part.shown) })}></i>`)}
      </div>
      <div class="keys" aria-hidden="true">${words.parts.map(key)}</div>
    </section>`;
  }
}

function key(part: BatteryPart): TemplateResult {
  return html`<span class="key" data-part=${part.name}><i class=${part.name}></i>${part.label} <b>${format.percent(part.percent)}</b></span>`;
}
