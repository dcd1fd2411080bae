import { html, LitElement, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, query } from "lit/decorators.js";
import type uPlot from "uplot";
import { FONT_FAMILY } from "../font.ts";
import { say } from "../words/say.ts";

export type Series = [number[], (number | null)[]];

const HEIGHT = 108;
const FONT = `12px ${FONT_FAMILY}`;

/** One curve over the last minutes. Seconds before now on the x axis. */
@customElement("hawk-plot")
export class Plot extends LitElement {
  @property({ attribute: false }) series: Series = [[], []];
  @property() label = "";
  @property({ type: Number }) top = 100;
  @property() theme = "";
  @query(".plot") private holder!: HTMLDivElement;
  private plot: uPlot | null = null;
  private readonly sizes = new ResizeObserver(() => this.fit());

  protected override createRenderRoot(): HTMLElement {
    return this;
  }

  override render(): TemplateResult {
    return html`<div class="sub">${this.label}</div>
      <div class="plot" role="img" aria-label=${this.label}></div>`;
  }

  override connectedCallback(): void {
    super.connectedCallback();
    this.requestUpdate();
  }

  /** An update that was asked for before it was disconnected still comes: the window would keep a plot made then. */
  override updated(changed: PropertyValues<this>): void {
    if (!this.isConnected) return;
    if (changed.has("theme") || changed.has("top")) this.unmake();
    if (!this.plot) void this.make();
    else this.plot.setData(this.series);
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

  /** The library is read when the first curve is shown. */
  private async make(): Promise<void> {
    const { default: UPlot } = await import("uplot");
    if (!this.isConnected || this.plot) return;
    this.sizes.observe(this.holder);
    const style = getComputedStyle(this);
    const colour = (name: string): string => style.getPropertyValue(name).trim();
    const axis = { stroke: colour("--text2"), font: FONT, ticks: { show: false } };
    this.plot = new UPlot(
      {
        width: Math.max(120, this.holder.clientWidth),
        height: HEIGHT,
        cursor: { show: false },
        legend: { show: false },
        select: { show: false, left: 0, top: 0, width: 0, height: 0 },
        scales: { x: { time: false }, y: { range: [0, this.top] } },
        axes: [
          { ...axis, grid: { show: false }, size: 24, values: (_plot, splits) => splits.map(minutes), space: 70 },
          { ...axis, grid: { stroke: colour("--line"), width: 1 }, size: 36, space: 22 },
        ],
        series: [{}, { stroke: colour("--text"), width: 2, points: { show: false } }],
        padding: [8, 16, 0, 0],
      },
      this.series,
      this.holder,
    );
  }

  private fit(): void {
    this.plot?.setSize({ width: Math.max(120, this.holder.clientWidth), height: HEIGHT });
  }
}

function minutes(seconds: number): string {
  if (seconds === 0) return say("plot-now");
  const value = -seconds / 60;
  if (Number.isInteger(value)) return say("minutes", { value: `−${value}` });
  const whole = Math.round(-seconds);
  return whole === 0 ? "" : say("seconds", { value: `−${whole}` });
}
