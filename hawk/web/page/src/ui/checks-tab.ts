import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import type { CheckItem } from "../protocol.ts";
import { cannot } from "../words/actions.ts";
import { Part } from "./element.ts";
import { icon } from "./icons.ts";
import { heights } from "./settings-tab.ts";
import "./fence-button.ts";
import "./heights-button.ts";

const REMEDIES = { "Set Failsafes": "Set failsafes", "Clear Kill": "Allow arming again", "Set Fence": "Draw the fence" } as const;
type Remedy = keyof typeof REMEDIES;

/** Checks before flight: failed ones first, each with its consequence and one remedy. */
@customElement("hawk-checks")
export class ChecksTab extends Part {
  override render(): TemplateResult {
    const view = this.model.view();
    const checks = view.heartbeat?.Checks ?? [];
    const failed = checks.filter((check) => !check.Passed);
    const passed = checks.filter((check) => check.Passed);
    return html`<section class="checks" aria-label="Checks before flight">
      <div class="scroll" tabindex="0" role="region" aria-label="All checks">
        <div class="hd"><span class="h">Checks before flight</span><span class="sub">${summary(checks.length, passed.length)}</span></div>
        ${groups(failed).map((group) => this.failed(group))}
        <ul class="passed">
          ${passed.map((check) => html`<li>${icon("check")}<span>${check.Name}</span><span>${check.Value}</span></li>`)}
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
        (check) => html`<div class="h">${icon("cross")}${check.Name}: ${check.Value}</div>
          <p>${check.Consequence}${remedy === null && check.Remedy !== "" ? ` ${check.Remedy}` : ""}</p>`,
      )}
      ${remedy === null ? nothing : this.remedy(remedy, group)}
    </div>`;
  }

  private remedy(remedy: Remedy, group: CheckItem[]): TemplateResult {
    const reason = cannot(this.model.view(), remedy);
    const words = [...new Set(group.map((check) => check.Remedy).filter((text) => text !== "" && text !== `${REMEDIES[remedy]}.`))];
    return html`${words.map((text) => html`<p class="sub">${text}</p>`)}
      <button class="primary" ?disabled=${reason !== ""} aria-description=${reason} @click=${() => this.mend(remedy)}>
        ${REMEDIES[remedy]}
      </button>
      ${reason === "" ? nothing : html`<span class="sub">${reason}</span>`}`;
  }

  private mend(remedy: Remedy): void {
    if (remedy === "Set Fence") this.dispatchEvent(new CustomEvent("open-panel", { detail: "fence", bubbles: true }));
    else void this.model.command({ Type: remedy }, REMEDIES[remedy]);
  }
}

function summary(all: number, passed: number): string {
  if (all === 0) return "not known yet";
  return all === passed ? `all ${all} passed` : `${passed} of ${all} passed`;
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
