import type { Rectangle } from "../map/geometry.ts";
import { isIn } from "../map/stall-index.ts";
import type { Spot } from "./values.ts";

/** So near to its right place beside another stall, or to a stall that vision saw, a stall goes there, metres. */
export const STALL_REACH_M = 1.2;
/** So near to a corner or a line, a place goes there, metres. */
export const PLACE_REACH_M = 0.8;
/** A line of a row goes on so far beyond its last stall, metres. */
const LINE_GOES_ON_M = 12;
/** Fronts that differ by less from the direction of a row take that, radians. */
const ALIKE_RAD = (5 * Math.PI) / 180;
/** Stalls whose middles are nearer than this share of a width stand in one place. */
const SAME_PLACE = 0.5;

interface Size {
  width: number;
  length: number;
}

/**
 * A new stall at a place: one that vision saw there, or the next one beside a stall of a row, at the pitch of that; else of
 * the usual size, in the direction of the nearest stall.
 */
export function snapStall(place: Spot, stalls: readonly Rectangle[], found: readonly Rectangle[], usual: Size, loose = false): Rectangle {
  const free = (shape: Rectangle): boolean => !stalls.some((each) => distance(middle(each), middle(shape)) < SAME_PLACE * each.width);
  const seen = found.filter((each) => isIn(each, place[0], place[1], 0) && free(each));
  const beside = stalls.flatMap(neighbours).filter((each) => distance(middle(each), place) < STALL_REACH_M && free(each));
  const best = loose ? null : (nearest(seen, place) ?? nearest(beside, place));
  if (best) return shapeOf(best);
  const angle = nearest([...stalls, ...found], place)?.angle ?? 0;
  return { north: place[0], east: place[1], angle, ...usual };
}

/** By how much stalls that are moved go further, so that the nearest of them stands beside one that stays, or on one that vision saw. */
export function snapMove(moved: readonly Rectangle[], stalls: readonly Rectangle[], found: readonly Rectangle[], reach = PLACE_REACH_M): Spot {
  const homes = [...stalls.flatMap(neighbours), ...found];
  let best: { by: Spot; apart: number } | null = null;
  for (const shape of moved) {
    for (const home of homes) {
      const by: Spot = [home.north - shape.north, home.east - shape.east];
      const apart = Math.hypot(...by);
      if (apart < reach && (best === null || apart < best.apart)) best = { by, apart };
    }
  }
  return best?.by ?? [0, 0];
}

/** A place of a front: a corner of a stall, else a line of its row, else where it is. */
export function snapPlace(place: Spot, stalls: readonly Rectangle[], reach = PLACE_REACH_M): Spot {
  const corners = stalls.flatMap(cornersOf).filter((corner) => distance(corner, place) < reach);
  if (corners.length > 0) return corners.reduce((one, other) => (distance(one, place) <= distance(other, place) ? one : other));
  let best: { on: Spot; apart: number } | null = null;
  for (const line of stalls.flatMap(linesOf)) {
    const on = onLine(line, place);
    const apart = distance(on, place);
    if (apart < reach && Math.abs(along(line, on)) < LINE_GOES_ON_M && (best === null || apart < best.apart)) best = { on, apart };
  }
  return best?.on ?? place;
}

/** The second end of a front: in the direction of a row near by, and a whole number of its pitches long. */
export function snapEnd(start: Spot, place: Spot, stalls: readonly Rectangle[], pitch: number): Spot {
  const taken = snapPlace(place, stalls);
  if (taken !== place) return taken;
  const length = distance(start, place);
  const by = Math.atan2(place[1] - start[1], place[0] - start[0]);
  const directions = stalls.flatMap(({ angle }) => [angle, angle + Math.PI / 2]).map((angle) => turnTo(by, angle));
  const least = directions.reduce((one, other) => (Math.abs(other) < Math.abs(one) ? other : one), Infinity);
  if (Math.abs(least) > ALIKE_RAD) return place;
  const straight = length * Math.cos(least);
  const whole = Math.max(1, Math.round(straight / pitch)) * pitch;
  const long = Math.abs(whole - straight) < PLACE_REACH_M / 2 ? whole : straight;
  return [start[0] + long * Math.cos(by + least), start[1] + long * Math.sin(by + least)];
}

/** The far side of a row: on a line of another row, else as deep as stalls are. */
export function snapFar(front: readonly [Spot, Spot], place: Spot, stalls: readonly Rectangle[], depth: number): Spot {
  const [start, end] = front;
  const by = Math.atan2(end[1] - start[1], end[0] - start[0]);
  const square: Line = { at: start, by };
  const reach = distance(onLine(square, place), place);
  const taken = snapPlace(place, stalls, PLACE_REACH_M / 2);
  if (taken !== place) return taken;
  if (reach === 0 || Math.abs(reach - depth) > PLACE_REACH_M) return place;
  const foot = onLine(square, place);
  return [foot[0] + ((place[0] - foot[0]) * depth) / reach, foot[1] + ((place[1] - foot[1]) * depth) / reach];
}

/** Where the next stall of a row stands, on both sides of one. */
function neighbours(stall: Rectangle): Rectangle[] {
  const { north, east, angle, width } = stall;
  return [1, -1].map((side) => ({ ...shapeOf(stall), north: north - side * width * Math.sin(angle), east: east + side * width * Math.cos(angle) }));
}

function cornersOf({ north, east, angle, width, length }: Rectangle): Spot[] {
  const [up, right] = [Math.cos(angle), Math.sin(angle)];
  return ([[1, 1], [1, -1], [-1, -1], [-1, 1]] as const).map(([a, b]) => [
    north + (a * length * up) / 2 - (b * width * right) / 2,
    east + (a * length * right) / 2 + (b * width * up) / 2,
  ]);
}

/** A line through a place: `by` radians clockwise from north. */
interface Line {
  at: Spot;
  by: number;
}

/** The lines along both ends of a stall: a row's front and its far side. */
function linesOf({ north, east, angle, length }: Rectangle): Line[] {
  return [1, -1].map((end) => ({
    at: [north + (end * length * Math.cos(angle)) / 2, east + (end * length * Math.sin(angle)) / 2],
    by: angle + Math.PI / 2,
  }));
}

function along({ at, by }: Line, place: Spot): number {
  return (place[0] - at[0]) * Math.cos(by) + (place[1] - at[1]) * Math.sin(by);
}

function onLine(line: Line, place: Spot): Spot {
  const far = along(line, place);
  return [line.at[0] + far * Math.cos(line.by), line.at[1] + far * Math.sin(line.by)];
}

/** The smallest turn that makes a direction parallel to another one, either end first. */
function turnTo(from: number, to: number): number {
  const turn = (((to - from) % Math.PI) + Math.PI) % Math.PI;
  return turn > Math.PI / 2 ? turn - Math.PI : turn;
}

function nearest<Shape extends Rectangle>(shapes: readonly Shape[], place: Spot): Shape | null {
  let best: Shape | null = null;
  for (const each of shapes) if (!best || distance(middle(each), place) < distance(middle(best), place)) best = each;
  return best;
}

function shapeOf({ north, east, angle, width, length }: Rectangle): Rectangle {
  return { north, east, angle, width, length };
}

function middle({ north, east }: Rectangle): Spot {
  return [north, east];
}

function distance(one: Spot, other: Spot): number {
  return Math.hypot(one[0] - other[0], one[1] - other[1]);
}
