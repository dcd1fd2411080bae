import { html, nothing, type TemplateResult } from "lit";
import { customElement, property, query } from "lit/decorators.js";
import { isFlying } from "../state/flight.ts";
import { isViewer } from "../words/actions.ts";
import { say } from "../words/say.ts";
import { linkOf } from "../words/view.ts";
import { Part } from "./element.ts";
import { icon } from "./icons.ts";

/** As the drone allows. */
export const LONGEST_NAME = 24;

/** The name by which the others know this operator: asked for once when the page is opened, changed in the settings. */
@customElement("hawk-name")
export class OwnName extends Part {
  /** Asks once, as a strip above the map; otherwise it is a row of the settings. */
  @property({ type: Boolean }) asks = false;
  @query("input") private field!: HTMLInputElement;

  override render(): TemplateResult | typeof nothing {
    if (isViewer(this.model.view())) return nothing; // its name would stand beside nothing
    return this.asks ? this.strip() : this.row();
  }

  private strip(): TemplateResult | typeof nothing {
    const view = this.model.view();
    const isWanted = this.model.preferences.name === null && linkOf(view) === "live";
    if (!isWanted || this.model.drawing !== null || isFlying(view.heartbeat)) return nothing; // the map needs the room
    return html`<form class="banner name" aria-label=${say("your-name")} @submit=${this.save}>
      ${icon("person")}
      <div>
        <div class="big">${say("name-question")}</div>
        <div>${say("name-note")}</div>
      </div>
      <div class="act-side">
        ${this.input("")}<button type="submit">${say("save")}</button>
        <button type="button" @click=${() => this.model.rename("")}>${say("not-now")}</button>
      </div>
    </form>`;
  }

  private row(): TemplateResult {
    const shown = this.model.view().heartbeat?.["Own Name"];
    return html`<form class="own-name" aria-label=${say("your-name")} @submit=${this.save}>
      <label><b>${say("your-name")}</b><span class="sub">${shown ? say("others-read", { name: shown }) : say("others-read-it")}</span>
        ${this.input(this.model.preferences.name ?? "")}
      </label>
      <button type="submit">${say("save")}</button>
    </form>`;
  }

  private input(value: string): TemplateResult {
    return html`<input type="text" name="name" aria-label=${say("your-name")} autocomplete="nickname" maxlength=${LONGEST_NAME} .defaultValue=${value} />`;
  }

  private readonly save = (event: Event): void => {
    event.preventDefault();
    this.model.rename(this.field.value.trim());
  };
}
