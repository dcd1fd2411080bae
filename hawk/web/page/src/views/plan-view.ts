import { html, LitElement, nothing, svg, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { type Ground, pathOf, ringPath, type Stall, stallAt } from "./ground.ts";

/** Stalls that look alike: `name` is the class of the style sheet. */
export interface Shade {
  name: string;
  stalls: readonly Stall[];
}

/** A lot's stalls from above, north up. A press on a stall chooses it. */
@customElement("archive-plan")
export class PlanView extends LitElement {
  @property({ attribute: false }) ground!: Ground;
  @property({ attribute: false }) shades: readonly Shade[] = [];
  @property() label = "";
  @property() chosen = "";
  /** What is drawn over the stalls. */
  @property({ attribute: false }) over: TemplateResult | typeof nothing = nothing;

  protected override createRenderRoot(): HTMLElement {
    return this;
  }

  override render(): TemplateResult {
    const { left, top, width, height } = this.ground.box;
    const chosen = this.ground.stalls.filter(({ id }) => id === this.chosen);
    return html`<svg class="plan" viewBox="${left} ${top} ${width} ${height}" role="img" aria-label=${this.label} @click=${(event: MouseEvent) => this.press(event)}>
      <defs><pattern id="hatch" width="1" height="1" patternUnits="userSpaceOnUse" patternTransform="rotate(45)"><rect width="0.45" height="1" class="hatch"></rect></pattern></defs>
      ${this.ground.outline.map((ring) => svg`<path class="ground" d=${ringPath(ring)}></path>`)}
      ${this.shades.map(({ name, stalls }) => svg`<path class=${name} d=${pathOf(stalls)}></path>${name === "taken" ? svg`<path class="hatched" d=${pathOf(stalls)}></path>` : nothing}`)}
      ${chosen.map((stall) => svg`<path class="chosen" d=${ringPath(stall.corners)}></path>`)}
      ${this.over} ${scaleBar(this.ground.box)}
    </svg>`;
  }

  private press(event: MouseEvent): void {
    const drawn = event.currentTarget as SVGSVGElement;
    const matrix = drawn.getScreenCTM();
    if (matrix === null) return;
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix.inverse());
    const stall = stallAt(this.ground.stalls, [at.x, at.y]);
    if (stall) this.dispatchEvent(new CustomEvent("stall", { detail: stall.id, bubbles: true }));
  }
}

/** Ten metres, and the arrow to the north. */
function scaleBar({ left, top, width, height }: Ground["box"]): TemplateResult {
  const [x, y] = [left + 1, top + height - 1];
  const size = Math.max(width, height) / 60;
  return svg`<path class="scale" d="M${x} ${y - 0.6}v0.6h10v-0.6"></path>
    <text class="scale-text" x=${x + 10 + size / 3} y=${y} font-size=${size}>10 m</text>
    <path class="scale" d="M${x + 1} ${y - 3 * size}v${-2 * size}m${-size / 3} ${size / 2}l${size / 3} ${-size / 2}l${size / 3} ${size / 2}"></path>
    <text class="scale-text" x=${x + 1 + size / 2} y=${y - 3.2 * size} font-size=${size}>N</text>`;
}

/** Stalls by their state, in the order in which they are drawn. */
export function byState(stalls: readonly Stall[]): Shade[] {
  return ["unknown", "free", "taken"].map((name) => ({ name, stalls: stalls.filter(({ state }) => state === name) }));
}
