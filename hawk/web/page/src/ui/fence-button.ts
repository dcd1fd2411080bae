import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { cannot, control } from "../words/actions.ts";
import { fenceSummary } from "../words/fence.ts";
import { say } from "../words/say.ts";
import { option } from "../words/view.ts";
import { Part } from "./element.ts";
import { noted, quoting } from "./quoting.ts";

/** The fence in force, and the button of its editor. */
@customElement("hawk-fence-button")
export class FenceButton extends Part {
  override render(): TemplateResult {
    const setup = this.model.flight.fenceSetup;
    const { title, line } = fenceSummary(setup, this.model.preferences.units);
    const reason = setup ? cannot(this.model.view(), "Set Fence") : say("not-known-yet");
    return html`<div><b>${title}</b> <span class="sub">${quoting(line, [setup?.Problem ?? ""])}</span></div>
      <div class="row">
        ${this.clearButton()}
        <button ?disabled=${reason !== ""} @click=${() => this.edit()}>
          <span class="two">${say("edit-fence")}${reason === "" ? nothing : html`<span class="sub">${noted(this.model.view(), reason)}</span>`}</span>
        </button>
      </div>`;
  }

  /** A drawn fence can be replaced by that of the settings. */
  private clearButton(): TemplateResult | typeof nothing {
    const view = this.model.view();
    if (!option(view, "Clear Fence").Possible || control(view) !== "mine") return nothing;
    return html`<button
      aria-label=${say("set-aside-label")}
      @click=${() => void this.model.command({ Type: "Clear Fence" }, say("set-aside-what"))}
    >
      ${say("set-aside")}
    </button>`;
  }

  private edit(): void {
    this.dispatchEvent(new CustomEvent("open-panel", { detail: "fence", bubbles: true }));
  }
}
