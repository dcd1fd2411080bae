import Layer from "ol/layer/Layer.js";
import type { FrameState } from "ol/Map.js";
import type { Stall } from "../state/map-store.ts";
import { drawMarks, drawStalls } from "./draw-stalls.ts";
import { type Sight, sightExtent, toPixel } from "./geometry.ts";
import { StallIndex, type StallSquare as Square } from "./stall-index.ts";
import { detailAt } from "./stall-style.ts";
import { isMoving, northUp, WideCanvas } from "./wide-canvas.ts";

type StallSquare = Square<number, Stall>;

/** A square as it was drawn. */
interface Kept {
  canvas: HTMLCanvasElement;
  resolution: number;
  ratio: number;
  version: number;
}

/** A larger picture of a square is not kept: so near there are few stalls, which are drawn one by one. Pixels a side. */
const LARGEST_PX = 1400;
/** The number of pictures that are kept at most beside those that are shown. */
const SPARE = 48;

/**
 * Stalls, drawn square by square into pictures that are kept: while the map is moved or turned no stall is drawn again,
 * and while it is zoomed the pictures are stretched until it stands still.
 */
export class StallsLayer extends Layer {
  private readonly index = new StallIndex<number, Stall>((one, other) => one.state === other.state);
  private readonly kept = new Map<StallSquare, Kept>();
  private readonly wide = new WideCanvas("stalls", (context, sight, frame) => this.paint(context, sight, frame));

  constructor() {
    super({});
  }

  clear(): void {
    this.index.clear();
    this.kept.clear();
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

  private paint(context: CanvasRenderingContext2D, sight: Sight, frame: FrameState): void {
    const ratio = frame.pixelRatio;
    const moving = isMoving(frame);
    const squares = this.index.within(sightExtent(sight));
    context.save();
    northUp(context, sight);
    for (const square of squares) this.paintSquare(context, square, sight, { ratio, moving });
    context.restore();
    if (detailAt(sight.resolution).marked) drawMarks(context, unclear(squares, sight));
    this.forget(squares);
  }

  private paintSquare(context: CanvasRenderingContext2D, square: StallSquare, sight: Sight, how: { ratio: number; moving: boolean }): void {
    const { resolution } = sight;
    const { extent, stalls } = square;
    const side = (extent[2] - extent[0]) / resolution;
    if (side * how.ratio > LARGEST_PX) {
      drawStalls(context, stalls.values(), { west: 0, north: 0, resolution, ratio: how.ratio }, detailAt(resolution));
      return;
    }
    const { canvas } = this.picture(square, resolution, how);
    context.drawImage(canvas, extent[0] / resolution, -extent[3] / resolution, side, side);
  }

  /** The picture that is kept, drawn again where it is no longer right. One that is only of another size will do while the map moves. */
  private picture(square: StallSquare, resolution: number, { ratio, moving }: { ratio: number; moving: boolean }): Kept {
    const kept = this.kept.get(square);
    if (kept?.version === square.version && kept.ratio === ratio && (kept.resolution === resolution || moving)) return kept;
    const canvas = kept?.canvas ?? document.createElement("canvas");
    const [west, , east, north] = square.extent;
    canvas.width = canvas.height = Math.ceil(((east - west) / resolution) * ratio);
    const context = canvas.getContext("2d");
    const fit = (canvas.width * resolution) / (east - west);
    context?.setTransform(fit, 0, 0, fit, 0, 0);
    if (context) drawStalls(context, square.stalls.values(), { west, north, resolution, ratio }, detailAt(resolution));
    const drawn = { canvas, resolution, ratio, version: square.version };
    this.kept.set(square, drawn);
    return drawn;
  }

  private forget(shown: readonly StallSquare[]): void {
    if (this.kept.size <= shown.length + SPARE) return;
    const needed = new Set(shown);
    for (const square of this.kept.keys()) if (!needed.has(square)) this.kept.delete(square);
  }
}

function unclear(squares: readonly StallSquare[], sight: Sight): (readonly [number, number])[] {
  const all = squares.flatMap((square) => [...square.stalls.values()]);
  return all.filter((stall) => stall.state === "unknown").map((stall) => toPixel(sight, [stall.east, stall.north]));
}
