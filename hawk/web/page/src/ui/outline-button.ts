import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { cannot } from "../words/actions.ts";
import { cannotDraw, outlineSummary } from "../words/outline.ts";
import { say } from "../words/say.ts";
import { Part } from "./element.ts";
import { noted } from "./quoting.ts";

/** The area that Explore surveys: drawing it, removing it, taking the last one again. */
@customElement("hawk-outline-button")
export class OutlineButton extends Part {
  override render(): TemplateResult {
    const { outline } = this.model;
    const view = this.model.view();
    const { title, line } = outlineSummary(outline.setup, view.units);
    const reason = cannotDraw(view, outline.setup);
    const label = (outline.setup?.Polygons.length ?? 0) > 0 ? say("edit-outline") : say("draw-outline");
    return html`<div><b>${title}</b> <span class="sub">${line}</span></div>
      <div class="row">
        ${outline.last && cannot(view, "Set Outline") === ""
          ? html`<button aria-label=${say("last-outline-label")} @click=${() => void outline.takeLast()}>${say("last-outline")}</button>`
          : nothing}
        ${cannot(view, "Clear Outline") === ""
          ? html`<button aria-label=${say("remove-outline")} @click=${() => void outline.clear()}>${say("remove")}</button>`
          : nothing}
        <button ?disabled=${reason !== ""} @click=${() => this.edit()}>
          <span class="two">${label}${reason === "" ? nothing : html`<span class="sub">${noted(view, reason)}</span>`}</span>
        </button>
      </div>`;
  }

  private edit(): void {
    this.dispatchEvent(new CustomEvent("open-panel", { detail: "outline", bubbles: true }));
  }
}
