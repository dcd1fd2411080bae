import { html, nothing, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import type { LogLine } from "../state/flight.ts";
import * as format from "../words/format.ts";
import { type LogFilter, logName, logText, matching } from "../words/log-lines.ts";
import { say } from "../words/say.ts";
import { Part } from "./element.ts";
import { icon, type IconName } from "./icons.ts";
import { drone, quoting } from "./quoting.ts";
import { saveFile } from "./save-file.ts";

const ICONS: Record<LogLine["level"], IconName> = { info: "info", ok: "check", warning: "warn", error: "warn" };
/** Lines that are added at a time. */
const PAGE = 60;

/** What happened, newest first; the autopilot's own words behind Details. */
@customElement("hawk-messages")
export class MessagesTab extends Part {
  @state() private filter: LogFilter = { text: "", troubles: false };
  @state() private shown = PAGE;

  override render(): TemplateResult {
    const { lines } = this.model.flight;
    if (lines.length === 0) return html`<p class="empty sub">${say("nothing-happened")}</p>`;
    const found = matching(lines, this.filter);
    return html`${this.tools(found)}
      <div class="scroll" role="log" aria-label=${say("messages")} tabindex="0">
        ${found.length === 0 ? html`<p class="empty sub">${say("no-message-like-this")}</p>` : nothing}
        <ul class="log">
          ${repeat(found.slice(0, this.shown), (line) => line.key, row)}
        </ul>
        ${found.length > this.shown ? html`<button class="small" @click=${() => (this.shown += PAGE)}>${say("show-more")}</button>` : nothing}
      </div>`;
  }

  private tools(found: LogLine[]): TemplateResult {
    const { text, troubles } = this.filter;
    const isFiltered = text !== "" || troubles;
    return html`${isFiltered ? this.filtered(found.length) : nothing}<div class="log-tools" role="search" aria-label=${say("messages")}>
      <input
        type="search"
        placeholder=${say("search-messages")}
        aria-label=${say("search-messages")}
        .value=${text}
        @input=${(event: Event) => this.choose({ text: (event.target as HTMLInputElement).value })}
      />
      <button class=${troubles ? "small on" : "small"} aria-pressed=${troubles} @click=${() => this.choose({ troubles: !troubles })}>${icon("warn")}${say("warnings")}</button>
      <button class="small" ?disabled=${found.length === 0} @click=${() => save(found)}>${icon("download")}${say("save")}</button>
    </div>`;
  }

  /** What is left out is said, also where a low page has no room for the field that left it out. */
  private filtered(found: number): TemplateResult {
    return html`<div class="filtered"><span class="sub">${say("messages-filtered", { found, all: this.model.flight.lines.length })}</span>
      <button class="small" @click=${() => this.choose({ text: "", troubles: false })}>${say("show-all-messages")}</button>
    </div>`;
  }

  private choose(change: Partial<LogFilter>): void {
    this.filter = { ...this.filter, ...change };
    this.shown = PAGE;
  }
}

/** Saves the messages that are found, those that are not drawn too. */
function save(found: LogLine[]): void {
  saveFile(logName(found[0]?.time ?? ""), logText(found), "text/plain;charset=utf-8");
}

function row(line: LogLine): TemplateResult {
  return html`<li class=${line.level}>
    <time datetime=${line.time}>${format.clock(line.time)}</time>${icon(ICONS[line.level])}
    <div>
      ${quoting(line.text, [line.quoted ?? ""])}
      ${line.details === ""
        ? nothing
        : html`<details>
            <summary>${say("details")}</summary>
            <span class="sub">${drone(line.details)}</span>
          </details>`}
    </div>
  </li>`;
}
