import { html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { control, isViewer } from "../words/actions.ts";
import { type GlanceValue, glanceValues, stateWords } from "../words/glance.ts";
import { isFlying } from "../state/flight.ts";
import { say } from "../words/say.ts";
import { linkOf, type View } from "../words/view.ts";
import { Part } from "./element.ts";
import { icon } from "./icons.ts";
import { noted } from "./quoting.ts";

/** The line that is read at a glance: state, free stalls, battery, height, link; at its end Cut motors. */
@customElement("hawk-glance")
export class GlanceLine extends Part {
  override render(): TemplateResult {
    const view = this.model.view();
    const words = stateWords(view);
    return html`<section class="glance" aria-label=${say("at-a-glance")}>
      <div class="cell state">
        <i class="mark ${words.tone}"></i>
        <div>
          <b role="status">${words.title}</b>
          <span class="sub wide" title=${words.detail}>${noted(view, words.detail)}</span><span class="sub narrow">${noted(view, words.short)}</span>
        </div>
      </div>
      <div class="strip">${glanceValues(view).map(cell)}</div>
      <span class="grow"></span>
      <div class="right">
        ${view.welcome?.Simulation ? html`<span class="simtag">${say("simulation-mark")}</span>` : ""} ${this.chip(view)}
        <button class="plain menu" aria-label=${say("menu")} @click=${() => this.open("menu")}>${icon("menu")}</button>
        ${isViewer(view) ? nothing : this.cutButton(view)}
      </div>
    </section>`;
  }

  private chip(view: View): TemplateResult {
    const whose = control(view);
    const text = whose === "unknown" ? keptText(view) : say(CHIP[whose]);
    return html`<button class="who ${whose}" aria-label=${text} @click=${() => this.open("settings")}>
      ${icon("person")}<span class="t">${text}</span>
    </button>`;
  }

  private cutButton(view: View): TemplateResult {
    const reason = cutReason(view);
    return html`<button
      class="cut"
      ?disabled=${reason !== ""}
      aria-haspopup="dialog"
      @click=${() => void this.model.cut.begin()}
    >
      ${say("cut-motors")}${reason === "" ? "" : html` <span class="sub">${reason}</span>`}
    </button>`;
  }

  private open(what: "menu" | "settings"): void {
    this.dispatchEvent(new CustomEvent("open-panel", { detail: what, bubbles: true }));
  }
}

const CHIP = {
  mine: "you-have-control",
  free: "nobody-has-control",
  lost: "operator-lost",
  other: "someone-has-control",
} as const;

function keptText(view: View): string {
  return view.heartbeat?.["In Control"] ? say("you-had-control") : say("no-control");
}

/** Why the motors cannot be cut; nothing if they can. */
function cutReason(view: View): string {
  if (linkOf(view) === "never" || view.link !== "open") return say("no-link");
  if (control(view) === "other") return say("someone-has-control");
  return isFlying(view.heartbeat) || view.heartbeat?.Armed !== false ? "" : say("on-the-ground");
}

function cell(value: GlanceValue): TemplateResult {
  const stale = value.age !== "";
  return html`<div class="cell ${stale ? "stale" : ""}" data-value=${value.name}>
    <b>${value.value}</b>
    <span class="sub">
      ${stale ? html`<span class="age">${value.age}</span>` : ""}<span class=${value.trouble ? "age" : ""}>${stale ? value.staleLabel : value.label}</span>
    </span>
  </div>`;
}
