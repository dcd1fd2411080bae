import { html, nothing, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import { type Kind, KINDS, type PlanStall, partsOf } from "../plan/values.ts";
import { renameRow, reverseRow, rowsChosen, shiftNumbers, swapRows } from "../state/plan-labels.ts";
import { kindWords, labelWords } from "../words/plan.ts";
import { say } from "../words/say.ts";
import { metresOf, SCALES, typed } from "../words/units.ts";
import { Part } from "./element.ts";
import { icon } from "./icons.ts";

const ALL = "*";
const MIXED = "?";
/** Most characters of a row's letters; more are a name. */
const LETTERS = 3;

/** What can be done with the stalls of a plan that are chosen. */
@customElement("hawk-plan-chosen")
export class PlanChosen extends Part {
  @state() private problem = "";

  override render(): TemplateResult {
    const { plan } = this.model;
    const { chosen } = plan;
    const off = !plan.mayEdit || chosen.length === 0;
    return html`<div class="chosen">
      <div class="pick">
        <b role="status">${say("plan-chosen", { stalls: chosen.length, label: chosen[0]?.label ?? "" })}</b>
        ${chosen.length === 0 ? nothing : html`<span class="sub">${labelWords(chosen)}</span>`}
        <label><span class="sub">${say("plan-row-choice")}</span> ${this.rows(chosen)}</label>
      </div>
      <div class="does">
        ${
          chosen.length === 0
            ? html`<button ?disabled=${!plan.mayEdit || plan.plan.stalls.size === 0} @click=${() => plan.do({ do: "confirm", all: true })}>${icon("check")}${say("plan-confirm-all")}</button>`
            : html`<button ?disabled=${off} @click=${() => plan.doChosen((stalls) => ({ do: "confirm", stalls }))}>${icon("check")}${say("plan-confirm")}</button>`
        }
        <button ?disabled=${off} @click=${() => plan.doChosen((stalls) => ({ do: "remove", stalls }))}>${icon("clear")}${say("plan-remove")}</button>
        <label><span class="sub">${say("plan-kind")}</span> ${this.kinds(chosen, off)}</label>
      </div>
      ${chosen.length === 0 ? nothing : this.labels(chosen, off)} ${chosen.length === 0 ? nothing : this.more(chosen)}
    </div>`;
  }

  /** The labels as they are painted: a row's name, its first end, its numbers. */
  private labels(chosen: readonly PlanStall[], off: boolean): TemplateResult {
    const { plan } = this.model;
    const named = rowsChosen(plan);
    const shift = (by: number): TemplateResult => {
      const words = say("plan-shift-by", { by: `${by > 0 ? "+" : "−"}1` });
      const key = say(by > 0 ? "plan-key-up" : "plan-key-down");
      return html`<button ?disabled=${off} title=${`${words} (${key})`} aria-label=${words} @click=${() => shiftNumbers(plan, by)}>${by > 0 ? "+1" : "−1"}</button>`;
    };
    return html`<div class="does labels" role="group" aria-label=${say("plan-labels")}>
      <form @submit=${this.rename}>
        ${field("to", say("plan-row-name"), named[0] ?? "", "text")}
        <button type="submit" ?disabled=${off} title=${`${say("plan-rename")} (N)`}>${say("plan-rename")}</button>
      </form>
      <button ?disabled=${off || named.length !== 2} title=${named.length === 2 ? `${say("plan-swap")} (X)` : say("plan-swap-two")} @click=${() => swapRows(plan)}>${say("plan-swap")}</button>
      ${shift(-1)} ${shift(1)}
      <button ?disabled=${off || chosen.length < 2} title=${`${say("plan-reverse")} (I)`} @click=${() => reverseRow(plan)}>${say("plan-reverse")}</button>
    </div>`;
  }

  private readonly rename = (event: Event): void => {
    const to = fieldsOf(event)("to").trim();
    if (to !== "") renameRow(this.model.plan, to);
  };

  /** N is pressed: the row's name is typed. */
  override updated(): void {
    const { plan } = this.model;
    if (!plan.naming) return;
    plan.naming = false;
    const typedName = this.renderRoot.querySelector<HTMLInputElement>("[name=to]");
    typedName?.focus();
    typedName?.select();
  }

  private rows(chosen: readonly PlanStall[]): TemplateResult {
    const { plan } = this.model;
    const { rows } = plan.plan.summary;
    const [first] = chosen;
    const row = first && chosen.every(({ label }) => partsOf(label)?.row === partsOf(first.label)?.row) ? (partsOf(first.label)?.row ?? "") : "";
    const isAll = chosen.length > 0 && chosen.length === plan.plan.stalls.size;
    const choose = (event: Event): void => {
      const { value } = event.target as HTMLSelectElement;
      if (value === ALL) plan.choose(plan.plan.stalls.keys());
      else if (value === "") plan.choose([]);
      else plan.chooseRow(value);
    };
    return html`<select name="row" .value=${isAll ? ALL : row} @change=${choose}>
      <option value="" ?selected=${!isAll && row === ""}>${say("plan-row-none")}</option>
      ${rows.map((each) => html`<option value=${each} ?selected=${!isAll && each === row}>${each}</option>`)}
      <option value=${ALL} ?selected=${isAll}>${say("plan-row-all")}</option>
    </select>`;
  }

  private kinds(chosen: readonly PlanStall[], off: boolean): TemplateResult {
    const [first] = chosen;
    const shown = first && chosen.some(({ kind }) => kind !== first.kind) ? MIXED : (first?.kind ?? "");
    const set = (event: Event): void => {
      const { value } = event.target as HTMLSelectElement;
      if (value !== MIXED) this.model.plan.doChosen((stalls) => ({ do: "set_kind", stalls, kind: value as Kind }));
    };
    return html`<select name="kind" ?disabled=${off} .value=${shown} @change=${set}>
      ${shown === MIXED ? html`<option value=${MIXED} selected>${say("plan-kind-mixed")}</option>` : nothing}
      ${KINDS.map((kind) => html`<option value=${kind} ?selected=${kind === shown}>${kindWords(kind)}</option>`)}
    </select>`;
  }

  private more(chosen: readonly PlanStall[]): TemplateResult {
    const [first] = chosen;
    const { units } = this.model.preferences;
    const unit = SCALES[units].symbol;
    return html`<details class="more">
      <summary>${say("plan-more")}</summary>
      <form @submit=${this.widen}>
        ${field("width", say("plan-width", { unit }), typed(first?.width ?? 0, units))} ${field("length", say("plan-length", { unit }), typed(first?.length ?? 0, units))}
        <button type="submit" aria-label=${say("plan-set-size")}>${say("plan-set")}</button>
      </form>
      <form @submit=${this.turn}>${field("turn", say("plan-turn"), "90")}<button type="submit">${say("plan-turn-do")}</button></form>
      ${
        chosen.length === 1
          ? html`<form @submit=${this.split}>${field("parts", say("plan-parts"), "2")}<button type="submit">${say("plan-split")}</button></form>`
          : nothing
      }
      <form @submit=${this.renumber}>
        ${field("letter", say("plan-letter"), partsOf(first?.label ?? "")?.row ?? "", "text")} ${field("first", say("plan-first"), "1")}
        <button type="submit">${say("plan-renumber")}</button>
      </form>
      <div role="alert" class="sub problem">${this.problem}</div>
    </details>`;
  }

  private readonly widen = (event: Event): void => {
    const read = fieldsOf(event);
    const { units } = this.model.preferences;
    const [width, length] = [metresOf(read("width"), units), metresOf(read("length"), units)];
    const unit = SCALES[units].symbol;
    if (width === null) this.problem = say("plan-bad-number", { field: say("plan-width", { unit }) });
    else if (length === null) this.problem = say("plan-bad-number", { field: say("plan-length", { unit }) });
    else this.do(() => this.model.plan.doChosen((stalls) => ({ do: "widen", stalls, width, length })));
  };

  private readonly turn = (event: Event): void => {
    const degrees = numberOf(fieldsOf(event)("turn"));
    if (degrees === null || Math.abs(degrees) > 360) this.problem = say("plan-bad-number", { field: say("plan-turn") });
    else this.do(() => this.model.plan.doChosen((stalls) => ({ do: "turn", stalls, by: (degrees * Math.PI) / 180, about: "middle" })));
  };

  private readonly split = (event: Event): void => {
    const parts = numberOf(fieldsOf(event)("parts"));
    const [stall] = this.model.plan.chosen;
    if (parts === null || !Number.isInteger(parts)) this.problem = say("plan-bad-number", { field: say("plan-parts") });
    else if (stall) this.do(() => this.model.plan.do({ do: "split", stall: stall.id, parts }));
  };

  private readonly renumber = (event: Event): void => {
    const read = fieldsOf(event);
    const first = numberOf(read("first"));
    const name = read("letter").trim();
    const letter = name.length <= LETTERS ? name.toUpperCase() : name;
    if (first === null || !Number.isInteger(first)) this.problem = say("plan-bad-number", { field: say("plan-first") });
    else {
      const stalls = this.model.plan.chosen.map(({ id }) => id);
      this.do(() => this.model.plan.do({ do: "renumber", stalls, letter, first }));
    }
  };

  private do(run: () => void): void {
    this.problem = "";
    run();
  }
}

function field(name: string, label: string, value: string, mode: "decimal" | "text" = "decimal"): TemplateResult {
  return html`<label><span class="sub">${label}</span><input name=${name} inputmode=${mode} autocomplete="off" .defaultValue=${value} /></label>`;
}

function fieldsOf(event: Event): (name: string) => string {
  event.preventDefault();
  const { elements } = event.currentTarget as HTMLFormElement;
  return (name) => (elements.namedItem(name) as HTMLInputElement).value;
}

function numberOf(text: string): number | null {
  const value = Number(text.trim().replace(",", ".").replace("−", "-") || Number.NaN);
  return Number.isFinite(value) ? value : null;
}
