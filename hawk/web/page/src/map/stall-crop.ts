import type { Extent, Rectangle } from "./geometry.ts";

/** Around a stall this much of its surroundings is shown, metres. */
const AROUND_M = 0.8;

/** A canvas transformation: pixels from metres right (east) and down (south) of the map's origin. */
export type Matrix = readonly [a: number, b: number, c: number, d: number, e: number, f: number];

/** How a stall is shown upright, its long side up and down, in the middle of a canvas and as large as fits. */
export function upright({ north, east, angle, width, length }: Rectangle, across: number, down: number): Matrix {
  const scale = Math.min(across / (width + 2 * AROUND_M), down / (length + 2 * AROUND_M));
  const [sine, cosine] = [Math.sin(angle) * scale, Math.cos(angle) * scale];
  const [x, y] = [east, -north];
  return [cosine, -sine, sine, cosine, across / 2 - (cosine * x + sine * y), down / 2 - (-sine * x + cosine * y)];
}

/** An extent that holds all that is shown. */
export function cropExtent({ north, east, width, length }: Rectangle): Extent {
  const reach = Math.hypot(width + 2 * AROUND_M, length + 2 * AROUND_M);
  return [east - reach, north - reach, east + reach, north + reach];
}
