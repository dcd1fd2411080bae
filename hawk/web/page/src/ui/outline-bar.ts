import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { outlineWords } from "../words/outline.ts";
import { say } from "../words/say.ts";
import { Part } from "./element.ts";
import { icon } from "./icons.ts";
import { noted } from "./quoting.ts";
import { isTouch } from "./touch.ts";

/** The bar while the area to explore is drawn: what is said about it, and setting it. */
@customElement("hawk-outline-bar")
export class OutlineBar extends Part {
  override render(): TemplateResult | typeof nothing {
    const { outline, flight } = this.model;
    if (!outline.open) return nothing;
    const words = outlineWords(outline, flight.plane, this.model.view(), isTouch());
    return html`<div class="confirm fence" role="group" aria-label=${say("draw-area")}>
      <button class="cancel" aria-label=${say("cancel")} @click=${() => outline.cancel()}>${icon("close")}<span>${say("cancel")}</span></button>
      <div class="txt" role="status">
        <b>${words.title}</b><span class="sub ${words.level}">${words.line}</span>
      </div>
      <button
        class="act save primary"
        ?disabled=${words.reason !== ""}
        @click=${() => void outline.save()}
      >
        <b>${say("set-outline")}</b>${words.reason === "" ? nothing : html`<span class="sub">${noted(this.model.view(), words.reason)}</span>`}
      </button>
    </div>`;
  }
}
