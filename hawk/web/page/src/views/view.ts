import { html, LitElement, type TemplateResult } from "lit";
import { property } from "lit/decorators.js";
import { Refused } from "../link/api.ts";
import { say } from "../words/say.ts";
import type { LotSource } from "./link.ts";
import type { Place } from "../route/place.ts";

/** A part of the page that shows something of one lot. It draws into the page itself: one style sheet for all. */
export class View extends LitElement {
  @property({ attribute: false }) source!: LotSource;
  @property({ attribute: false }) place!: Place;
  /** Rises when something was changed: what was read is read again. */
  @property({ type: Number }) revision = 0;
  @property({ type: Boolean }) mayChange = false;

  protected override createRenderRoot(): HTMLElement {
    return this;
  }

  /** Goes to a place on the page that differs from this one. */
  protected go(change: Partial<Place>): void {
    this.dispatchEvent(new CustomEvent("archive-go", { detail: change, bubbles: true }));
  }

  /** Lets the page say something, with an undo where there is one. */
  protected said(text: string, undo?: () => Promise<unknown>): void {
    this.dispatchEvent(new CustomEvent("archive-said", { detail: { text, undo }, bubbles: true }));
  }

  /** Lets every part read again. */
  protected changed(): void {
    this.dispatchEvent(new CustomEvent("archive-changed", { bubbles: true }));
  }
}

/** A question without an answer is asked again after so long. */
const AGAIN_MS = 5000;

/** An answer of the drone that a part shows: asked for again when its key is another one. */
export class Asked<T> {
  value: T | null = null;
  problem = "";
  /** The answer is still to come: what is here is that to an earlier question, or none. */
  waiting = false;
  private key: string | null = null;
  private lot = "";
  private refused: Refused | null = null;
  private readonly host: LitElement;

  constructor(host: LitElement) {
    this.host = host;
  }

  /** Asks when the key is a new one. The answer that was shown stays until another one is there, unless it is about another lot. */
  ask(key: string, work: () => Promise<T>, lot = ""): void {
    if (key === this.key) return;
    if (this.key !== null) this.problem = ""; // it was that of another question
    if (lot !== this.lot) this.value = null;
    this.lot = lot;
    this.key = key;
    this.waiting = true;
    void work().then(
      (value) => this.took(key, value, null),
      (error: unknown) => this.took(key, null, error),
    );
  }

  /** What the drone refused: a field of the address; "" where none is. */
  get field(): string {
    return this.refused?.field ?? "";
  }

  private took(key: string, value: T | null, error: unknown): void {
    if (key !== this.key) return; // another one was asked for meanwhile
    this.waiting = false;
    this.value = value;
    this.refused = error instanceof Refused ? error : null;
    this.problem = error === null ? "" : wordsOf(error);
    if (this.refused?.isEndedLink === true) this.host.dispatchEvent(new CustomEvent("archive-ended", { detail: this.problem, bubbles: true }));
    if (this.refused?.isForNow === true) this.askAgain(key);
    this.host.requestUpdate();
  }

  /** Without an answer the same is asked again by and by: nobody has to load the page again. */
  private askAgain(key: string): void {
    setTimeout(() => {
      if (key !== this.key) return;
      this.key = null;
      if (this.host.isConnected) this.host.requestUpdate();
    }, AGAIN_MS);
  }
}

export function wordsOf(error: unknown): string {
  if (!(error instanceof Refused) || error.status === 0) return say("archive-unanswered");
  if (/^(row|zone|kind|section)$/.test(error.field)) return say("ask-part-gone");
  return /^(<|$)/.test(error.message) ? say("archive-refused", { status: error.status }) : error.message;
}

/** A button that asks before it acts. The harmless answer comes to stand under the finger: a double click does nothing. */
export function asking(isAsked: boolean, words: { ask: string; sure: string; label?: string; sureLabel?: string }, ask: (isAsked: boolean) => void, act: () => void): TemplateResult {
  const first = isAsked ? say("keep-it") : words.ask;
  return html`<button class="small" aria-label=${isAsked ? first : (words.label ?? words.ask)} @click=${() => ask(!isAsked)}>${first}</button>${isAsked ? html` <button class="small danger" aria-label=${words.sureLabel ?? words.sure} @click=${act}>${words.sure}</button>` : ""}`;
}
