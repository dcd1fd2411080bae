import { html, nothing, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import { say } from "../words/say.ts";
import { NOTHING_TYPED, type TypedMove, typedPlace } from "../words/typed-move.ts";
import { SCALES } from "../words/units.ts";
import { Part } from "./element.ts";

const FIELDS = { north: "move-north", east: "move-east", height: "move-height" } as const;

/** A place to move to by typed metres, while one is asked for: in place of a click on the map. */
@customElement("hawk-move-fields")
export class MoveFields extends Part {
  @state() private move: TypedMove = NOTHING_TYPED;
  @state() private problem = "";
  /** Unfolded: until then the map has the room. */
  @state() private open = false;

  override render(): TemplateResult | typeof nothing {
    if (!this.model.picking) return nothing;
    if (!this.open) return html`<div class="measure folded"><button @click=${() => (this.open = true)}>${say("move-typed")}</button></div>`;
    return html`<form class="measure typed" aria-label=${say("move-typed")} @submit=${this.ask}>
      <span class="txt"><b>${say("move-typed")}</b>${this.problem === "" ? nothing : html`<span class="sub problem" role="alert">${this.problem}</span>`}</span>
      ${(Object.keys(FIELDS) as (keyof typeof FIELDS)[]).map((field) => this.field(field))}
      <label><span class="sub">${say("move-from")}</span>
        <select name="from" @change=${(event: Event) => this.type({ from: (event.target as HTMLSelectElement).value === "home" ? "home" : "drone" })}>
          <option value="drone" ?selected=${this.move.from === "drone"}>${say("move-from-drone")}</option>
          <option value="home" ?selected=${this.move.from === "home"}>${say("move-from-home")}</option>
        </select>
      </label>
      <button type="submit" class="set">${say("move-set")}</button>
    </form>`;
  }

  private field(field: keyof typeof FIELDS): TemplateResult {
    const unit = SCALES[this.model.view().units].symbol;
    return html`<label><span class="sub">${say(FIELDS[field], { unit })}</span>
      <input
        inputmode=${field === "height" ? "decimal" : "text"}
        name=${field}
        autocomplete="off"
        .value=${this.move[field]}
        @input=${(event: Event) => this.type({ [field]: (event.target as HTMLInputElement).value })}
      />
    </label>`;
  }

  private type(change: Partial<TypedMove>): void {
    this.move = { ...this.move, ...change };
    this.problem = "";
  }

  private readonly ask = (event: Event): void => {
    event.preventDefault();
    const view = this.model.view();
    const place = typedPlace(view.heartbeat, this.move, view.units);
    if (typeof place === "string") {
      this.problem = place;
      return;
    }
    this.move = { ...NOTHING_TYPED, from: this.move.from };
    this.model.ask({ about: "move", ...place, ...(place.height === undefined ? {} : { kind: "Compulsive Move" as const }) });
  };
}
