import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import type { ListedSection, Observation, SeenSections, StallsUse, SurveysUse } from "../api.ts";
import { rowMarks } from "../map/draw-labels.ts";
import { css, HEAT } from "../map/stall-style.ts";
import { cssVars } from "../ui/css-vars.ts";
import { number, say } from "../words/say.ts";
import { heatClass, moment, share } from "./figures.ts";
import "./survey-map.ts";
import { sectionsTable } from "../ui/sections-table.ts";
import type { SurveyOnMap } from "./survey-source.ts";
import { Asked, View } from "./view.ts";

/** Every stall by the share of surveys that found it taken, on the map and as a list, and the last looks at one of them. */
@customElement("archive-stalls")
export class StallsView extends View {
  private readonly heat = new Asked<StallsUse>(this);
  private readonly listed = new Asked<SurveysUse>(this);
  private readonly shown = new Asked<SurveyOnMap | null>(this);
  private readonly sections = new Asked<SeenSections>(this);
  private readonly looks = new Asked<Observation[]>(this);
  private readonly coloured = kept(byShare);

  override willUpdate(): void {
    const { from, to, lot, stall } = this.place;
    const key = JSON.stringify([lot, from, to, this.revision]);
    this.heat.ask(key, () => this.source.heat({ from, to }));
    this.listed.ask(key, () => this.source.surveys({ from, to }));
    const newest = this.listed.value?.surveys.find((row) => row.left_out_code === "");
    if (newest) {
      this.shown.ask(newest.id, () => this.source.onMap(newest.id));
      if (!this.listed.waiting) this.sections.ask(`${newest.id} ${this.revision}`, () => this.source.sections(newest.id));
    }
    if (stall !== "") this.looks.ask(`${stall} ${this.revision}`, () => this.source.looks(stall));
  }

  override render(): TemplateResult {
    const problem = this.heat.problem || this.listed.problem || this.shown.problem;
    if (problem !== "") return html`<p role="alert">${problem}</p>`;
    const [heat, shown] = [this.heat.value, this.shown.value];
    if (heat === null) return html`<p>${say("archive-asking")}</p>`;
    if (heat.ids.length === 0 && (this.listed.waiting || this.sections.waiting)) return html`<p>${say("archive-asking")}</p>`;
    const sections = this.sections.value?.sections ?? NO_SECTIONS;
    if (heat.surveys_in_period === 0 || (heat.ids.length === 0 && sections.length === 0)) return html`<p>${say("archive-none-counts")}</p>`;
    return html`<div class="lot stalls">
      ${shown === null ? nothing : html`<hawk-survey-map .source=${this.coloured(shown, heat)} .chosen=${this.place.stall} .known=${this.known(heat)} .legend=${heat.ids.length === 0 ? html`` : legend()} .label=${say("archive-heat")} .theme=${document.documentElement.dataset.theme ?? ""}
        .sections=${sections} .section=${this.place.section} @section=${(event: CustomEvent<string>) => this.go({ section: event.detail, stall: "" })}
        @stall=${(event: CustomEvent<string>) => this.go({ stall: event.detail, section: "" })}></hawk-survey-map>`}
      <section class="card about" aria-label=${say("archive-stalls")}>${heat.ids.length === 0 ? nothing : html`<p>${say("archive-heat-note", { surveys: heat.surveys_in_period })}</p>`}
        ${this.place.stall === "" ? nothing : this.one(heat)} ${sectionsTable(sections, this.place.section, (section) => this.go({ section, stall: "" }))} ${heat.ids.length === 0 ? nothing : this.list(heat)}</section></div>`;
  }

  private list(heat: StallsUse): TemplateResult {
    return html`<table class="rows">
      <thead><tr><th scope="col">${say("archive-stall")}</th><th scope="col">${say("archive-taken")}</th></tr></thead>
      <tbody>${heat.ids.map(
        (id, k) => html`<tr class=${id === this.place.stall ? "on" : ""}><th scope="row"><button class="plain link" aria-pressed=${id === this.place.stall} @click=${() => this.go({ stall: id })}>${heat.labels[k]}</button></th><td>${share(estimate(heat, k))}</td></tr>`,
      )}</tbody></table>`;
  }

  private known(heat: StallsUse): string {
    const found = estimate(heat, heat.ids.indexOf(this.place.stall));
    return `${say("archive-stall-share", { surveys: found.surveys })} ${share(found)}`;
  }

  private one(heat: StallsUse): TemplateResult {
    const { value, problem } = this.looks;
    const label = heat.labels[heat.ids.indexOf(this.place.stall)] ?? value?.[0]?.label ?? "";
    return html`<section aria-live="polite"><h2>${say("archive-stall-of", { label })}</h2>
      <p>${this.known(heat)}</p>
      ${problem === "" ? nothing : html`<p role="alert">${problem}</p>`}
      <ol class="looks">${(value ?? []).map(
        (look) => html`<li><i class="key ${look.state}"></i>${moment(look.observed, this.listed.value?.clock)} · ${say(stateKey(look.state))} · ${say("archive-chance-taken", { value: number(100 * look.taken_probability) })}</li>`,
      )}</ol></section>`;
  }
}

const NO_SECTIONS: readonly ListedSection[] = [];

function stateKey(state: string): "archive-state-free" | "archive-state-taken" | "archive-state-unknown" {
  return state === "free" ? "archive-state-free" : state === "taken" ? "archive-state-taken" : "archive-state-unknown";
}

function estimate(heat: StallsUse, at: number): { value: number | null; low: number | null; high: number | null; surveys: number } {
  return { value: heat.share[at] ?? null, low: heat.low[at] ?? null, high: heat.high[at] ?? null, surveys: heat.surveys[at] ?? 0 };
}

/**
 * A survey whose stalls are coloured by the share of surveys that found them taken; unclear where none saw it. Labels are
 * those of the list, of the present plan.
 */
export function byShare(shown: SurveyOnMap, heat: StallsUse): SurveyOnMap {
  const columns = new Map(heat.ids.map((id, k) => [id, k]));
  const stalls = shown.stalls.map((stall, k) => {
    const column = columns.get(shown.ids[k] ?? "");
    const value = column === undefined ? null : (heat.share[column] ?? null);
    const label = column === undefined ? stall.label : (heat.labels[column] ?? stall.label);
    return value === null ? { ...stall, label, state: "unknown" as const } : { ...stall, label, state: "free" as const, heat: heatClass(value) };
  });
  return { ...shown, stalls, rows: rowMarks(stalls) };
}

/** The same answer for the same values: the map is not drawn again then. */
function kept<One, Other, Made>(make: (one: One, other: Other) => Made): (one: One, other: Other) => Made {
  let last: { one: One; other: Other; made: Made } | null = null;
  return (one, other) => {
    if (last?.one !== one || last.other !== other) last = { one, other, made: make(one, other) };
    return last.made;
  };
}

function legend(): TemplateResult {
  const steps = HEAT.map((fill) => html`<i class="key heat" ${cssVars({ "--heat": css({ ...fill, alpha: 1 }) })}></i>`);
  return html`<span class="steps">${steps}</span><span>${say("ask-scale")}</span><i class="key unknown"></i><span>${say("archive-unseen")}</span>`;
}
