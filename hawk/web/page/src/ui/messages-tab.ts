import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import type { LogLine } from "../state/flight.ts";
import * as format from "../words/format.ts";
import { Part } from "./element.ts";
import { icon, type IconName } from "./icons.ts";

const ICONS: Record<LogLine["level"], IconName> = { info: "info", ok: "check", warning: "warn", error: "warn" };
const SHOWN = 60;

/** What happened, newest first; the autopilot's own words behind Details. */
@customElement("hawk-messages")
export class MessagesTab extends Part {
  override render(): TemplateResult {
    const lines = this.model.flight.lines.slice(0, SHOWN);
    if (lines.length === 0) return html`<p class="empty sub">Nothing happened yet.</p>`;
    return html`<div class="scroll" role="log" aria-label="Messages" tabindex="0">
      <ul class="log">
        ${repeat(lines, (line) => line.key, row)}
      </ul>
    </div>`;
  }
}

function row(line: LogLine): TemplateResult {
  return html`<li class=${line.level}>
    <time datetime=${line.time}>${format.clock(line.time)}</time>${icon(ICONS[line.level])}
    <div>
      ${line.text}
      ${line.details === ""
        ? nothing
        : html`<details>
            <summary>Details</summary>
            <span class="sub">${line.details}</span>
          </details>`}
    </div>
  </li>`;
}
