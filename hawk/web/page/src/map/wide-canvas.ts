import type { FrameState } from "ol/Map.js";
import ViewHint from "ol/ViewHint.js";
import { type Sight, toPixel } from "./geometry.ts";

/** Around what is shown so much more is drawn, pixels: the map can be moved by it before anything is drawn again. */
const MARGIN_PX = 192;

/** What OpenLayers is about to show. */
export function sightOf({ size, viewState }: FrameState): Sight {
  const { center, resolution, rotation } = viewState;
  return { width: size[0] ?? 0, height: size[1] ?? 0, center: [center[0] ?? 0, center[1] ?? 0], resolution, rotation };
}

/** Whether the map is being moved, turned or zoomed just now. */
export function isMoving({ viewHints }: FrameState): boolean {
  return (viewHints[ViewHint.ANIMATING] ?? 0) > 0 || (viewHints[ViewHint.INTERACTING] ?? 0) > 0;
}

/** By how many pixels a picture drawn for one sight is shifted to fit another one; null where that does not do. */
export function shift(drawn: Sight, now: Sight, margin: number): readonly [number, number] | null {
  const alike = drawn.resolution === now.resolution && drawn.rotation === now.rotation && drawn.width === now.width && drawn.height === now.height;
  if (!alike) return null;
  const [x, y] = toPixel(now, drawn.center);
  const [right, down] = [x - now.width / 2, y - now.height / 2];
  return Math.abs(right) <= margin && Math.abs(down) <= margin ? [right, down] : null;
}

/** Draws over a context in pixels of the page; `sight` is what the whole canvas holds. */
export type Paint = (context: CanvasRenderingContext2D, sight: Sight, frame: FrameState) => void;

/** A canvas that is larger than the map, so that it is only shifted while the map is moved. */
export class WideCanvas {
  /** OpenLayers draws the next layer into a bare canvas below it: this one is wiped on its own, so it is not bare. */
  readonly holder = document.createElement("div");
  private readonly canvas = document.createElement("canvas");
  private readonly paint: Paint;
  private drawn: { sight: Sight; ratio: number } | null = null;
  private stale = true;
  /** It keeps what it shows: what it is to show next is not whole yet. */
  held = false;

  constructor(name: string, paint: Paint) {
    this.paint = paint;
    this.holder.className = name;
    this.holder.append(this.canvas);
  }

  /** What was drawn is no longer right. */
  touch(): void {
    this.stale = true;
  }

  show(frame: FrameState): void {
    if (this.held) return;
    const sight = sightOf(frame);
    const fits = !this.stale && this.drawn?.ratio === frame.pixelRatio ? shift(this.drawn.sight, sight, MARGIN_PX) : null;
    const [right, down] = fits ?? [0, 0];
    // At rest it lies on whole pixels again: shifted by a part of one it is a little blurred.
    if (fits && (isMoving(frame) || (right === 0 && down === 0))) {
      this.canvas.style.transform = `translate(${right}px, ${down}px)`;
      return;
    }
    this.draw(sight, frame);
  }

  private draw(sight: Sight, frame: FrameState): void {
    const context = this.canvas.getContext("2d");
    if (!context) return;
    const ratio = frame.pixelRatio;
    const whole = { ...sight, width: sight.width + 2 * MARGIN_PX, height: sight.height + 2 * MARGIN_PX };
    resize(this.canvas, whole.width, whole.height, ratio);
    this.canvas.style.left = this.canvas.style.top = `${-MARGIN_PX}px`;
    this.canvas.style.transform = "";
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, whole.width, whole.height);
    this.paint(context, whole, frame);
    this.drawn = { sight, ratio };
    this.stale = false;
  }
}

/** From here on one draws in pixels right (east) and down (south) of the map's origin, however the map is turned. */
export function northUp(context: CanvasRenderingContext2D, { width, height, center, resolution, rotation }: Sight): void {
  context.translate(width / 2, height / 2);
  context.rotate(rotation);
  context.translate(-center[0] / resolution, center[1] / resolution);
}

/** Gives a canvas the size of its place, at the screen's own resolution. */
export function resize(canvas: HTMLCanvasElement, width: number, height: number, ratio: number): void {
  const [across, down] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== across) canvas.width = across;
  if (canvas.height !== down) canvas.height = down;
  canvas.style.width = `${width}px`;
  canvas.style.height = `${height}px`;
}
