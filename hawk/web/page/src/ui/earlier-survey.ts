import { html, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { earlierSurvey } from "../words/earlier.ts";
import { say } from "../words/say.ts";
import { Part } from "./element.ts";
import { icon } from "./icons.ts";

/** The choice between the survey on the map and a new one, on the ground, until it is made. */
@customElement("hawk-earlier")
export class EarlierSurvey extends Part {
  /** The survey's panel is open: there is nothing to open. */
  @property({ type: Boolean }) isShown = false;
  private kept = false;

  override render(): TemplateResult | typeof nothing {
    const view = this.model.view();
    if (view.heartbeat && view.heartbeat.State !== "Idle") this.kept = false;
    const words = earlierSurvey(view);
    if (words === null || this.kept || this.model.question !== null || this.model.drawing !== null) return nothing;
    return html`<div class="banner earlier" role="region" aria-label=${say("survey-on-map")}>
      ${icon("info")}
      <div class="words">
        <span class="big">${say("survey-on-map")}</span>
        <span>${words}</span>
      </div>
      <div class="act-side">
        ${this.isShown ? nothing : html`<button class="open-last" @click=${() => this.open()}>${say("open-last-survey")}</button>`}
        <button @click=${() => this.keep()}>${say("continue-survey")}</button>
        <button @click=${() => this.model.ask({ about: "New Survey" })}>${say("new-survey")}</button>
      </div>
    </div>`;
  }

  private open(): void {
    this.dispatchEvent(new CustomEvent("open-panel", { detail: "survey", bubbles: true }));
  }

  private keep(): void {
    this.kept = true;
    this.requestUpdate();
  }
}
