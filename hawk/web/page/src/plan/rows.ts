import type { Rectangle } from "../map/geometry.ts";
import type { RowSketch, Spot } from "./values.ts";

/** As the store takes them, metres. */
export const LEAST_SIDE_M = 0.5;
export const MOST_IN_ROW = 1000;
/** Lean of the stalls of an angled row, degrees. */
export const STEEPEST_DEG = 65;

/** Length of a front, metres. */
export function frontLength([start, end]: RowSketch["front"]): number {
  return Math.hypot(end[0] - start[0], end[1] - start[1]);
}

/** How far a place lies from the line through a front, square to it, metres. */
export function depthOf(front: RowSketch["front"], far: Spot): number {
  return Math.abs(sideOf(front, far));
}

/** The same, above 0 to the right of the front. */
export function sideOf([start, end]: RowSketch["front"], far: Spot): number {
  const length = Math.hypot(end[0] - start[0], end[1] - start[1]);
  if (length === 0) return 0;
  const [up, right] = [(end[0] - start[0]) / length, (end[1] - start[1]) / length];
  return -right * (far[0] - start[0]) + up * (far[1] - start[1]);
}

/** The count whose pitch along the front is nearest to a usual one. */
export function countFor(length: number, size: { width: number; length: number }, lean: number, parallel: boolean): number {
  const pitch = parallel ? size.length : size.width / Math.cos(lean);
  return Math.min(MOST_IN_ROW, Math.max(1, Math.round(length / pitch)));
}

/**
 * The stalls of a row, as the store makes them: front corners on the front, far corners on the line through the far place,
 * and neighbours touch. Of a double row the second side is the first one turned by half a turn about the middle. None for
 * a row without room.
 */
export function rowShapes({ front, far, count, lean, double }: RowSketch): Rectangle[] {
  const [start, end] = front;
  const length = frontLength(front);
  if (length < LEAST_SIDE_M) return [];
  const along: Spot = [(end[0] - start[0]) / length, (end[1] - start[1]) / length];
  const side = sideOf(front, far);
  const across: Spot = side < 0 ? [along[1], -along[0]] : [-along[1], along[0]];
  const reach = Math.abs(side);
  const depth = double ? reach / 2 : reach;
  const pitch = length / count;
  const width = pitch * Math.cos(lean);
  const long = (depth - width * Math.abs(Math.sin(lean))) / Math.cos(lean);
  if (long < LEAST_SIDE_M) return [];
  const up = Math.cos(lean) * across[0] + Math.sin(lean) * along[0];
  const right = Math.cos(lean) * across[1] + Math.sin(lean) * along[1];
  const shape = upright(Math.atan2(right, up), width, long);
  const middles = Array.from({ length: count }, (_, index): Spot => {
    const step = (index + 0.5) * pitch + (Math.tan(lean) * depth) / 2;
    return [start[0] + step * along[0] + (depth / 2) * across[0], start[1] + step * along[1] + (depth / 2) * across[1]];
  });
  const centre: Spot = [(start[0] + end[0] + reach * across[0]) / 2, (start[1] + end[1] + reach * across[1]) / 2];
  const behind = double ? middles.map(([north, east]): Spot => [2 * centre[0] - north, 2 * centre[1] - east]).reverse() : [];
  return [...middles, ...behind].map(([north, east]) => ({ north, east, ...shape }));
}

/** The length is the longer side, the angle in [0, pi). */
function upright(angle: number, width: number, length: number): Pick<Rectangle, "angle" | "width" | "length"> {
  const isWide = width > length;
  const turned = (angle + (isWide ? Math.PI / 2 : 0)) % Math.PI;
  return { angle: turned < 0 ? turned + Math.PI : turned, width: isWide ? length : width, length: isWide ? width : length };
}
