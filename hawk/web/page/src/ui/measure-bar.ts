import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { measureWords } from "../words/measure.ts";
import { say } from "../words/say.ts";
import { Part } from "./element.ts";
import { icon } from "./icons.ts";
import { isTouch } from "./touch.ts";

/** What was measured, over the map's lower edge. */
@customElement("hawk-measure")
export class MeasureBar extends Part {
  override render(): TemplateResult | typeof nothing {
    const { measure, preferences } = this.model;
    if (!measure.open) return nothing;
    const { title, line } = measureWords(measure.drawn, preferences.units, isTouch());
    const { points, closed } = measure.drawn;
    return html`<div class="measure" role="group" aria-label=${say("measure")}>
      <div class="txt" role="status"><b>${title}</b><span class="sub">${line}</span></div>
      <button aria-label=${say("measure-back")} ?disabled=${points.length === 0} @click=${() => measure.back()}>${icon("undo")}</button>
      <button aria-label=${say("close-ring")} ?disabled=${closed || points.length < 3} @click=${() => measure.close()}>${icon("square")}</button>
      <button aria-label=${say("measure-stop")} @click=${() => measure.end()}>${icon("close")}</button>
    </div>`;
  }
}
