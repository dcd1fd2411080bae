import { html, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import type { LotFrame } from "../plan/frame.ts";
import { planWords } from "../words/plan.ts";
import { say } from "../words/say.ts";
import { Part } from "./element.ts";
import { icon } from "./icons.ts";
import { drone } from "./quoting.ts";
import { isTouch } from "./touch.ts";
import { LONGEST_LOT_NAME } from "./lots.ts";
import "./plan-chosen.ts";
import "./plan-drawn.ts";
import "./plan-import.ts";

/** The panel beside the map while a plan is corrected: who edits, what is chosen or drawn, and closing the edit. */
@customElement("hawk-plan")
export class PlanPanel extends Part {
  /** Where the plan lies on the map. */
  @property() placed: LotFrame["by"] = "survey";

  override render(): TemplateResult | typeof nothing {
    const { plan } = this.model;
    if (!plan.open) return nothing;
    const words = planWords(plan, this.placed, isTouch());
    const isMine = plan.own !== null || plan.isLooking;
    const isDrawn = plan.drawing.tool !== "choose" && plan.drawing.tool !== "box";
    return html`<section class="card plan" aria-label=${words.title}>
      <header>
        <div><b>${words.title}</b><span class="sub">${words.counts}</span></div>
        <button class="plain" aria-label=${say("plan-leave-aloud")} title=${say("plan-leave-aloud")} @click=${() => plan.leave()}>${icon("close")}</button>
      </header>
      <div class="state"><span class="sub" role="status">${words.state}</span>${this.askButton()}</div>
      <div role="alert">${plan.problem === "" ? nothing : html`<p class="problem">${icon("warn")}<span>${drone(plan.problem)}</span></p>`}</div>
      ${isMine && !isDrawn ? html`<hawk-plan-import .model=${this.model}></hawk-plan-import>` : nothing}
      ${isMine && !plan.incoming.file ? (isDrawn ? html`<hawk-plan-drawn .model=${this.model}></hawk-plan-drawn>` : html`<hawk-plan-chosen .model=${this.model}></hawk-plan-chosen>`) : nothing}
      ${words.hint === "" ? nothing : html`<p class="sub hint">${words.hint}</p>`}
      ${plan.own ? this.closing() : nothing}
    </section>`;
  }

  /** Another person edits, or nobody does any more. */
  private askButton(): TemplateResult | typeof nothing {
    const { plan } = this.model;
    if (plan.own || plan.isLooking || (!plan.other && plan.problem === "" && plan.answers)) return nothing;
    return html`<button @click=${() => void plan.ask(plan.other !== null)}>${say(plan.other ? "plan-take-over" : "plan-go-on")}</button>`;
  }

  private closing(): TemplateResult {
    return html`<form class="closing" @submit=${this.close}>
      <input type="text" name="why" placeholder=${say("plan-why")} aria-label=${say("plan-why")} maxlength=${LONGEST_LOT_NAME} autocomplete="off" />
      <button type="submit" class="primary" ?disabled=${!this.model.plan.mayEdit}>${say("plan-close")}</button>
    </form>`;
  }

  private readonly close = (event: Event): void => {
    event.preventDefault();
    const why = (event.currentTarget as HTMLFormElement).elements.namedItem("why") as HTMLInputElement;
    void this.model.plan.close(why.value);
  };
}
