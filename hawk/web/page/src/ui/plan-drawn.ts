import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { type Kind, KINDS } from "../plan/values.ts";
import type { PlanDrawing, RowStyle } from "../state/plan-drawing.ts";
import { kindWords } from "../words/plan.ts";
import { say } from "../words/say.ts";
import { Part } from "./element.ts";

const STYLES: readonly RowStyle[] = ["square", "angled", "parallel"];

/** How the row, the stall or the area that is being drawn is to be. */
@customElement("hawk-plan-drawn")
export class PlanDrawn extends Part {
  override render(): TemplateResult {
    const { drawing } = this.model.plan;
    if (drawing.tool === "area") return this.area(drawing);
    return html`<div class="drawn">
      ${drawing.tool === "row" ? this.row(drawing) : nothing}
      <label><span class="sub">${say("plan-kind")}</span>
        <select name="kind" .value=${drawing.kind} @change=${(event: Event) => drawing.set({ kind: valueOf(event) as Kind })}>
          ${KINDS.map((kind) => html`<option value=${kind} ?selected=${kind === drawing.kind}>${kindWords(kind)}</option>`)}
        </select>
      </label>
      ${drawing.tool === "row" ? this.ending(drawing) : nothing}
    </div>`;
  }

  private row(drawing: PlanDrawing): TemplateResult {
    const { row, typedCount } = drawing;
    const count = row && typedCount === null ? say("plan-count-follows", { count: row.count }) : say("plan-count");
    return html`<label><span class="sub">${count}</span>
        <input name="count" inputmode="numeric" autocomplete="off" .value=${drawing.count} @input=${(event: Event) => drawing.set({ count: valueOf(event) })} />
      </label>
      <label><span class="sub">${say("plan-style")}</span>
        <select name="style" .value=${drawing.style} @change=${(event: Event) => drawing.set({ style: valueOf(event) as RowStyle })}>
          ${STYLES.map((style) => html`<option value=${style} ?selected=${style === drawing.style}>${say(`plan-style-${style}`)}</option>`)}
        </select>
      </label>
      ${
        drawing.style === "angled"
          ? html`<label><span class="sub">${say("plan-lean")}</span>
              <input name="lean" inputmode="text" autocomplete="off" .value=${drawing.lean} @input=${(event: Event) => drawing.set({ lean: valueOf(event) })} />
            </label>`
          : nothing
      }
      <label class="toggle"><input type="checkbox" name="double" .checked=${drawing.double} @change=${(event: Event) => drawing.set({ double: (event.target as HTMLInputElement).checked })} /> ${say("plan-double")}</label>`;
  }

  private ending(drawing: PlanDrawing): TemplateResult {
    const stalls = drawing.rowStalls.length;
    const label = drawing.isWhole ? say("plan-add-row-of", { stalls }) : say("plan-add-row");
    return html`<div class="does">
      <button class="primary" ?disabled=${!drawing.isWhole} @click=${() => drawing.finish()}>${label}</button>
      <button ?disabled=${drawing.places.length === 0} @click=${() => drawing.back()}>${say("plan-back")}</button>
    </div>`;
  }

  private area(drawing: PlanDrawing): TemplateResult {
    const { plan } = this.model.plan;
    return html`<form class="drawn" @submit=${this.addArea}>
        <label class="wide"><span class="sub">${say("plan-area-name")}</span><input name="area" type="text" maxlength="80" autocomplete="off" /></label>
        <div class="does">
          <button type="submit" class="primary" ?disabled=${!drawing.isWhole}>${say("plan-area-add")}</button>
          <button type="button" ?disabled=${drawing.places.length === 0} @click=${() => drawing.back()}>${say("plan-back")}</button>
        </div>
      </form>
      ${plan.zones.length === 0 ? nothing : this.areas()}`;
  }

  private areas(): TemplateResult {
    const editing = this.model.plan;
    const rows = editing.plan.zones.map(({ id, name }, index) => ({ id, name: name === "" ? say("plan-area-nameless", { number: index + 1 }) : name }));
    return html`<section aria-label=${say("plan-areas")}>
      <b>${say("plan-areas")}</b>
      <ul>
        ${rows.map(({ id, name }) => html`<li><span>${name}</span><button aria-label=${say("plan-allow-in", { name })} @click=${() => editing.do({ do: "allow", zone: id })}>${say("plan-allow")}</button></li>`)}
      </ul>
    </section>`;
  }

  private readonly addArea = (event: Event): void => {
    event.preventDefault();
    const form = event.currentTarget as HTMLFormElement;
    this.model.plan.drawing.finish((form.elements.namedItem("area") as HTMLInputElement).value);
    form.reset();
  };
}

function valueOf(event: Event): string {
  return (event.target as HTMLInputElement).value;
}
