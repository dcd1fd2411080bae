import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { KEYS, OTHER_KEYS } from "../words/keys.ts";
import { Part } from "./element.ts";

/** The keys that the page knows. */
@customElement("hawk-keys")
export class KeysList extends Part {
  override render(): TemplateResult {
    const version = this.model.view().welcome?.Version;
    const rows = [...KEYS.map(({ key, label }) => [key.toUpperCase(), label]), ...OTHER_KEYS];
    return html`<div class="scroll keylist" tabindex="0" role="region" aria-label="All keys">
      <h2>Keys</h2>
      <dl>
        ${rows.map(([key, label]) => html`<div><dt><kbd>${key}</kbd></dt><dd>${label}</dd></div>`)}
      </dl>
      <p class="sub">Off while you type.</p>
      <p class="sub">
        <a href="docs/" target="_blank">Documentation</a>${version ? ` of Parking Lot Hawk ${version}` : nothing}
      </p>
    </div>`;
  }
}
