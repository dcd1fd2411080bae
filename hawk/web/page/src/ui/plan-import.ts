import { html, nothing, type TemplateResult } from "lit";
import { customElement, query } from "lit/decorators.js";
import type { PlanPreview } from "../api.ts";
import { say, sentences } from "../words/say.ts";
import { Part } from "./element.ts";
import { icon } from "./icons.ts";
import { drone } from "./quoting.ts";

const FILES = ".geojson,.json,.gpkg,.kml,.dxf,.osm,.xml,.zip";
const UNITS = ["", "m", "cm", "mm", "ft", "in"];
/** Features that are listed as left out. */
const LISTED = 20;

/** An owner's plan from a file: the button that opens one, its preview, and the choices about it. */
@customElement("hawk-plan-import")
export class PlanImportPart extends Part {
  @query("input[type=file]") private chooser!: HTMLInputElement;

  override render(): TemplateResult {
    const { plan } = this.model;
    const { incoming } = plan;
    return html`<div class="drawn">
      <input type="file" accept=${FILES} hidden aria-label=${say("plan-import")} @change=${this.open} />
      <button ?disabled=${!plan.mayEdit} @click=${() => this.chooser.click()}>${icon("upload")}${say("plan-import")}</button>
      ${incoming.file ? this.shown(incoming.file.name) : nothing}
    </div>`;
  }

  private shown(name: string): TemplateResult {
    const { incoming, mayEdit } = this.model.plan;
    const { preview, problem, busy } = incoming;
    return html`<section class="imported" aria-label=${say("plan-import")}>
      <b>${name}</b>
      <p role="status">${busy ? say("plan-import-reads") : preview ? effectsOf(preview) : ""}</p>
      <div role="alert">${problem === "" ? nothing : html`<p class="problem">${icon("warn")}<span>${drone(problem)}</span></p>`}</div>
      ${preview ? this.refused(preview) : nothing}
      <div class="does">
        <button class="primary" ?disabled=${busy || !mayEdit || !preview || preview.clash_count > 0} @click=${() => void incoming.take()}>${say(preview?.placed.is_certain === false ? "plan-import-take-so" : "plan-import-take")}</button>
        <button @click=${() => incoming.drop()}>${say("cancel")}</button>
      </div>
      ${preview ? this.list(preview) : nothing}
      <details class="more" ?open=${problem !== "" || (preview?.clash_count ?? 0) > 0}>
        <summary>${say("plan-import-choices")}</summary>
        <form @submit=${this.again}>
          ${switched("replace", say("plan-import-replace"))} ${switched("rename", say("plan-import-rename"))}
          ${typed("layer", say("plan-import-layer"), "plan-layers")} ${typed("label", say("plan-import-label"))} ${typed("crs", say("plan-import-crs"))}
          <label><span class="sub">${say("plan-import-units")}</span><select name="units">${UNITS.map((unit) => html`<option value=${unit}>${unit}</option>`)}</select></label>
          ${[1, 2].map((number) => typed("pin", say("plan-import-point", { number })))}
          <datalist id="plan-layers">${(preview?.layers ?? []).map((layer) => html`<option value=${layer.name}></option>`)}</datalist>
          <button type="submit" ?disabled=${busy}>${say("plan-import-again")}</button>
        </form>
      </details>
    </section>`;
  }

  /** What is in question, in one line each, above the button that takes the plan. */
  private refused({ placed, clash_count: clashes, left_out_count: left, notes }: PlanPreview): TemplateResult {
    const { incoming } = this.model.plan;
    const line = (words: string): TemplateResult => html`<p class="problem">${icon("warn")}<span>${words}</span></p>`;
    return html`${placed.is_certain ? nothing : html`<p class="problem">${icon("warn")}<span>${say("plan-import-doubt")} ${drone(placed.doubt)}</span></p>`}
    ${notes.map((words) => html`<p class="sub">${say("plan-import-assumed")} ${drone(words)}</p>`)}
    ${left === 0 ? nothing : line(say("plan-import-left", { count: left }))}
    ${clashes === 0 ? nothing : line(say("plan-import-clashes", { count: clashes }))}
    ${clashes === 0 ? nothing : html`<button ?disabled=${incoming.busy} @click=${this.number}>${say("plan-import-number")}</button>`}`;
  }

  private list({ left_out: leftOut, clashes }: PlanPreview): TemplateResult | typeof nothing {
    const named = [...clashes, ...leftOut].slice(0, LISTED);
    if (named.length === 0) return nothing;
    return html`<details class="more">
      <summary>${say("plan-import-which", { shown: named.length })}</summary>
      <ul>${named.map(({ name, reason }) => html`<li>${name}: ${drone(reason)}</li>`)}</ul>
    </details>`;
  }

  /** Labels that are refused get a number behind them. */
  private readonly number = (): void => {
    const box = this.renderRoot.querySelector<HTMLInputElement>("[name=rename]");
    if (box) box.checked = true;
    this.readAgain();
  };

  private readonly open = (): void => {
    const [file] = this.chooser.files ?? [];
    this.chooser.value = "";
    if (file) void this.model.plan.incoming.read(file);
  };

  private readonly again = (event: Event): void => {
    event.preventDefault();
    this.readAgain();
  };

  private readAgain(): void {
    const { file } = this.model.plan.incoming;
    const choices = new URLSearchParams();
    for (const field of this.renderRoot.querySelectorAll<HTMLInputElement | HTMLSelectElement>("form input, form select")) {
      const isOff = field.type === "checkbox" && "checked" in field && !field.checked;
      if (!isOff && field.value.trim() !== "") choices.append(field.name, field.value.trim());
    }
    if (file) void this.model.plan.incoming.read(file, choices);
  }
}

/** What happens to stalls and to sections; of a file without some of them, to the others alone. */
function effectsOf({ begin, stay, same, end, sections, same_sections }: PlanPreview): string {
  const count = (wanted: PlanPreview["sections"][number]["change"]): number => sections.filter(({ change }) => change === wanted).length;
  const ofSections = { begin: count("begin"), stay: count("stay"), same: same_sections, end: count("end") };
  const hasSections = sections.length + same_sections > 0;
  const hasStalls = begin.length + stay.length + same + end.length > 0 || !hasSections;
  return sentences(hasStalls ? say("plan-import-counts", { begin: begin.length, stay: stay.length, same, end: end.length }) : "", hasSections ? say("plan-import-sections", ofSections) : "");
}

function typed(name: string, label: string, list = ""): TemplateResult {
  return html`<label><span class="sub">${label}</span><input name=${name} list=${list} type="text" autocomplete="off" maxlength="200" /></label>`;
}

function switched(name: string, label: string): TemplateResult {
  return html`<label class="toggle"><input type="checkbox" name=${name} value="1" /> ${label}</label>`;
}
