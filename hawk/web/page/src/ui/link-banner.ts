import { html, nothing, svg, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { type Banner, banner } from "../words/banner.ts";
import { say } from "../words/say.ts";
import { Part } from "./element.ts";
import { icon } from "./icons.ts";

/** What happened to the link, what the drone does by its settings and when, and what can be done. */
@customElement("hawk-banner")
export class LinkBanner extends Part {
  override render(): TemplateResult | typeof nothing {
    const words = banner(this.model.view());
    if (!words) return nothing;
    return html`<div class="banner ${words.tone}" role="alert">
      ${icon("warn")}
      <div>
        <div class="big">${words.title}</div>
        <div>${words.text}</div>
      </div>
      <div class="act-side">
        ${words.timeline ? timeline(words.timeline) : nothing}
        ${words.connect ? html`<button @click=${() => this.model.connect()}>${say("connect")}</button>` : nothing}
      </div>
    </div>`;
  }
}

const WIDTH = 300;

function timeline({ marks, now, countdown }: NonNullable<Banner["timeline"]>): TemplateResult {
  const last = marks.at(-1)?.at ?? 1;
  const x = (at: number): number => 6 + (Math.min(1, at / last) * (WIDTH - 12));
  const nowX = x(now);
  return html`<div class="timeline">
    <svg viewBox="0 0 ${WIDTH} 20" aria-hidden="true">
      <path class="rest" d="M6 10H${WIDTH - 6}" />
      <path class="past" d="M6 10H${nowX}" />
      ${marks.map((mark) => svg`<circle cx=${x(mark.at)} cy="10" r="5" class=${mark.at <= now ? "past" : "next"} />`)}
      <path class="now" d="M${nowX} 1v18" />
    </svg>
    <div class="legend sub">
      <span>${marks.slice(0, -1).map((mark) => mark.label).join(", ")}</span>
      <span>${marks.at(-1)?.label} <b>${countdown}</b></span>
    </div>
  </div>`;
}
