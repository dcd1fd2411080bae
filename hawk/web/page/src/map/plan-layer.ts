import Layer from "ol/layer/Layer.js";
import type { FrameState } from "ol/Map.js";
import { type Area, drawArea, drawAreaName, drawPlan, drawPlanWords, drawSeen, drawSketch, NO_SKETCH, type PlanShape, type Sketch } from "./draw-plan.ts";
import { drawRows, type RowMark, rowMarks } from "./draw-labels.ts";
import { type Coordinate, type Extent, type Rectangle } from "./geometry.ts";
import type { Palette } from "./palette.ts";
import { SquarePictures } from "./square-pictures.ts";
import { StallIndex } from "./stall-index.ts";
import { WideCanvas } from "./wide-canvas.ts";

/** A plan on the map: its stalls, areas, and what vision saw besides; over them what is being drawn. */
export class PlanLayer extends Layer {
  palette: Palette;
  private readonly index = new StallIndex<string, PlanShape>(
    (one, other) => one.chosen === other.chosen && one.confirmed === other.confirmed && one.named === other.named && one.kind === other.kind && one.label === other.label,
  );
  private readonly pictures = new SquarePictures(this.index, (context, stalls, frame) => drawPlan(context, stalls, frame, this.palette));
  private areas: readonly Area[] = [];
  private seen: readonly Rectangle[] = [];
  private sketch = NO_SKETCH;
  /** Letters of the rows; null: stalls have changed since. */
  private rows: readonly RowMark[] | null = null;
  private readonly holder = document.createElement("div");
  private readonly wide = new WideCanvas("plan", (context, sight, frame) => {
    drawSeen(context, this.seen, sight, this.palette);
    for (const area of this.areas) drawArea(context, area, sight, this.palette);
    for (const { stalls } of this.pictures.paint(context, sight, frame)) drawPlanWords(context, stalls.values(), sight, this.palette);
    for (const area of this.areas) drawAreaName(context, area, sight, this.palette);
    this.rows ??= rowMarks(this.within([-Infinity, -Infinity, Infinity, Infinity]));
    drawRows(context, this.rows, sight);
  });
  private readonly over = new WideCanvas("plan", (context, sight) => drawSketch(context, this.sketch, sight, this.palette));

  constructor(palette: Palette) {
    super({});
    this.palette = palette;
    this.holder.append(this.wide.holder, this.over.holder);
  }

  clear(): void {
    this.index.clear();
    this.pictures.clear();
    this.touch();
  }

  put(stalls: Iterable<PlanShape>): void {
    let changed = false;
    for (const stall of stalls) changed = this.index.put(stall) || changed;
    if (changed) this.touch();
  }

  remove(ids: Iterable<string>): void {
    let changed = false;
    for (const id of ids) changed = this.index.remove(id) || changed;
    if (changed) this.touch();
  }

  showAreas(areas: readonly Area[], seen: readonly Rectangle[]): void {
    this.areas = areas;
    this.seen = seen;
    this.touch();
  }

  draw(sketch: Sketch): void {
    if (sketch === this.sketch) return;
    this.sketch = sketch;
    this.over.touch();
    this.changed();
  }

  /** The stall at a place, or so near to it (metres). */
  at([east, north]: Coordinate, tolerance: number): PlanShape | null {
    return this.index.at(north, east, tolerance);
  }

  /** Stalls of which something may be in an extent. */
  within(extent: Extent): PlanShape[] {
    return this.index.within(extent).flatMap((square) => [...square.stalls.values()]);
  }

  /** Stalls whose middle is in a ring. */
  inRing(ring: readonly Coordinate[], extent: Extent): PlanShape[] {
    return this.within(extent).filter(({ east, north }) => isInside(ring, [east, north]));
  }

  recolour(palette: Palette): void {
    this.palette = palette;
    this.pictures.clear();
    this.over.touch();
    this.touch();
  }

  override render(frame: FrameState | null): HTMLElement {
    if (frame) {
      this.wide.show(frame);
      this.over.show(frame);
    }
    return this.holder;
  }

  private touch(): void {
    this.rows = null;
    this.wide.touch();
    this.changed();
  }
}

/** Whether a place is in a ring, by how often a line to the east crosses it. */
export function isInside(ring: readonly Coordinate[], [east, north]: Coordinate): boolean {
  let inside = false;
  ring.forEach(([here, low], index) => {
    const [there, high] = ring[(index + 1) % ring.length] ?? [here, low];
    if (low > north !== high > north && east < here + ((north - low) * (there - here)) / (high - low)) inside = !inside;
  });
  return inside;
}

