import { html, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import type { PlanTool } from "../state/plan-drawing.ts";
import { say } from "../words/say.ts";
import { Part } from "./element.ts";
import { icon, type IconName } from "./icons.ts";

const TOOLS: readonly { tool: PlanTool; label: "plan-tool-choose" | "plan-tool-box" | "plan-tool-row" | "plan-tool-stall" | "plan-tool-area" | "plan-tool-zone" | "plan-tool-section"; name: IconName; aloud?: "plan-tool-area-aloud" }[] = [
  { tool: "choose", label: "plan-tool-choose", name: "pointer" },
  { tool: "box", label: "plan-tool-box", name: "box" },
  { tool: "row", label: "plan-tool-row", name: "row" },
  { tool: "stall", label: "plan-tool-stall", name: "plus" },
  { tool: "area", label: "plan-tool-area", aloud: "plan-tool-area-aloud", name: "zone" },
  { tool: "zone", label: "plan-tool-zone", name: "square" },
  { tool: "section", label: "plan-tool-section", name: "kerb" },
];

/** What a click on the map means while a plan is corrected, with undo and redo, over the map's upper edge. */
@customElement("hawk-plan-tools")
export class PlanTools extends Part {
  override render(): TemplateResult {
    const { plan } = this.model;
    const off = !plan.mayEdit;
    const left = plan.own;
    return html`<div class="fencetools plantools" role="toolbar" aria-label=${say("plan-tools")}>
      ${TOOLS.map(({ tool, label, aloud = label, name }) => {
        const on = plan.drawing.tool === tool;
        return html`<button class="${tool} ${on ? "on" : ""}" aria-label=${say(aloud)} aria-pressed=${on ? "true" : "false"} ?disabled=${off} @click=${() => plan.drawing.use(tool)}>
          ${icon(name)}<span>${say(label)}</span>
        </button>`;
      })}
      <button class="step" aria-label=${say("tool-undo")} title=${say("tool-undo")} ?disabled=${off || ((left?.undo ?? 0) === 0 && plan.waiting === 0)} @click=${() => plan.undo()}>${icon("undo")}</button>
      <button class="step" aria-label=${say("plan-redo")} title=${say("plan-redo")} ?disabled=${off || (left?.redo ?? 0) === 0} @click=${() => plan.redo()}>${icon("redo")}</button>
    </div>`;
  }
}
