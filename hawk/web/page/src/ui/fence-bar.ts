import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { fenceWords } from "../words/fence.ts";
import { Part } from "./element.ts";
import { icon } from "./icons.ts";
import { isTouch } from "./touch.ts";

/** The fence editor's part of the bar: what is said about the fence, its ceiling, and keeping it. */
@customElement("hawk-fence-bar")
export class FenceBar extends Part {
  override render(): TemplateResult | typeof nothing {
    const { fence, flight } = this.model;
    if (!fence.open) return nothing;
    const words = fenceWords(fence, flight.fenceSetup, this.model.view(), isTouch());
    return html`<div class="confirm fence" role="group" aria-label="Edit the fence">
      <button class="cancel" aria-label="Cancel" @click=${() => fence.cancel()}>${icon("close")}<span>Cancel</span></button>
      <div class="txt" role="status">
        <b>${words.title}</b><span class="sub ${words.level}">${words.line}</span>
      </div>
      <label class="number"
        ><span class="t">Ceiling</span>
        <input
          inputmode="decimal"
          aria-label="Ceiling, metres above where it is armed"
          .value=${fence.draft?.ceiling ?? ""}
          @input=${(event: Event) => fence.typeCeiling((event.target as HTMLInputElement).value)}
        />m</label
      >
      <button
        class="act save primary"
        ?disabled=${words.reason !== ""}
        @click=${() => void fence.save()}
      >
        <b>Save fence</b>${words.reason === "" ? nothing : html`<span class="sub">${words.reason}</span>`}
      </button>
    </div>`;
  }
}
