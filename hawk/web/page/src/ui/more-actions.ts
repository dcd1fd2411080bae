import { html, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { type Action, COMMANDS, guidedActions } from "../words/actions.ts";
import { Part } from "./element.ts";
import { isTouch } from "./touch.ts";

/** All guided actions one under the other, for a page too low to hold them in its bar. */
@customElement("hawk-more")
export class MoreActions extends Part {
  override render(): TemplateResult {
    return html`<div class="more-list">${guidedActions(this.model.view(), isTouch()).map((action) => this.row(action))}</div>`;
  }

  private row(action: Action): TemplateResult {
    const possible = action.kind === "possible" || (action.kind === "running" && action.name === "move");
    return html`<button class="act ${action.kind}" aria-label=${action.label} aria-description=${action.note} ?disabled=${!possible} @click=${() => this.run(action)}>
      <b>${action.label}</b><span class="sub">${action.note}</span>
    </button>`;
  }

  private run(action: Action): void {
    if (action.name === "move") this.model.pick(true);
    else if (action.name === "resume") this.model.ask({ about: "Resume" });
    else if (action.name === "home" && this.model.view().heartbeat?.State === "Manual") this.model.ask({ about: "Return To Launch" });
    else void this.model.command({ Type: COMMANDS[action.name] }, action.label);
  }
}
