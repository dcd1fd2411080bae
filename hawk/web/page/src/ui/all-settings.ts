import { html, nothing, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import { fetchSettings, type Setting } from "../link/settings.ts";
import { say } from "../words/say.ts";
import { settingGroups, type SettingWords } from "../words/settings.ts";
import { Part } from "./element.ts";
import { drone } from "./quoting.ts";

/** All settings that the drone's program runs with, to read: a file on the drone sets them before it starts. */
@customElement("hawk-all-settings")
export class AllSettings extends Part {
  @state() private settings: Setting[] | null = null;
  @state() private search = "";
  @state() private failed = false;
  private asking = false;

  override render(): TemplateResult {
    return html`<details class="all-settings" @toggle=${this.opened}>
      <summary>${say("all-settings")}</summary>
      ${this.settings === null ? this.waiting() : this.list(this.settings)}
    </details>`;
  }

  private waiting(): TemplateResult {
    return html`<p class="sub" role="status">${this.failed ? say("settings-unanswered") : say("settings-asking")}</p>`;
  }

  private list(settings: Setting[]): TemplateResult {
    const groups = settingGroups(settings, this.search);
    return html`<p class="sub">${say("settings-note")}</p>
      <input
        type="search"
        placeholder=${say("search-settings")}
        aria-label=${say("search-settings")}
        .value=${this.search}
        @input=${(event: Event) => (this.search = (event.target as HTMLInputElement).value)}
      />
      ${groups.length === 0 ? html`<p class="sub">${say("no-setting-like-this")}</p>` : nothing}
      ${groups.map(([section, words]) => html`<h3>${drone(section)}</h3><dl>${words.map(row)}</dl>`)}`;
  }

  private readonly opened = (event: Event): void => {
    if (!(event.target as HTMLDetailsElement).open || this.settings !== null || this.asking) return;
    this.asking = true;
    this.failed = false;
    void fetchSettings().then((settings) => {
      this.asking = false;
      this.settings = settings;
      this.failed = settings === null;
    });
  };
}

function row(words: SettingWords): TemplateResult {
  return html`<div>
    <dt>${drone(words.name)}</dt>
    <dd>
      <b>${words.value}${words.changed ? html` <span class="changed">${say("setting-changed")}</span>` : nothing}</b>
      ${words.bounds === "" ? nothing : html`<span class="sub">${words.bounds}</span>`}
      <span class="sub">${drone(words.text)}</span>
    </dd>
  </div>`;
}
