import { html, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import type { Cutting } from "../state/motor-cut.ts";
import * as format from "../words/format.ts";
import { say } from "../words/say.ts";
import { Part } from "./element.ts";
import { icon } from "./icons.ts";
import { isPressKey, Press } from "./press.ts";
import { quoting } from "./quoting.ts";

const KEPT_MS = 1000;

/** Second step of cutting the motors: keep pressed for a second. Leaves the bar free: Hold and Land stay in reach. */
@customElement("hawk-kill")
export class KillDialog extends Part {
  @state() private missed = false;
  private wasOpen = false;
  private readonly press = new Press(KEPT_MS, {
    progress: (share) => this.querySelector<HTMLElement>(".red")?.style.setProperty("--progress", `${share * 100}%`),
    done: () => void this.model.cut.finish(),
    missed: () => (this.missed = true),
  });

  override render(): TemplateResult | typeof nothing {
    const cutting = this.model.cut.current;
    if (!cutting) return nothing;
    return html`<div class="scrim" @click=${() => this.cancel()}></div>
      <div
        class="kill"
        role="dialog"
        aria-label=${say("cut-question")}
        @keydown=${(event: KeyboardEvent) => {
          if (event.key !== "Escape") return;
          event.preventDefault();
          this.cancel();
        }}
      >
        <h2>${icon("warn")}${say("cut-question")}</h2>
        <p>${this.consequence()}</p>
        <p class="sub">${say("cut-instead")}</p>
        ${this.problem(cutting)}
        <div class="row">
          <button class="cancel" @click=${() => this.cancel()}>${say("cancel")}</button>
          ${this.button(cutting.step === "ready")}
        </div>
      </div>`;
  }

  override updated(_changed: PropertyValues): void {
    const open = this.model.cut.current !== null;
    if (open && !this.wasOpen) this.querySelector<HTMLElement>(".kill .cancel")?.focus();
    if (this.model.cut.current?.step !== "ready" && this.press.running) this.press.end();
    if (!open) this.missed = false;
    this.wasOpen = open;
  }

  override disconnectedCallback(): void {
    this.press.end();
    super.disconnectedCallback();
  }

  private problem(cutting: Cutting): TemplateResult | typeof nothing {
    const text = cutting.problem === "" && this.missed ? say("cut-missed") : cutting.problem;
    return text === "" ? nothing : html`<p class="problem" role="alert">${quoting(text, [cutting.quoted ?? ""])}</p>`;
  }

  private begin(event: Event): void {
    this.missed = false;
    this.press.begin(event);
  }

  private button(ready: boolean): TemplateResult {
    return html`<button
      class="red"
      ?disabled=${!ready}
      @pointerdown=${(event: PointerEvent) => event.button === 0 && this.begin(event)}
      @pointerup=${(event: PointerEvent) => this.press.release(event)}
      @pointerleave=${() => this.press.end()}
      @pointercancel=${() => this.press.end()}
      @contextmenu=${(event: Event) => event.preventDefault()}
      @keydown=${(event: KeyboardEvent) => {
        if (!isPressKey(event)) return;
        event.preventDefault();
        if (!event.repeat) this.begin(event);
      }}
      @keyup=${(event: KeyboardEvent) => this.press.release(event)}
      @blur=${() => this.press.end()}
    >
      ${say("cut-press")}
    </button>`;
  }

  private consequence(): string {
    const view = this.model.view();
    const metres = view.heartbeat?.["Relative Altitude"] ?? null;
    return metres === null ? say("cut-falls") : say("cut-falls-from", { height: format.height(metres, view.units) });
  }

  private cancel(): void {
    this.press.end();
    this.model.cut.end();
  }
}
