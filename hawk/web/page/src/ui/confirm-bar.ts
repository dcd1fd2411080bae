import { html, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { keyed } from "lit/directives/keyed.js";
import type { Command, Point } from "../protocol.ts";
import type { Question } from "../state/question.ts";
import { cannot } from "../words/actions.ts";
import { type AskedCommand, confirmWords, overrules } from "../words/confirm.ts";
import { say, sentences } from "../words/say.ts";
import { consequence, type MoveKind, type MovePlan, planMove } from "../words/move.ts";
import { Part } from "./element.ts";
import { icon } from "./icons.ts";
import { noted } from "./quoting.ts";
import type { Slide } from "./slide.ts";
import "./slide.ts";

/** Asks before the drone moves: what would happen, what it means, and a slide. Takes the place of the guided actions. */
@customElement("hawk-confirm")
export class ConfirmBar extends Part {
  @property({ attribute: false }) question!: Question;
  @property({ attribute: false }) classAt: (place: Point) => number = () => 0;

  /** The button that asked is gone: by keyboard the slide comes next. */
  override firstUpdated(): void {
    const focus = document.activeElement;
    if (focus !== null && focus !== document.body) return;
    const slide = this.querySelector<Slide>("hawk-slide");
    void slide?.updateComplete.then(() => slide.querySelector("button")?.focus());
  }

  override render(): TemplateResult {
    const question = this.question;
    return question.about === "move" ? this.move(question) : this.simple(question.about);
  }

  private move({ target, kind: chosen, stall, height }: Extract<Question, { about: "move" }>): TemplateResult {
    const view = this.model.view();
    const route = this.model.routePlan;
    const plan = planMove(view, target, this.classAt(target), route, height);
    if (!plan) return this.frame(say("place-not-known"), say("wait-for-position"), nothing, say("move-slide"), null);
    const kind = chosen ?? plan.suggested;
    const choice = plan.choices.find((each) => each.kind === kind);
    const run = choice?.possible ? () => void this.go(target, choice.kind, height) : null;
    const second = choice?.possible ? consequence(view, plan, choice.kind, route) : (choice?.reason ?? plan.refusal);
    const asked = stall === undefined ? plan.question : say("look-again-question", { stall: this.model.map.stalls.get(stall)?.label ?? stall });
    const line = stall === undefined ? second : sentences(plan.flown, second);
    return this.frame(asked, line, this.choices(plan, kind), say("move-slide"), run);
  }

  private choices(plan: MovePlan, kind: MoveKind | null): TemplateResult {
    return html`<div class="segments choices" role="radiogroup" aria-label=${say("where-may-fly")}>
      ${plan.choices.map(
        (choice) => html`<label class=${choice.kind === kind ? "on" : ""} title=${choice.reason}>
          <input
            type="radio"
            name="kind"
            ?disabled=${!choice.possible}
            .checked=${choice.kind === kind}
            @change=${() => this.model.choose(choice.kind)}
          />${choice.label}
        </label>`,
      )}
    </div>`;
  }

  private simple(about: AskedCommand): TemplateResult {
    const view = this.model.view();
    const { question, second, slide, label } = confirmWords(view, about);
    const overruling = overrules(about);
    const reason = overruling ? "" : cannot(view, about);
    const run = (): void => {
      this.model.ask(null);
      void this.model.command(overruling ? { Type: about, Confirmed: true } : { Type: about }, label);
    };
    return this.frame(question, reason === "" ? second : `${reason}.`, nothing, slide, reason === "" ? run : null);
  }

  private frame(
    question: string,
    second: string,
    choice: TemplateResult | typeof nothing,
    slide: string,
    run: (() => void) | null,
  ): TemplateResult {
    return html`<div class="confirm" role="group" aria-label=${question}>
      <button class="cancel" aria-label=${say("cancel")} @click=${() => this.model.ask(null)}>${icon("close")}<span>${say("cancel")}</span></button>
      <div class="txt"><b>${question}</b><span class="sub">${noted(this.model.view(), second, this.model.routePlan.quoted)}</span></div>
      ${choice}
      ${keyed(this.question, html`<hawk-slide .text=${slide} ?disabled=${run === null} @confirmed=${() => run?.()}></hawk-slide>`)}
    </div>`;
  }

  private async go(target: Point, kind: MoveKind, height?: number): Promise<void> {
    this.model.ask(null);
    const place = { X: target.North, Y: target.East, Frame: "Map" } as const;
    const command: Command = kind === "Compulsive Move" && height !== undefined ? { Type: kind, ...place, Height: height } : { Type: kind, ...place };
    await this.model.command(command, say("move"));
  }
}
