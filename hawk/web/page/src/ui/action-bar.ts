import { html, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import type { Point } from "../protocol.ts";
import { isFlying } from "../state/flight.ts";
import { type Action, control, guidedActions, isViewer, safetyActions, viewerWords, watchingWords } from "../words/actions.ts";
import { isDone, nextStep } from "../words/next-step.ts";
import { type NextRemedy, nextRemedy, type Remedy, REMEDIES } from "../words/remedies.ts";
import { pointer, say } from "../words/say.ts";
import { linkOf, type View } from "../words/view.ts";
import { startAction } from "./start-action.ts";
import { cssVars } from "./css-vars.ts";
import { Part } from "./element.ts";
import { applyRemedy, showChecks } from "./apply-remedy.ts";
import { noted } from "./quoting.ts";
import { isTouch } from "./touch.ts";
import "./confirm-bar.ts";
import "./fence-bar.ts";
import "./outline-bar.ts";
import "./own-name.ts";

/** A finger that was moving when the button of a remedy changed means what it said before, s. */
const MOVING_S = 0.8;
/** Number of actions that have room on a narrow page. */
const KEY_ACTIONS = 3;

/** The bar: guided actions, what is being confirmed, or who has control; Land and Hold always at its outer end. */
@customElement("hawk-bar")
export class ActionBar extends Part {
  @property({ attribute: false }) classAt: (place: Point) => number = () => 0;
  /** The focus was on a button of the bar when that went or was shut. */
  private focused = false;
  /** What had the focus last, anywhere on the page. */
  private held: Element | null = null;
  /** The focus was put on Hold until there is a next step. */
  private waits = false;
  /** What the button of a remedy says, and since when, seconds of this page. */
  private offered: { command: Remedy | null; since: number } | null = null;

  override connectedCallback(): void {
    super.connectedCallback();
    document.addEventListener("focusin", this.noteFocus);
    document.addEventListener("pointerdown", this.noteFocus);
  }

  override disconnectedCallback(): void {
    document.removeEventListener("focusin", this.noteFocus);
    document.removeEventListener("pointerdown", this.noteFocus);
    super.disconnectedCallback();
  }

  /** By keyboard one step follows the other: the focus goes where the next one is. */
  override updated(_changed: PropertyValues): void {
    const focus = document.activeElement;
    const hold = this.querySelector<HTMLElement>(".hold:not(:disabled)");
    const lost = focus === null || focus === document.body || focus.matches(":disabled");
    // a strip, a remedy or a dialog that is done with takes the focus along: it must not begin at the top of the page again
    const gone = this.held !== null && (!this.held.isConnected || this.held.matches(":disabled"));
    if (!(this.focused || gone) || this.model.question || !(lost || (this.waits && focus === hold))) return;
    const next = this.querySelector<HTMLElement>(".act.primary:not(:disabled), .act.ask");
    this.waits = next === null;
    (next ?? hold)?.focus();
  }

  override render(): TemplateResult {
    const view = this.model.view();
    if (isViewer(view)) return viewing();
    const { land, hold } = safetyActions(view);
    return html`<footer class="bar" id="bar" tabindex="-1">
      ${this.first(view)}
      <div class="safety">
        ${this.safety(land, "land", this.landAllowed(view))} ${this.safety(hold, "hold", "")}
      </div>
    </footer>`;
  }

  private first(view: View): TemplateResult {
    if (this.model.fence.open) return html`<hawk-fence-bar .model=${this.model}></hawk-fence-bar>`;
    if (this.model.outline.open) return html`<hawk-outline-bar .model=${this.model}></hawk-outline-bar>`;
    const question = this.model.question;
    if (question) {
      return html`<hawk-confirm .model=${this.model} .question=${question} .classAt=${this.classAt}></hawk-confirm>`;
    }
    const whose = control(view);
    return whose === "mine" || whose === "unknown" ? this.guided(view) : this.watching(view, whose);
  }

  private guided(view: View): TemplateResult {
    const actions = guidedActions(view, isTouch());
    const remedy = nextRemedy(view);
    if (remedy === null) this.offered = null;
    const key = keyActions(view, actions);
    const next = nextStep(view, actions);
    const first = remedy === null ? 0 : 1; // the remedy stands before Arm, in the room of a return that is not due
    const shown = remedy === null ? actions : actions.filter((action) => action.name !== "home");
    return html`<div class="guided">
      <button class="act more" @click=${() => this.more()}><b>${say("more-actions")}</b></button>
      ${remedy === null ? nothing : this.remedy(remedy)}
      ${repeat(
        shown,
        (action) => action.name, // the focus must not slip from Arm to Disarm
        (action) => this.action(action, ranked(key.indexOf(action), first), stepClass(view, action, next)),
      )}
    </div>`;
  }

  /** What has to be done before Arm: one press, or a look at what no command mends. */
  private remedy({ command, checks }: NextRemedy): TemplateResult {
    if (this.offered?.command !== command) this.offered = { command, since: this.offered === null ? -Infinity : this.model.seconds() };
    const { since } = this.offered;
    const label = command === null ? say("show-checks") : say(REMEDIES[command]);
    const note = command === null ? say("remedy-by-hand", { checks }) : say("remedy-mends", { checks });
    return html`<button
      class="act possible key first primary"
      data-action="remedy"
      @click=${() => (command === null || this.model.seconds() - since < MOVING_S ? showChecks(this) : applyRemedy(this.model, command, this))}
    >
      <b>${label}</b> <span class="sub">${note}</span>
    </button>`;
  }

  /** `rank`: 0 is shown even on the narrowest page, -1 only on wide ones. */
  private action(action: Action, rank: number, step = ""): TemplateResult {
    const picking = action.name === "move" && this.model.picking;
    const words = picking ? { ...action, kind: "running" as const, note: say("move-now", { pointer: pointer(isTouch()) }) } : action;
    const rankClass = rank === 0 ? "key first" : rank > 0 ? "key" : "";
    return html`<button
      class="act ${words.kind} ${rankClass} ${step}"
      data-action=${action.name}
      ?disabled=${words.kind === "impossible" || (words.kind === "running" && action.name !== "move")}
      aria-pressed=${words.kind === "running" ? "true" : words.kind === "failed" ? nothing : "false"}
      aria-description=${words.kind === "failed" ? say("show-checks") : nothing}
      ${cssVars({ "--progress": `${Math.round((words.progress ?? 0) * 100)}%` })}
      @click=${() => (action.kind === "failed" ? showChecks(this) : startAction(this.model, action))}
    >
      <b>${words.label}</b> <span class="sub">${noted(this.model.view(), words.note)}</span>
    </button>`;
  }

  private watching(view: View, whose: "free" | "lost" | "other"): TemplateResult {
    const flying = isFlying(view.heartbeat);
    const open = whose !== "other";
    const { title, text } = watchingWords(view, whose);
    const home = guidedActions(view, isTouch()).find((action) => action.name === "home");
    return html`<div class="watching">
      <div class="txt"><b>${title}</b><span class="sub">${text}</span></div>
      <hawk-name .model=${this.model} .asks=${true}></hawk-name>
      ${open && flying && home ? this.action(home, 0) : nothing}
      <button class="act ask ${open ? "primary" : ""}" @click=${() => void this.model.takeControl()}>
        <b>${open ? say("take-control") : say("ask-for-control")}</b>
      </button>
    </div>`;
  }

  private safety(action: Action, name: "land" | "hold", forbidden: string): TemplateResult {
    const disabled = action.kind === "impossible" || forbidden !== "";
    const note = forbidden === "" || action.note === say("no-link") ? action.note : forbidden;
    return html`<button
      class=${name}
      ?disabled=${disabled}
      @click=${() => startAction(this.model, action)}
    >
      ${action.label} <span class="sub">${noted(this.model.view(), note)}</span>
    </button>`;
  }

  private landAllowed(view: View): string {
    return linkOf(view) === "live" && control(view) === "other" && isFlying(view.heartbeat) ? say("someone-has-control") : "";
  }

  private readonly noteFocus = (event: Event): void => {
    this.focused = event.target instanceof Node && this.contains(event.target);
    this.held = event.type === "focusin" && event.target instanceof Element ? event.target : null;
    if (!this.focused || !(event.target as Element).matches(".hold")) this.waits = false;
  };

  private more(): void {
    this.dispatchEvent(new CustomEvent("open-panel", { detail: "actions", bubbles: true }));
  }
}

/** The place of a key action where `before` others come first; -1 stays none. */
function ranked(rank: number, before: number): number {
  const place = rank < 0 ? -1 : rank + before;
  return place < KEY_ACTIONS ? place : -1;
}

/** The next step is the primary button; steps that are done take little room. */
function stepClass(view: View, action: Action, next: Action["name"] | null): string {
  if (action.name === next) return "primary";
  return action.kind === "impossible" && isDone(view, action.name) ? "done" : "";
}

/** The whole bar of a viewer. */
function viewing(): TemplateResult {
  const { title, text } = viewerWords();
  return html`<footer class="bar" id="bar" tabindex="-1">
    <div class="watching"><div class="txt"><b>${title}</b><span class="sub">${text}</span></div></div>
  </footer>`;
}

/** The three actions that matter now, most important first. */
function keyActions(view: View, actions: Action[]): Action[] {
  const flying = isFlying(view.heartbeat);
  const state = view.heartbeat?.State;
  const order = flying ? [4, 2, 3] : state === "Arm" ? [1, 0, 2] : [0, 1, 2];
  const manual = state === "Manual" ? [0, 4, 3] : order;
  return manual.map((index) => actions[index]).filter((action): action is Action => action !== undefined);
}
