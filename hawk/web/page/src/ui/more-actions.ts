import { html, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { type Action, guidedActions } from "../words/actions.ts";
import { startAction } from "./start-action.ts";
import { Part } from "./element.ts";
import { showChecks } from "./apply-remedy.ts";
import { noted } from "./quoting.ts";
import { isTouch } from "./touch.ts";

/** All guided actions one under the other, for a page too low to hold them in its bar. */
@customElement("hawk-more")
export class MoreActions extends Part {
  override render(): TemplateResult {
    return html`<div class="more-list">${guidedActions(this.model.view(), isTouch()).map((action) => this.row(action))}</div>`;
  }

  private row(action: Action): TemplateResult {
    const possible = action.kind === "possible" || action.kind === "failed" || (action.kind === "running" && action.name === "move");
    return html`<button class="act ${action.kind}" ?disabled=${!possible} @click=${() => this.run(action)}>
      <b>${action.label}</b> <span class="sub">${noted(this.model.view(), action.note)}</span>
    </button>`;
  }

  private run(action: Action): void {
    if (action.kind === "failed") showChecks(this);
    else if (action.name === "move") this.model.pick(true);
    else startAction(this.model, action);
  }
}
