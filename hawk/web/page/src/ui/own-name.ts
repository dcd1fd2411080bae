import { html, nothing, type TemplateResult } from "lit";
import { customElement, property, query } from "lit/decorators.js";
import { isViewer } from "../words/actions.ts";
import { say } from "../words/say.ts";
import { linkOf } from "../words/view.ts";
import { Part } from "./element.ts";

/** As the drone allows. */
export const LONGEST_NAME = 24;

/** The name by which the others know this operator: asked for beside Take control, changed in the settings. */
@customElement("hawk-name")
export class OwnName extends Part {
  /** Asks in the bar of those who watch, until there is a name; otherwise it is a row of the settings. */
  @property({ type: Boolean }) asks = false;
  @query("input") private field!: HTMLInputElement;

  override render(): TemplateResult | typeof nothing {
    if (isViewer(this.model.view())) return nothing; // its name would stand beside nothing
    return this.asks ? this.question() : this.row();
  }

  /** A field and no more: left empty, nothing more is asked, in flight or on the ground. */
  private question(): TemplateResult | typeof nothing {
    if (this.model.preferences.name || linkOf(this.model.view()) !== "live") return nothing;
    return html`<form class="who-asks" aria-label=${say("name-question")} @submit=${this.save} @change=${this.save}>
      <label><span class="sub">${say("your-name")}</span>${this.input("")}</label>
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
    return html`<input type="text" name="name" aria-label=${say("your-name")} title=${say("others-read-it")} autocomplete="nickname" maxlength=${LONGEST_NAME} .defaultValue=${value} />`;
  }

  private readonly save = (event: Event): void => {
    event.preventDefault();
    const name = this.field.value.trim();
    if (!this.asks || name !== "") this.model.rename(name);
  };
}
