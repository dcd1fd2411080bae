import { html, nothing, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import type { PlanSection, SaidOfSection, Side } from "../plan/values.ts";
import { say } from "../words/say.ts";
import { capacityWords, SECTION_KINDS, sectionKindWords } from "../words/section.ts";
import { metresOf, SCALES, typed } from "../words/units.ts";
import { Part } from "./element.ts";

const MOST_PLACES = 10_000;
const LONGEST_NAME = 80;
const LONGEST_NOTE = 200;
const WIDTHS_M = [1, 50] as const;

/** The section of a plan that is being drawn, and those that are there. */
@customElement("hawk-plan-section")
export class PlanSectionForm extends Part {
  @state() private problem = "";

  override render(): TemplateResult {
    const { drawing } = this.model.plan;
    return html`<form class="drawn" @submit=${this.add}>
        ${choice("shape", say("section-shape"), drawing.isStrip ? "strip" : "area", [["strip", say("section-shape-strip")], ["area", say("section-shape-area")]], (shape) => drawing.set({ isStrip: shape === "strip" }))}
        ${drawing.isStrip ? this.strip() : nothing} ${said(null)}
        <div role="alert" class="wide problem">${this.problem}</div>
        <div class="does">
          <button type="submit" class="primary" ?disabled=${!drawing.isWhole}>${say("section-add")}</button>
          <button type="button" ?disabled=${drawing.places.length === 0} @click=${() => drawing.back()}>${say("plan-back")}</button>
        </div>
      </form>
      ${this.list()}`;
  }

  /** Side and width of a strip along a kerb. */
  private strip(): TemplateResult {
    const { drawing } = this.model.plan;
    const { units } = this.model.preferences;
    const widen = (event: Event): void => {
      const width = metresOf((event.target as HTMLInputElement).value, units);
      const isRight = width !== null && width >= WIDTHS_M[0] && width <= WIDTHS_M[1];
      this.problem = isRight ? "" : say("plan-bad-number", { field: say("plan-width", { unit: SCALES[units].symbol }) });
      if (isRight) drawing.set({ width });
    };
    return html`${choice("side", say("section-side"), drawing.side, [["right", say("section-side-right")], ["left", say("section-side-left")]], (side) => drawing.set({ side: side as Side }))}
      <label><span class="sub">${say("plan-width", { unit: SCALES[units].symbol })}</span><input name="width" inputmode="decimal" autocomplete="off" .value=${typed(drawing.width, units)} @change=${widen} /></label>`;
  }

  private list(): TemplateResult | typeof nothing {
    const editing = this.model.plan;
    const { sections } = editing.plan;
    if (sections.length === 0) return nothing;
    return html`<section aria-label=${say("sections")}>
      <b>${say("sections")}</b>
      ${sections.map(
        (each) => html`<details class="more"><summary>${each.name} <span class="sub">${capacityWords(each)}</span></summary>
          <form class="drawn" @submit=${(event: Event) => this.change(event, each)}>${said(each)}
            <div class="does">
              <button type="submit" ?disabled=${!editing.mayEdit} aria-label=${say("section-change-of", { name: each.name })}>${say("section-change")}</button>
              <button type="button" ?disabled=${!editing.mayEdit} aria-label=${say("section-remove-of", { name: each.name })} @click=${() => editing.do({ do: "remove_section", section: each.id })}>${say("plan-remove")}</button>
            </div>
          </form></details>`,
      )}
    </section>`;
  }

  private readonly add = (event: Event): void => {
    const { drawing } = this.model.plan;
    const wanted = this.read(event);
    if (wanted) drawing.finishSection(wanted);
    if (wanted && drawing.places.length === 0) (event.target as HTMLFormElement).reset();
  };

  private change(event: Event, section: PlanSection): void {
    const wanted = this.read(event);
    if (wanted) this.model.plan.do({ do: "change_section", section: section.id, ...wanted });
  }

  /** What a form says; null where its number of places is none. */
  private read(event: Event): SaidOfSection | null {
    event.preventDefault();
    const { elements } = event.target as HTMLFormElement;
    const valueOf = (name: string): string => (elements.namedItem(name) as HTMLInputElement).value.trim();
    const text = valueOf("capacity");
    const capacity = text === "" ? null : Number(text);
    const isRight = capacity === null || (Number.isInteger(capacity) && capacity >= 1 && capacity <= MOST_PLACES);
    this.problem = isRight ? "" : say("plan-bad-number", { field: say("section-capacity") });
    return isRight ? { name: valueOf("name"), kind: valueOf("kind") as SaidOfSection["kind"], capacity, note: valueOf("note") } : null;
  }
}

/** What a person says of a section; `section`: null for a new one. */
function said(section: PlanSection | null): TemplateResult {
  const given = section?.is_capacity_given === true ? String(section.capacity) : "";
  return html`<label class="wide"><span class="sub">${say("section-name")}</span><input name="name" type="text" required maxlength=${LONGEST_NAME} autocomplete="off" .defaultValue=${section?.name ?? ""} /></label>
    ${choice("kind", say("section-kind"), section?.kind ?? "parallel", SECTION_KINDS.map((kind) => [kind, sectionKindWords(kind)]))}
    <label><span class="sub">${say("section-capacity")}</span><input name="capacity" inputmode="numeric" autocomplete="off" .defaultValue=${given} /></label>
    <label class="wide"><span class="sub">${say("section-note")}</span><input name="note" type="text" maxlength=${LONGEST_NOTE} autocomplete="off" .defaultValue=${section?.note ?? ""} /></label>`;
}

function choice(name: string, label: string, chosen: string, values: readonly (readonly [string, string])[], set: (value: string) => void = () => undefined): TemplateResult {
  return html`<label><span class="sub">${label}</span>
    <select name=${name} @change=${(event: Event) => set((event.target as HTMLSelectElement).value)}>
      ${values.map(([value, words]) => html`<option value=${value} ?selected=${value === chosen}>${words}</option>`)}
    </select></label>`;
}
