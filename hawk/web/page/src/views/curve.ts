import { html, LitElement, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, query } from "lit/decorators.js";
import uPlot from "uplot";
import type { Estimate } from "../api.ts";
import { FONT_FAMILY } from "../font.ts";
import { number, say } from "../words/say.ts";
import { moment } from "./figures.ts";

const HEIGHT = 220;
const FONT = `12px ${FONT_FAMILY}`;

/** Shares at hours of the day, or over time, each with its interval. Nothing is drawn between them: nobody flew there. */
@customElement("archive-curve")
export class Curve extends LitElement {
  /** Hours of the day, or Unix seconds. */
  @property({ attribute: false }) at: number[] = [];
  @property({ attribute: false }) shares: Estimate[] = [];
  @property() label = "";
  @property({ type: Boolean }) isTime = false;
  /** Time zone of what is shown over time. */
  @property() zone = "UTC";
  @query(".curve") private holder!: HTMLDivElement;
  private plot: uPlot | null = null;
  private readonly sizes = new ResizeObserver(() => this.plot?.setSize(this.size()));

  protected override createRenderRoot(): HTMLElement {
    return this;
  }

  override render(): TemplateResult {
    return html`<div class="curve" role="img" aria-label=${this.label}></div>`;
  }

  override updated(_changed: PropertyValues<this>): void {
    if (!this.isConnected) return;
    this.unmake();
    this.make();
  }

  override connectedCallback(): void {
    super.connectedCallback();
    this.requestUpdate();
  }

  override disconnectedCallback(): void {
    this.unmake();
    super.disconnectedCallback();
  }

  private unmake(): void {
    this.sizes.disconnect();
    this.plot?.destroy();
    this.plot = null;
  }

  private size(): { width: number; height: number } {
    return { width: Math.max(240, this.holder.clientWidth), height: HEIGHT };
  }

  private make(): void {
    const style = getComputedStyle(this);
    const colour = (name: string): string => style.getPropertyValue(name).trim();
    const axis = { stroke: colour("--text2"), font: FONT, ticks: { show: false } };
    const percent = this.shares.map(({ value }) => (value === null ? null : 100 * value));
    const ink = colour("--focus");
    this.plot = new uPlot(
      {
        ...this.size(),
        cursor: { show: false },
        legend: { show: false },
        scales: { x: { time: this.isTime, ...(this.isTime ? {} : { range: [0, 23] }) }, y: { range: [0, 100] } },
        axes: [
          { ...axis, grid: { show: false }, values: (_plot, splits) => (this.isTime ? times(splits, this.zone) : splits.map((hour) => (Number.isInteger(hour) ? `${hour}:00` : ""))) },
          { ...axis, grid: { stroke: colour("--line"), width: 1 }, size: 56, values: (_plot, splits) => splits.map((value) => say("percent", { value: number(value) })) },
        ],
        series: [{}, { stroke: ink, paths: () => null, points: { show: true, size: 7, fill: ink } }],
        hooks: { draw: [(plot) => whiskers(plot, this.at, this.shares, ink)] },
        padding: [12, 16, 0, 0],
      },
      [this.at, percent],
      this.holder,
    );
    this.sizes.observe(this.holder);
  }
}

/** A line from end to end of each interval. */
function whiskers(plot: uPlot, at: readonly number[], shares: readonly Estimate[], colour: string): void {
  const { ctx } = plot;
  ctx.save();
  ctx.strokeStyle = colour;
  ctx.lineWidth = 1.5 * devicePixelRatio;
  ctx.beginPath();
  shares.forEach(({ low, high }, k) => {
    if (low === null || high === null) return;
    const x = plot.valToPos(at[k] ?? 0, "x", true);
    ctx.moveTo(x, plot.valToPos(100 * low, "y", true));
    ctx.lineTo(x, plot.valToPos(100 * high, "y", true));
  });
  ctx.stroke();
  ctx.restore();
}

/** Times of an axis: hours with the day below where it is another one, or days alone. */
function times(splits: readonly number[], zone: string): string[] {
  const isDays = (splits[1] ?? 0) - (splits[0] ?? 0) >= 86_400;
  let before = "";
  return splits.map((seconds) => {
    const text = moment(new Date(1000 * seconds).toISOString(), zone);
    const day = text.slice(5, 10);
    const hour = text.slice(11);
    if (isDays) return day;
    const isOther = day !== before;
    before = day;
    return isOther ? `${hour}\n${day}` : hour;
  });
}
