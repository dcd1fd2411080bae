import { html, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { keyRows } from "../words/keys.ts";
import { say } from "../words/say.ts";
import { Part } from "./element.ts";

/** The keys that the page knows. */
@customElement("hawk-keys")
export class KeysList extends Part {
  override render(): TemplateResult {
    const version = this.model.view().welcome?.Version;
    const documentation = version === undefined ? say("documentation") : say("documentation-of", { version });
    return html`<div class="scroll keylist" tabindex="0" role="region" aria-label=${say("all-keys")}>
      <h2>${say("keys")}</h2>
      <dl>
        ${keyRows().map(([key, label]) => html`<div><dt><kbd>${key}</kbd></dt><dd>${label}</dd></div>`)}
      </dl>
      <p class="sub">${say("keys-note")}</p>
      <p class="sub"><a href="docs/" hreflang="en" target="_blank">${documentation}</a></p>
    </div>`;
  }
}
