import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import type { Observation, StallsUse, SurveysUse } from "../api.ts";
import { number, say } from "../words/say.ts";
import { heatClass, moment, share } from "./figures.ts";
import { type Ground, groundOf, originOf } from "./ground.ts";
import type { Features } from "./survey-source.ts";
import type { Shade } from "./plan-view.ts";
import "./plan-view.ts";
import { Asked, View } from "./view.ts";

/** Every stall by the share of surveys that found it taken, and the last looks at one of them. */
@customElement("archive-stalls")
export class StallsView extends View {
  private readonly heat = new Asked<StallsUse>(this);
  private readonly listed = new Asked<SurveysUse>(this);
  private readonly shown = new Asked<Features>(this);
  private readonly looks = new Asked<Observation[]>(this);

  override willUpdate(): void {
    const { from, to, lot, stall } = this.place;
    const key = JSON.stringify([lot, from, to, this.revision]);
    this.heat.ask(key, () => this.source.heat({ from, to }));
    this.listed.ask(key, () => this.source.surveys({ from, to }));
    const newest = this.listed.value?.surveys.find((row) => row.left_out_code === "");
    if (newest) this.shown.ask(newest.id, () => this.source.features(newest.id));
    if (stall !== "") this.looks.ask(`${stall} ${this.revision}`, () => this.source.looks(stall));
  }

  override render(): TemplateResult {
    const problem = this.heat.problem || this.listed.problem || this.shown.problem;
    if (problem !== "") return html`<p role="alert">${problem}</p>`;
    const [heat, shown] = [this.heat.value, this.shown.value];
    if (heat === null) return html`<p>${say("archive-asking")}</p>`;
    if (heat.ids.length === 0 || heat.surveys_in_period === 0) return html`<p>${say("archive-none-counts")}</p>`;
    return html`<p>${say("archive-heat-note", { surveys: heat.surveys_in_period })}</p>
      ${shown === null ? nothing : this.drawn(heat, shown)} ${legend()}
      <label class="fields">${say("archive-stall")}
        <select @change=${(event: Event) => this.go({ stall: (event.target as HTMLSelectElement).value })}>
          <option value="">${say("archive-choose-stall")}</option>
          ${heat.ids.map((id, k) => html`<option value=${id} ?selected=${id === this.place.stall}>${heat.labels[k]}</option>`)}
        </select></label>
      ${this.place.stall === "" ? nothing : this.one(heat)}`;
  }

  private drawn(heat: StallsUse, shown: Features): TemplateResult | typeof nothing {
    const origin = originOf(shown.features);
    if (origin === null) return nothing;
    const ground = groundOf(shown.features, origin);
    return html`<archive-plan .ground=${ground} .shades=${byHeat(ground, heat)} .label=${say("archive-heat")} .chosen=${this.place.stall}
      @stall=${(event: CustomEvent<string>) => this.go({ stall: event.detail })}></archive-plan>`;
  }

  private one(heat: StallsUse): TemplateResult {
    const at = heat.ids.indexOf(this.place.stall);
    const { value, problem } = this.looks;
    const found = { value: heat.share[at] ?? null, low: heat.low[at] ?? null, high: heat.high[at] ?? null, surveys: heat.surveys[at] ?? 0 };
    return html`<section class="card" aria-live="polite"><h2>${say("archive-stall-of", { label: heat.labels[at] ?? value?.[0]?.label ?? "" })}</h2>
      <p>${say("archive-stall-share", { surveys: found.surveys })} ${share(found)}</p>
      ${problem === "" ? nothing : html`<p role="alert">${problem}</p>`}
      <ol class="looks">${(value ?? []).map(
        (look) => html`<li><i class="key ${look.state}"></i>${moment(look.observed, this.listed.value?.clock)} · ${say(stateKey(look.state))} · ${say("archive-chance-taken", { value: number(100 * look.taken_probability) })}</li>`,
      )}</ol></section>`;
  }
}

function stateKey(state: string): "archive-state-free" | "archive-state-taken" | "archive-state-unknown" {
  return state === "free" ? "archive-state-free" : state === "taken" ? "archive-state-taken" : "archive-state-unknown";
}

/** Stalls by the class of their share. */
export function byHeat(ground: Ground, heat: StallsUse): Shade[] {
  const shares = new Map(heat.ids.map((id, k) => [id, heat.share[k] ?? null]));
  return [-1, 0, 1, 2, 3, 4].map((step) => ({
    name: step < 0 ? "unknown" : `heat${step}`,
    stalls: ground.stalls.filter(({ id }) => heatClass(shares.get(id) ?? null) === step),
  }));
}

function legend(): TemplateResult {
  const steps = [0, 1, 2, 3, 4].map((step) => html`<span><i class="key heat${step}"></i>${say("archive-from-to-percent", { low: 20 * step, high: 20 * step + 20 })}</span>`);
  return html`<p class="legend">${steps}<span><i class="key unknown"></i>${say("archive-unseen")}</span></p>`;
}
