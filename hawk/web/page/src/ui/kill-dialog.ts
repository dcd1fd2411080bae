import { html, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import * as format from "../words/format.ts";
import { Part } from "./element.ts";
import { icon } from "./icons.ts";
import { isPressKey, Press } from "./press.ts";

const KEPT_MS = 1000;

/** Second step of cutting the motors: keep pressed for a second. Leaves the bar free: Hold and Land stay in reach. */
@customElement("hawk-kill")
export class KillDialog extends Part {
  private wasOpen = false;
  private readonly press = new Press(
    KEPT_MS,
    (share) => this.querySelector<HTMLElement>(".red")?.style.setProperty("--progress", `${share * 100}%`),
    () => void this.model.finishCut(),
  );

  override render(): TemplateResult | typeof nothing {
    const cutting = this.model.cutting;
    if (!cutting) return nothing;
    return html`<div class="scrim" @click=${() => this.cancel()}></div>
      <div
        class="kill"
        role="dialog"
        aria-label="Cut motors?"
        @keydown=${(event: KeyboardEvent) => event.key === "Escape" && this.cancel()}
      >
        <h2>${icon("warn")}Cut motors?</h2>
        <p>${this.consequence()}</p>
        <p class="sub">To stop it safely use Hold or Land.</p>
        ${cutting.problem === "" ? nothing : html`<p class="problem" role="alert">${cutting.problem}</p>`}
        <div class="row">
          <button class="cancel" @click=${() => this.cancel()}>Cancel</button>
          ${this.button(cutting.step === "ready")}
        </div>
      </div>`;
  }

  override updated(_changed: PropertyValues): void {
    const open = this.model.cutting !== null;
    if (open && !this.wasOpen) this.querySelector<HTMLElement>(".kill .cancel")?.focus();
    if (!open && this.press.running) this.press.end();
    this.wasOpen = open;
  }

  private button(ready: boolean): TemplateResult {
    return html`<button
      class="red"
      ?disabled=${!ready}
      @pointerdown=${(event: PointerEvent) => event.button === 0 && this.press.begin()}
      @pointerup=${() => this.press.release()}
      @pointerleave=${() => this.press.end()}
      @pointercancel=${() => this.press.end()}
      @contextmenu=${(event: Event) => event.preventDefault()}
      @keydown=${(event: KeyboardEvent) => {
        if (!isPressKey(event)) return;
        event.preventDefault();
        this.press.begin();
      }}
      @keyup=${() => this.press.release()}
      @blur=${() => this.press.end()}
    >
      Keep pressed 1 s to cut
    </button>`;
  }

  private consequence(): string {
    const metres = this.model.view().heartbeat?.["Relative Altitude"] ?? null;
    const from = metres === null ? "" : ` from ${format.height(metres)}`;
    return `The drone falls${from} at once. Only if it is about to hurt someone.`;
  }

  private cancel(): void {
    this.press.end();
    this.model.endCut();
  }
}
