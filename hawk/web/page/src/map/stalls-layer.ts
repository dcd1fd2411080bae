import Layer from "ol/layer/Layer.js";
import type { FrameState } from "ol/Map.js";
import type { Stall } from "../state/map-store.ts";
import { drawNumbers, drawRows, type RowMark } from "./draw-labels.ts";
import { drawMarks, drawStalls } from "./draw-stalls.ts";
import { type Sight, toPixel } from "./geometry.ts";
import { SquarePictures } from "./square-pictures.ts";
import { StallIndex, type StallSquare } from "./stall-index.ts";
import { detailAt } from "./stall-style.ts";
import { WideCanvas } from "./wide-canvas.ts";

/** Stalls as the drone sees them. */
export class StallsLayer extends Layer {
  private readonly index = new StallIndex<number, Stall>((one, other) => one.state === other.state && one.heat === other.heat);
  private readonly pictures = new SquarePictures(this.index, (context, stalls, frame) => drawStalls(context, stalls, frame, detailAt(frame.resolution)));
  /** Begins of rows; null: nothing is labelled. */
  private rows: readonly RowMark[] | null = null;
  private readonly wide = new WideCanvas("stalls", (context, sight, frame) => {
    const squares = this.pictures.paint(context, sight, frame);
    if (detailAt(sight.resolution).marked) drawMarks(context, unclear(squares, sight));
    if (this.rows === null) return;
    for (const { stalls } of squares) drawNumbers(context, stalls.values(), sight);
    drawRows(context, this.rows, sight);
  });

  constructor() {
    super({});
  }

  set held(held: boolean) {
    this.wide.held = held;
    if (!held) this.changed();
  }

  clear(): void {
    this.index.clear();
    this.pictures.clear();
    this.drawAgain();
  }

  label(rows: readonly RowMark[]): void {
    this.rows = rows;
    this.drawAgain();
  }

  put(stalls: Iterable<Stall>): void {
    let changed = false;
    for (const stall of stalls) changed = this.index.put(stall) || changed;
    if (changed) this.drawAgain();
  }

  remove(ids: Iterable<number>): void {
    let changed = false;
    for (const id of ids) changed = this.index.remove(id) || changed;
    if (changed) this.drawAgain();
  }

  /** The stall at a place, or so near to it (metres). */
  stallAt(north: number, east: number, tolerance: number): number | null {
    return this.index.at(north, east, tolerance)?.id ?? null;
  }

  override render(frame: FrameState | null): HTMLElement {
    if (frame) this.wide.show(frame);
    return this.wide.holder;
  }

  private drawAgain(): void {
    this.wide.touch();
    this.changed();
  }
}

function unclear(squares: readonly StallSquare<number, Stall>[], sight: Sight): (readonly [number, number])[] {
  const all = squares.flatMap((square) => [...square.stalls.values()]);
  return all.filter((stall) => stall.state === "unknown").map((stall) => toPixel(sight, [stall.east, stall.north]));
}
