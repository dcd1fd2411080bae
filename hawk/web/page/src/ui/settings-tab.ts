import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import type { Theme } from "../state/preferences.ts";
import { control, isViewer, VIEWER_WORDS } from "../words/actions.ts";
import * as format from "../words/format.ts";
import type { View } from "../words/view.ts";
import "./all-settings.ts";
import { Part } from "./element.ts";
import "./fence-button.ts";
import "./language-setting.ts";
import "./outline-button.ts";
import "./own-name.ts";
import "./units-setting.ts";

const THEMES: [Theme, string][] = [
  ["auto", "As this device"],
  ["light", "Light"],
  ["dark", "Dark"],
  ["outdoor", "Outdoors"],
];

/** Heights, fence, control, and how this page looks. */
@customElement("hawk-settings")
export class SettingsTab extends Part {
  override render(): TemplateResult {
    const view = this.model.view();
    const { theme, leftHanded } = this.model.preferences;
    return html`<div tabindex="0" role="region" aria-label="Settings" class="scroll settings">
      <section>${heights(view)}<hawk-heights-button .model=${this.model}></hawk-heights-button></section>
      <section><hawk-fence-button .model=${this.model}></hawk-fence-button></section>
      <section><hawk-outline-button .model=${this.model}></hawk-outline-button></section>
      <section>${this.controlRow(view)}</section>
      <section><hawk-name .model=${this.model}></hawk-name></section>
      <section>
        <fieldset>
          <legend>Appearance</legend>
          <div class="segments">
            ${THEMES.map(
              ([value, text]) => html`<label class=${theme === value ? "on" : ""}>
                <input type="radio" name="theme" .checked=${theme === value} @change=${() => this.model.prefer({ theme: value })} />
                ${text}
              </label>`,
            )}
          </div>
        </fieldset>
      </section>
      <section><hawk-units .model=${this.model}></hawk-units></section>
      <section><hawk-language .model=${this.model}></hawk-language></section>
      <section>
        <label class="toggle">
          <input
            type="checkbox"
            .checked=${leftHanded}
            @change=${(event: Event) => this.model.prefer({ leftHanded: (event.target as HTMLInputElement).checked })}
          />
          <span><b>Left-handed</b><span class="sub">Hold and Land in the lower left corner</span></span>
        </label>
      </section>
      <section>
        <label class="toggle">
          <input
            type="checkbox"
            .checked=${this.model.preferences.sound}
            @change=${(event: Event) => this.model.prefer({ sound: (event.target as HTMLInputElement).checked })}
          />
          <span><b>Sound</b><span class="sub">Tone and voice: lost link, low battery, and others who act</span></span>
        </label>
      </section>
      ${view.welcome?.Login ? this.logOutRow(view) : nothing}
      <section><hawk-all-settings .model=${this.model}></hawk-all-settings></section>
      <p class="sub">${view.welcome ? `Parking Lot Hawk ${view.welcome.Version}` : nothing} <a href="licences.txt" target="_blank">Licences</a></p>
    </div>`;
  }

  private logOutRow(view: View): TemplateResult {
    const reason = logOutReason(view);
    return html`<section>
      <div><b>Logged in as ${view.welcome?.Role}</b><span class="sub">On this browser</span></div>
      <button ?disabled=${reason !== ""} @click=${() => this.model.logOut()}>
        <span class="two">Log out${reason === "" ? nothing : html`<span class="sub">${reason}</span>`}</span>
      </button>
    </section>`;
  }

  private controlRow(view: View): TemplateResult {
    if (isViewer(view)) return html`<div><b>${VIEWER_WORDS.title}</b><span class="sub">${VIEWER_WORDS.text}</span></div>`;
    const whose = control(view);
    if (whose === "mine") {
      return html`<div><b>You have control</b><span class="sub">Others watch; every operator may Hold.</span></div>
        <button @click=${() => void this.model.releaseControl()}>Give back control</button>`;
    }
    return html`<div><b>${WHOSE[whose]}</b><span class="sub">Take it in the bar at the bottom.</span></div>`;
  }
}

/** The one in control gives it back first: log-out ends the link, and the drone would hold and come home. */
function logOutReason(view: View): string {
  return control(view) === "mine" ? "Give back control first" : "";
}

const WHOSE = {
  free: "Nobody has control",
  lost: "The operator in control is lost",
  other: "Someone else has control",
  unknown: "Control is not known",
};

export function heights(view: View): TemplateResult {
  const [min, des, max] = view.heartbeat?.Heights ?? [];
  if (min === undefined || des === undefined || max === undefined) {
    return html`<div><b>Heights</b><span class="sub">not known yet</span></div>`;
  }
  return html`<div>
    <b>Flies at ${format.height(des, view.units)}</b>
    <span class="sub">never below ${format.height(min, view.units)} or above ${format.height(max, view.units)}</span>
  </div>`;
}
