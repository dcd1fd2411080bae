import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { cannot } from "../words/actions.ts";
import { cannotDraw, outlineSummary } from "../words/outline.ts";
import { Part } from "./element.ts";

/** The area that Explore surveys: drawing it, removing it, taking the last one again. */
@customElement("hawk-outline-button")
export class OutlineButton extends Part {
  override render(): TemplateResult {
    const { outline } = this.model;
    const view = this.model.view();
    const { title, line } = outlineSummary(outline.setup, view.units);
    const reason = cannotDraw(view, outline.setup);
    const label = (outline.setup?.Polygons.length ?? 0) > 0 ? "Edit outline" : "Draw outline";
    return html`<div><b>${title}</b> <span class="sub">${line}</span></div>
      <div class="row">
        ${outline.last && cannot(view, "Set Outline") === ""
          ? html`<button aria-label="Last outline: take it again" @click=${() => void outline.takeLast()}>Last outline</button>`
          : nothing}
        ${cannot(view, "Clear Outline") === ""
          ? html`<button aria-label="Remove the outline" @click=${() => void outline.clear()}>Remove</button>`
          : nothing}
        <button ?disabled=${reason !== ""} @click=${() => this.edit()}>
          <span class="two">${label}${reason === "" ? nothing : html`<span class="sub">${reason}</span>`}</span>
        </button>
      </div>`;
  }

  private edit(): void {
    this.dispatchEvent(new CustomEvent("open-panel", { detail: "outline", bubbles: true }));
  }
}
