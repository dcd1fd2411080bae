import { html, nothing, type TemplateResult } from "lit";
import { customElement, query, state } from "lit/decorators.js";
import { cannot } from "../words/actions.ts";
import { heightsProblem } from "../words/heights.ts";
import { say } from "../words/say.ts";
import { metresKept, SCALES, typed, type Units } from "../words/units.ts";
import { Part } from "./element.ts";
import { noted, quoting } from "./quoting.ts";

type Field = "Min" | "Des" | "Max";

const LABELS = { Min: "lowest-label", Des: "desired-label", Max: "highest-label" } as const;

/** Opens the dialog in which the three heights are set. */
@customElement("hawk-heights-button")
export class HeightsButton extends Part {
  @state() private values: Record<Field, string> = { Min: "", Des: "", Max: "" };
  @state() private problem = "";
  /** The drone's own words in it. */
  private quoted = "";
  /** What was typed is in these: others may be chosen while the dialog is open. */
  private units: Units = "metres";
  private inForce: readonly number[] = [];
  @query("dialog") private dialog!: HTMLDialogElement;

  override render(): TemplateResult {
    const reason = cannot(this.model.view(), "Configure");
    return html`<button ?disabled=${reason !== ""} @click=${() => this.open()}>
        <span class="two">${say("change-heights")}${reason === "" ? nothing : html`<span class="sub">${noted(this.model.view(), reason)}</span>`}</span>
      </button>
      <dialog class="float" aria-label=${say("heights")} @keydown=${(event: KeyboardEvent) => this.key(event)}>
        <form @submit=${(event: Event) => void this.save(event)}>
          <h2>${say("heights")}</h2>
          <p class="sub">${say("heights-unit", { units: this.units })}</p>
          ${(Object.keys(LABELS) as Field[]).map((field) => this.field(field))}
          <p class="problem" role="alert">${quoting(this.problem, [this.quoted])}</p>
          <div class="row">
            <button type="button" @click=${() => this.dialog.close()}>${say("cancel")}</button>
            <button type="submit" class="primary">${say("save-heights")}</button>
          </div>
        </form>
      </dialog>`;
  }

  private field(field: Field): TemplateResult {
    return html`<label class="number"
      >${say(LABELS[field])}
      <span>
        <input
          inputmode="decimal"
          name=${field}
          .value=${this.values[field]}
          @input=${(event: Event) => {
            this.values = { ...this.values, [field]: (event.target as HTMLInputElement).value };
            this.problem = "";
          }}
        />${SCALES[this.units].symbol}
      </span>
    </label>`;
  }

  private key(event: KeyboardEvent): void {
    if (event.key !== "Escape") return;
    event.preventDefault();
    this.dialog.close();
  }

  private open(): void {
    const { heartbeat, units } = this.model.view();
    this.inForce = heartbeat?.Heights ?? [];
    this.units = units;
    const offered = (index: number): string => (this.inForce[index] === undefined ? "" : typed(this.inForce[index], units));
    this.values = { Min: offered(0), Des: offered(1), Max: offered(2) };
    this.problem = "";
    this.dialog.show();
  }

  private async save(event: Event): Promise<void> {
    event.preventDefault();
    const number = (field: Field, index: number): number =>
      metresKept(this.values[field], this.inForce[index] ?? null, this.units) ?? Number.NaN;
    const [Min, Des, Max] = [number("Min", 0), number("Des", 1), number("Max", 2)];
    this.problem = heightsProblem(Min, Des, Max, this.model.view().heartbeat?.Ceiling ?? null, this.units);
    if (this.problem !== "") return;
    if (await this.model.command({ Type: "Configure", Min, Des, Max }, say("change-heights"))) this.dialog.close();
    else {
      this.quoted = this.model.toasts.shown?.quoted ?? "";
      this.problem = this.model.toasts.shown?.text ?? say("heights-not-stored");
    }
  }
}
