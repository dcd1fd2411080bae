import { html, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import type { Units } from "../words/units.ts";
import { Part } from "./element.ts";

const UNITS: [Units, string][] = [
  ["metres", "Metres"],
  ["feet", "Feet"],
];

/** Units in which this page shows and takes lengths. */
@customElement("hawk-units")
export class UnitsSetting extends Part {
  override render(): TemplateResult {
    const { units } = this.model.preferences;
    return html`<fieldset>
      <legend>Units</legend>
      <div class="segments">
        ${UNITS.map(
          ([value, text]) => html`<label class=${units === value ? "on" : ""}>
            <input type="radio" name="units" .checked=${units === value} @change=${() => this.model.prefer({ units: value })} />
            ${text}
          </label>`,
        )}
      </div>
      <span class="sub">The drone's own messages stay in metres.</span>
    </fieldset>`;
  }
}
