import type { FrameState } from "ol/Map.js";
import { type Sight, sightExtent } from "./geometry.ts";
import type { Indexed, StallIndex, StallSquare } from "./stall-index.ts";
import { isMoving, northUp } from "./wide-canvas.ts";

/** A square as it was drawn. */
interface Kept {
  canvas: HTMLCanvasElement;
  resolution: number;
  ratio: number;
  version: number;
}

/** Where and how large stalls are drawn: pixels of the page right of `west` and below `north`. */
export interface StallFrame {
  west: number;
  north: number;
  /** Metres a pixel. */
  resolution: number;
  /** Pixels of the canvas to one of the page. */
  ratio: number;
}

export type DrawStalls<Stall> = (context: CanvasRenderingContext2D, stalls: Iterable<Stall>, frame: StallFrame) => void;

/** A larger picture of a square is not kept: so near there are few stalls, which are drawn one by one. Pixels a side. */
const LARGEST_PX = 1400;
/** The number of pictures that are kept at most beside those that are shown. */
const SPARE = 48;

/**
 * Stalls, drawn square by square into pictures that are kept: while the map is moved or turned no stall is drawn again,
 * where one changes only its square is, and while it is zoomed the pictures are stretched until it stands still. Squares
 * that come into sight are drawn all at once, without pictures: there is something to see sooner.
 */
export class SquarePictures<Id, Stall extends Indexed<Id>> {
  private readonly kept = new Map<StallSquare<Id, Stall>, Kept>();
  /** Squares that were drawn once: many never are again. */
  private known = new WeakSet<StallSquare<Id, Stall>>();
  private readonly index: StallIndex<Id, Stall>;
  private readonly draw: DrawStalls<Stall>;

  constructor(index: StallIndex<Id, Stall>, draw: DrawStalls<Stall>) {
    this.index = index;
    this.draw = draw;
  }

  /** Forgets the pictures: what stands in them is no more, or looks otherwise. */
  clear(): void {
    this.kept.clear();
    this.known = new WeakSet();
  }

  /** Draws what is shown; returns the squares of it. */
  paint(context: CanvasRenderingContext2D, sight: Sight, frame: FrameState): StallSquare<Id, Stall>[] {
    const how = { ratio: frame.pixelRatio, moving: isMoving(frame) };
    const squares = this.index.within(sightExtent(sight));
    context.save();
    northUp(context, sight);
    const fresh = squares.filter((square) => !this.known.has(square));
    if (fresh.length > 0) this.draw(context, stallsOf(fresh), { west: 0, north: 0, resolution: sight.resolution, ratio: how.ratio });
    for (const square of squares) if (this.known.has(square)) this.paintSquare(context, square, sight, how);
    for (const square of fresh) this.known.add(square);
    context.restore();
    this.forget(squares);
    return squares;
  }

  private paintSquare(context: CanvasRenderingContext2D, square: StallSquare<Id, Stall>, sight: Sight, how: { ratio: number; moving: boolean }): void {
    const { resolution } = sight;
    const { extent, stalls } = square;
    const side = (extent[2] - extent[0]) / resolution;
    if (side * how.ratio > LARGEST_PX) {
      this.draw(context, stalls.values(), { west: 0, north: 0, resolution, ratio: how.ratio });
      return;
    }
    const { canvas } = this.picture(square, resolution, how);
    context.drawImage(canvas, extent[0] / resolution, -extent[3] / resolution, side, side);
  }

  /** The picture that is kept, drawn again where it is no longer right. One that is only of another size will do while the map moves. */
  private picture(square: StallSquare<Id, Stall>, resolution: number, { ratio, moving }: { ratio: number; moving: boolean }): Kept {
    const kept = this.kept.get(square);
    if (kept?.version === square.version && kept.ratio === ratio && (kept.resolution === resolution || moving)) return kept;
    const canvas = kept?.canvas ?? document.createElement("canvas");
    const [west, , east, north] = square.extent;
    canvas.width = canvas.height = Math.ceil(((east - west) / resolution) * ratio);
    const context = canvas.getContext("2d");
    const fit = (canvas.width * resolution) / (east - west);
    context?.setTransform(fit, 0, 0, fit, 0, 0);
    if (context) this.draw(context, square.stalls.values(), { west, north, resolution, ratio });
    const drawn = { canvas, resolution, ratio, version: square.version };
    this.kept.set(square, drawn);
    return drawn;
  }

  private forget(shown: readonly StallSquare<Id, Stall>[]): void {
    if (this.kept.size <= shown.length + SPARE) return;
    const needed = new Set(shown);
    for (const square of this.kept.keys()) if (!needed.has(square)) this.kept.delete(square);
  }
}

function* stallsOf<Id, Stall extends Indexed<Id>>(squares: readonly StallSquare<Id, Stall>[]): Iterable<Stall> {
  for (const { stalls } of squares) yield* stalls.values();
}
