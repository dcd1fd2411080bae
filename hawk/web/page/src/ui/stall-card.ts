import { html, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, query } from "lit/decorators.js";
import type { Stall } from "../state/map-store.ts";
import { capital, say } from "../words/say.ts";
import { likelihood, lookAgain, stallDetail } from "../words/stall.ts";
import type { View } from "../words/view.ts";
import { Part } from "./element.ts";
import { icon } from "./icons.ts";
import { noted } from "./quoting.ts";
import { swatch } from "./swatch.ts";

/** What is known of the stall that was clicked: its picture, how sure it is, and a button to look again. */
@customElement("hawk-stall")
export class StallCard extends Part {
  /** Number of the stall; null for none. */
  @property({ attribute: false }) chosen: number | null = null;
  /** Draws the stall's picture; false where there is none. */
  @property({ attribute: false }) draw: (stall: Stall, canvas: HTMLCanvasElement) => boolean = () => false;
  @query("canvas") private canvas!: HTMLCanvasElement | null;

  private get stall(): Stall | undefined {
    return this.chosen === null ? undefined : this.model.map.stalls.get(this.chosen);
  }

  override render(): TemplateResult | typeof nothing {
    const { stall } = this;
    if (!stall || this.model.question) return nothing;
    const view = this.model.view();
    const words = likelihood(stall);
    const detail = stallDetail(stall, this.lastSeenAt(stall, view));
    return html`<div class="pop stall" data-mark="stall">
      <canvas width="120" height="192" role="img" aria-label=${say("stall-picture", { stall: stall.label })}></canvas>
      <div>
        <button class="plain close" aria-label=${say("close")} @click=${() => this.close()}>${icon("close")}</button>
        <div class="h">${say("stall-number", { stall: stall.label })}</div>
        <div class="kind">${swatch(stall.state)} ${capital(words)}</div>
        <div class="sub">${detail}</div>
        ${this.again(stall, view)}
      </div>
    </div>`;
  }

  override updated(_changed: PropertyValues): void {
    const { canvas, stall } = this;
    if (canvas && stall) canvas.hidden = !this.draw(stall, canvas);
  }

  private again(stall: Stall, view: View): TemplateResult | typeof nothing {
    const reason = lookAgain(view);
    if (reason === null) return nothing;
    const ask = (): void =>
      this.model.ask({ about: "move", target: { North: stall.north, East: stall.east }, kind: "Autonomous Move", stall: stall.id });
    return html`<button ?disabled=${reason !== ""} @click=${ask}>
      <span class="two">${say("look-again")}${reason === "" ? nothing : html`<span class="sub">${noted(view, reason)}</span>`}</span>
    </button>`;
  }

  /** Time of day, milliseconds, at which a stall was last seen. */
  private lastSeenAt(stall: Stall, view: View): number | null {
    return stall.lastSeen === null ? null : this.model.daemonClock.timeOfDay(stall.lastSeen, this.model.seconds(), view.now);
  }

  private close(): void {
    this.dispatchEvent(new CustomEvent("stall-closed", { bubbles: true }));
  }
}
