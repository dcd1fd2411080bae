import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import type { PlanZone } from "../api.ts";
import { type Kind, KINDS } from "../plan/values.ts";
import { LatePart, READING } from "../shell/late-part.ts";
import { waitingFor } from "../shell/views.ts";
import type { PlanDrawing, RowStyle } from "../state/plan-drawing.ts";
import { kindWords } from "../words/plan.ts";
import { say } from "../words/say.ts";
import { Part } from "./element.ts";

const STYLES: readonly RowStyle[] = ["square", "angled", "parallel"];

/** How the row, the stall, the area or the zone that is being drawn is to be. */
@customElement("hawk-plan-drawn")
export class PlanDrawn extends Part {
  /** The form of a section, which few plans have. */
  private readonly section = new LatePart(READING.section, () => this.requestUpdate());

  override render(): TemplateResult {
    const { drawing } = this.model.plan;
    if (drawing.isRing) return this.ring(drawing);
    if (drawing.tool === "section") return this.section.want() ? html`<hawk-plan-section .model=${this.model}></hawk-plan-section>` : waitingFor(this.section);
    return html`<div class="drawn">
      ${drawing.tool === "row" ? this.row(drawing) : nothing} ${kinds(drawing)} ${drawing.tool === "row" ? this.ending(drawing) : nothing}
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

  private ring(drawing: PlanDrawing): TemplateResult {
    const isZone = drawing.tool === "zone";
    return html`<form class="drawn" @submit=${this.addRing}>
        <label class="wide"><span class="sub">${say(isZone ? "plan-zone-name" : "plan-area-name")}</span><input name="area" type="text" maxlength="80" autocomplete="off" ?required=${isZone} /></label>
        ${isZone ? kinds(drawing) : html`<label class="toggle wide"><input type="checkbox" name="private" /> ${say("plan-area-private")}</label>`}
        <div class="does">
          <button type="submit" class="primary" ?disabled=${!drawing.isWhole}>${say(isZone ? "plan-zone-add" : "plan-area-add")}</button>
          <button type="button" ?disabled=${drawing.places.length === 0} @click=${() => drawing.back()}>${say("plan-back")}</button>
        </div>
      </form>
      ${this.rings(isZone)}`;
  }

  private rings(isZone: boolean): TemplateResult | typeof nothing {
    const editing = this.model.plan;
    const { zones, named } = editing.plan;
    const title = say(isZone ? "plan-zones" : "plan-areas");
    const rows = (isZone ? named : zones).map(({ id, name, kind }, index) => ({ id, kind, name: name === "" ? say("plan-area-nameless", { number: index + 1 }) : name }));
    if (rows.length === 0) return nothing;
    return html`<section aria-label=${title}>
      <b>${title}</b>
      <ul>
        ${rows.map(({ id, name, kind }) => html`<li><span>${name}${ringKind(kind)}</span><button aria-label=${say(isZone ? "plan-zone-erase-of" : "plan-allow-in", { name })} @click=${() => editing.do({ do: isZone ? "erase_zone" : "allow", zone: id })}>${say(isZone ? "plan-remove" : "plan-allow")}</button></li>`)}
      </ul>
    </section>`;
  }

  private readonly addRing = (event: Event): void => {
    event.preventDefault();
    const form = event.currentTarget as HTMLFormElement;
    const field = (name: string): HTMLInputElement | null => form.elements.namedItem(name) as HTMLInputElement | null;
    this.model.plan.drawing.finish(field("area")?.value, field("private")?.checked);
    if (this.model.plan.drawing.places.length === 0) form.reset();
  };
}

/** Behind the name of a ring: for whom its stalls are, or that nobody may look at it. */
function ringKind(kind: PlanZone["kind"]): string {
  if (kind === "private_ground") return ` · ${say("plan-private")}`;
  return kind === "" || kind === "no_stalls" ? "" : ` · ${kindWords(kind)}`;
}

/** The kind of the stalls that are drawn, or of a zone. */
function kinds(drawing: PlanDrawing): TemplateResult {
  return html`<label><span class="sub">${say("plan-kind")}</span>
    <select name="kind" .value=${drawing.kind} @change=${(event: Event) => drawing.set({ kind: valueOf(event) as Kind })}>
      ${KINDS.map((kind) => html`<option value=${kind} ?selected=${kind === drawing.kind}>${kindWords(kind)}</option>`)}
    </select>
  </label>`;
}

function valueOf(event: Event): string {
  return (event.target as HTMLInputElement).value;
}
