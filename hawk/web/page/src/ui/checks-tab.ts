import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import type { CheckItem } from "../protocol.ts";
import { cannot } from "../words/actions.ts";
import { type Remedy, REMEDIES } from "../words/remedies.ts";
import { say } from "../words/say.ts";
import { Part } from "./element.ts";
import { icon } from "./icons.ts";
import { applyRemedy } from "./apply-remedy.ts";
import { checkWords, drone, noted } from "./quoting.ts";
import { heights } from "./settings-tab.ts";
import "./fence-button.ts";
import "./heights-button.ts";

/** The same in the words of the drone's program. */
const DRONE_REMEDIES = ["Set failsafes.", "Allow arming again.", "Draw the fence."];

/** Checks before flight: failed ones first, each with its consequence and one remedy. */
@customElement("hawk-checks")
export class ChecksTab extends Part {
  override render(): TemplateResult {
    const view = this.model.view();
    const checks = view.heartbeat?.Checks ?? [];
    const failed = checks.filter((check) => !check.Passed);
    const passed = checks.filter((check) => check.Passed);
    return html`<section class="checks" aria-label=${say("checks-before-flight")}>
      <div class="scroll" tabindex="0" role="region" aria-label=${say("all-checks")}>
        <div class="hd"><span class="h">${say("checks-before-flight")}</span><span class="sub">${summary(checks.length, passed.length)}</span></div>
        ${groups(failed).map((group) => this.failed(group))}
        <ul class="passed">
          ${passed.map((check) => html`<li>${icon("check")}<span>${drone(check.Name)}</span><span>${drone(check.Value)}</span></li>`)}
        </ul>
      </div>
      <div class="ft">${heights(view)}<hawk-heights-button .model=${this.model}></hawk-heights-button></div>
      <div class="ft"><hawk-fence-button .model=${this.model}></hawk-fence-button></div>
    </section>`;
  }

  private failed(group: CheckItem[]): TemplateResult {
    const remedy = group[0]?.["Remedy Command"] ?? null;
    return html`<div class="fix">
      ${group.map(
        (check) => html`<div class="h">${icon("cross")}${checkWords(check)}</div>
          <p>${drone(check.Consequence)} ${remedy === null ? drone(check.Remedy) : nothing}</p>`,
      )}
      ${remedy === null ? nothing : this.remedy(remedy, group)}
    </div>`;
  }

  private remedy(remedy: Remedy, group: CheckItem[]): TemplateResult {
    const reason = cannot(this.model.view(), remedy);
    const words = [...new Set(group.map((check) => check.Remedy).filter((text) => text !== "" && !DRONE_REMEDIES.includes(text)))];
    return html`${words.map((text) => html`<p class="sub">${drone(text)}</p>`)}
      <button class="primary" ?disabled=${reason !== ""} aria-description=${reason} @click=${() => applyRemedy(this.model, remedy, this)}>
        ${say(REMEDIES[remedy])}
      </button>
      ${reason === "" ? nothing : html`<span class="sub">${noted(this.model.view(), reason)}</span>`}`;
  }
}

function summary(all: number, passed: number): string {
  if (all === 0) return say("checks-not-known");
  return all === passed ? say("checks-all-passed", { checks: all }) : say("checks-some-passed", { checks: all, passed });
}

/** Checks that the same command mends stand together; all others alone. */
function groups(failed: CheckItem[]): CheckItem[][] {
  const found: CheckItem[][] = [];
  for (const check of failed) {
    const same = found.find((group) => check["Remedy Command"] !== null && group[0]?.["Remedy Command"] === check["Remedy Command"]);
    if (same) same.push(check);
    else found.push([check]);
  }
  return found;
}
