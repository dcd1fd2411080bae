import { html, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { say } from "../words/say.ts";
import type { Units } from "../words/units.ts";
import { Part } from "./element.ts";

const UNITS: Units[] = ["metres", "feet"];

/** Units in which this page shows and takes lengths. */
@customElement("hawk-units")
export class UnitsSetting extends Part {
  override render(): TemplateResult {
    const { units } = this.model.preferences;
    return html`<fieldset>
      <legend>${say("units")}</legend>
      <div class="segments">
        ${UNITS.map(
          (value) => html`<label class=${units === value ? "on" : ""}>
            <input type="radio" name="units" .checked=${units === value} @change=${() => this.model.prefer({ units: value })} />
            ${say(`units-${value}`)}
          </label>`,
        )}
      </div>
      <span class="sub">${say("units-note")}</span>
    </fieldset>`;
  }
}
