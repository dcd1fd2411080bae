import type { Palette } from "./palette.ts";

/** A place on a canvas: right and down from its corner. */
export type Pixel = [number, number];

/** A canvas, and how places become pixels on it. */
export interface Surface {
  context: CanvasRenderingContext2D;
  palette: Palette;
  /** Metres a pixel. */
  resolution: number;
  /** Radians clockwise by which north is turned. */
  rotation: number;
  pixel: (coordinate: readonly [number, number]) => Pixel;
}

/** Begins a line over these pixels: `close` joins its last one to the first. */
export function path(context: CanvasRenderingContext2D, pixels: readonly Pixel[], close = false): void {
  context.beginPath();
  pixels.forEach(([x, y], index) => (index === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
  if (close) context.closePath();
}

/** How a path is drawn. */
export interface Line {
  colour: string;
  width: number;
  dash?: number[];
}

/** Strokes the context's present path. */
export function stroke(context: CanvasRenderingContext2D, { colour, width, dash = [] }: Line): void {
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.setLineDash(dash);
  context.stroke();
  context.setLineDash([]);
}
