import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import type { Theme } from "../state/preferences.ts";
import { control, isViewer, viewerWords } from "../words/actions.ts";
import * as format from "../words/format.ts";
import { say } from "../words/say.ts";
import type { View } from "../words/view.ts";
import "./all-settings.ts";
import { Part } from "./element.ts";
import "./fence-button.ts";
import "./language-setting.ts";
import "./outline-button.ts";
import "./own-name.ts";
import "./units-setting.ts";

const THEMES: Theme[] = ["auto", "light", "dark", "outdoor"];

/** Heights, fence, control, and how this page looks. */
@customElement("hawk-settings")
export class SettingsTab extends Part {
  override render(): TemplateResult {
    const view = this.model.view();
    const { theme, leftHanded } = this.model.preferences;
    return html`<div tabindex="0" role="region" aria-label=${say("settings")} class="scroll settings">
      ${view.welcome?.Desk ? nothing : this.ofFlight(view)}
      <section><hawk-name .model=${this.model}></hawk-name></section>
      <section>
        <fieldset>
          <legend>${say("appearance")}</legend>
          <div class="segments">
            ${THEMES.map(
              (value) => html`<label class=${theme === value ? "on" : ""}>
                <input type="radio" name="theme" .checked=${theme === value} @change=${() => this.model.prefer({ theme: value })} />
                ${say(`theme-${value}`)}
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
          <span><b>${say("left-handed")}</b><span class="sub">${say("left-handed-note")}</span></span>
        </label>
      </section>
      <section>
        <label class="toggle">
          <input
            type="checkbox"
            .checked=${this.model.preferences.sound}
            @change=${(event: Event) => this.model.prefer({ sound: (event.target as HTMLInputElement).checked })}
          />
          <span><b>${say("sound")}</b><span class="sub">${say("sound-note")}</span></span>
        </label>
      </section>
      ${view.welcome?.Login ? this.logOutRow(view) : nothing}
      <section><hawk-all-settings .model=${this.model}></hawk-all-settings></section>
      ${about(view)}
    </div>`;
  }

  private ofFlight(view: View): TemplateResult {
    return html`<section>${heights(view)}<hawk-heights-button .model=${this.model}></hawk-heights-button></section>
      <section><hawk-fence-button .model=${this.model}></hawk-fence-button></section>
      <section><hawk-outline-button .model=${this.model}></hawk-outline-button></section>
      <section>${this.controlRow(view)}</section>`;
  }

  private logOutRow(view: View): TemplateResult {
    const reason = logOutReason(view);
    return html`<section>
      <div><b>${say(`logged-in-${view.welcome?.Role ?? "operator"}`)}</b><span class="sub">${say("on-this-browser")}</span></div>
      <button ?disabled=${reason !== ""} @click=${() => this.model.logOut()}>
        <span class="two">${say("log-out")}${reason === "" ? nothing : html`<span class="sub">${reason}</span>`}</span>
      </button>
    </section>`;
  }

  private controlRow(view: View): TemplateResult {
    if (isViewer(view)) {
      const { title, text } = viewerWords();
      return html`<div><b>${title}</b><span class="sub">${text}</span></div>`;
    }
    const whose = control(view);
    if (whose === "mine") {
      return html`<div><b>${say("you-have-control")}</b><span class="sub">${say("you-have-control-text")}</span></div>
        <button @click=${() => void this.model.releaseControl()}>${say("give-back-control")}</button>`;
    }
    return html`<div><b>${say(WHOSE[whose])}</b><span class="sub">${say("take-in-bar")}</span></div>`;
  }
}

/** The one in control gives it back first: log-out ends the link, and the drone would hold and come home. */
function logOutReason(view: View): string {
  return control(view) === "mine" ? say("give-back-first") : "";
}

const WHOSE = {
  free: "nobody-has-control",
  lost: "operator-in-control-lost",
  other: "someone-has-control",
  unknown: "control-not-known",
} as const;

function about(view: View): TemplateResult {
  return html`<p class="sub">
    ${view.welcome ? say("version", { version: view.welcome.Version }) : nothing}
    <a href="docs/" hreflang="en" target="_blank">${say("documentation")}</a>
    <a href="licences.txt" target="_blank">${say("licences")}</a>
  </p>`;
}

export function heights(view: View): TemplateResult {
  const [min, des, max] = view.heartbeat?.Heights ?? [];
  if (min === undefined || des === undefined || max === undefined) {
    return html`<div><b>${say("heights")}</b><span class="sub">${say("heights-not-known")}</span></div>`;
  }
  return html`<div>
    <b>${say("flies-at-height", { height: format.height(des, view.units) })}</b>
    <span class="sub">${say("never-below-or-above", { lowest: format.height(min, view.units), highest: format.height(max, view.units) })}</span>
  </div>`;
}
