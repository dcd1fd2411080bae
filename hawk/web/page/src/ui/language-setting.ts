import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import type { LanguageChoice } from "../state/preferences.ts";
import { type LanguageName, LANGUAGES } from "../words/languages.ts";
import { say } from "../words/say.ts";
import { Part } from "./element.ts";

const NAMES = Object.keys(LANGUAGES) as LanguageName[];

/** Language of this page; each stands in its own words. */
@customElement("hawk-language")
export class LanguageSetting extends Part {
  override render(): TemplateResult {
    return html`<fieldset>
      <legend>${say("language")}</legend>
      <div class="segments">
        ${this.choice("auto", say("language-auto"))} ${NAMES.map((name) => this.choice(name, LANGUAGES[name].label))}
      </div>
      <span class="sub">${say("language-note")}</span>
    </fieldset>`;
  }

  private choice(value: LanguageChoice, text: string): TemplateResult {
    const isChosen = this.model.preferences.language === value;
    return html`<label class=${isChosen ? "on" : ""} lang=${value === "auto" ? nothing : value}>
      <input type="radio" name="language" .checked=${isChosen} @change=${() => this.model.prefer({ language: value })} />
      ${text}
    </label>`;
  }
}
