import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { icon } from "../ui/icons.ts";
import { say } from "../words/say.ts";

/** A word of a sentence that a person chooses: a button, and what it opens. It closes by Escape, and by a press beside it. */
@customElement("archive-picker")
export class Picker extends LitElement {
  /** The word that is chosen. */
  @property() word = "";
  /** What is chosen here, for a screen reader. */
  @property() label = "";
  /** Draws what is chosen from; asked for when it is open. */
  @property({ attribute: false }) choices: () => TemplateResult = () => html``;
  @state() private isOpen = false;

  protected override createRenderRoot(): HTMLElement {
    return this;
  }

  override connectedCallback(): void {
    super.connectedCallback();
    document.addEventListener("pointerdown", this.beside);
  }

  override disconnectedCallback(): void {
    document.removeEventListener("pointerdown", this.beside);
    super.disconnectedCallback();
  }

  override render(): TemplateResult {
    return html`<span class="picker" @keydown=${(event: KeyboardEvent) => this.key(event)} @focusout=${(event: FocusEvent) => this.left(event)}>
      <button class="word" aria-haspopup="dialog" aria-expanded=${this.isOpen} aria-label=${`${this.label}: ${this.word}`} @click=${() => (this.isOpen = !this.isOpen)}>${this.word}${icon("down")}</button>
      ${this.isOpen ? html`<span class="picks" role="dialog" aria-label=${this.label}>${this.choices()}<button class="done" @click=${() => this.close()}>${say("ask-done")}</button></span>` : nothing}
    </span>`;
  }

  private readonly beside = (event: PointerEvent): void => {
    if (this.isOpen && !event.composedPath().includes(this)) this.isOpen = false;
  };

  private key(event: KeyboardEvent): void {
    if (event.key !== "Escape" || !this.isOpen) return;
    event.stopPropagation();
    this.close();
  }

  private left({ relatedTarget }: FocusEvent): void {
    if (relatedTarget instanceof Node && !this.contains(relatedTarget)) this.isOpen = false;
  }

  private close(): void {
    this.isOpen = false;
    this.querySelector<HTMLElement>(".word")?.focus();
  }
}
