import { html, LitElement, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { say } from "../words/say.ts";
import { icon } from "./icons.ts";
import { isPressKey, Press } from "./press.ts";

/** Share of the track from which the slide is complete. */
const ENOUGH = 0.92;
const KEY_MS = 1000;

/** Slide to confirm; by keyboard Enter kept pressed for a second. Fires "confirmed". */
@customElement("hawk-slide")
export class Slide extends LitElement {
  @property() text = "";
  @property({ type: Boolean }) disabled = false;
  @query(".slide") private track!: HTMLButtonElement;
  @query(".thumb") private thumb!: HTMLElement;
  @state() private missed = false;
  private from: number | null = null;
  private readonly press = new Press(KEY_MS, {
    progress: (share) => this.place(share),
    done: () => this.confirm(),
    missed: () => (this.missed = true),
  });

  protected override createRenderRoot(): HTMLElement {
    return this;
  }

  override render(): TemplateResult {
    return html`<button
      class="slide"
      ?disabled=${this.disabled}
      aria-describedby="slide-help"
      @pointerdown=${this.begin}
      @pointermove=${this.move}
      @pointerup=${this.end}
      @pointercancel=${this.end}
      @keydown=${(event: KeyboardEvent) => {
        if (!isPressKey(event) || this.disabled) return;
        event.preventDefault();
        if (event.repeat) return;
        this.missed = false;
        this.press.begin(event);
      }}
      @keyup=${(event: KeyboardEvent) => this.press.release(event)}
      @blur=${() => this.press.end()}
    >
      <span class="fill"></span><span class="thumb">${icon("right")}</span><span class="word">${this.missed ? say("slide-missed") : this.text}</span>
      <span id="slide-help" hidden>${say("slide-help")}</span>
    </button>`;
  }

  override updated(changed: PropertyValues<this>): void {
    if (changed.has("disabled") && this.disabled) this.leave();
  }

  override disconnectedCallback(): void {
    this.leave();
    super.disconnectedCallback();
  }

  /** Ends what is under way: what it would confirm is gone. */
  private leave(): void {
    this.press.end();
    if (this.from === null) return;
    this.from = null;
    this.track.classList.remove("held");
    this.place(0);
  }

  private readonly begin = (event: PointerEvent): void => {
    if (this.disabled || event.button !== 0) return;
    this.track.setPointerCapture(event.pointerId);
    this.track.classList.add("held");
    this.missed = false;
    this.from = event.clientX;
  };

  private readonly move = (event: PointerEvent): void => {
    if (this.from !== null) this.place((event.clientX - this.from) / this.travel());
  };

  private readonly end = (event: PointerEvent): void => {
    if (this.from === null) return;
    const share = (event.clientX - this.from) / this.travel();
    this.from = null;
    this.track.classList.remove("held");
    this.place(0);
    if (event.type === "pointerup" && share >= ENOUGH) this.confirm();
  };

  private travel(): number {
    return Math.max(1, this.track.clientWidth - this.thumb.offsetWidth - 8);
  }

  private place(share: number): void {
    const limited = Math.min(1, Math.max(0, share));
    this.track.style.setProperty("--travel", `${limited * this.travel()}px`);
  }

  private confirm(): void {
    if (!this.disabled) this.dispatchEvent(new Event("confirmed"));
  }
}
