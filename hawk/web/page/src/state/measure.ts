import type { Point } from "../protocol.ts";

/** Places that are measured between, in order; closed: the last one leads back to the first. */
export interface Measured {
  readonly points: readonly Point[];
  readonly closed: boolean;
}

const NOTHING: Measured = { points: [], closed: false };

/** The measuring tool: a line over the map, or a ring. The drone learns nothing of it. */
export class Measure {
  open = false;
  drawn: Measured = NOTHING;
  private readonly changed: () => void;

  constructor(changed: () => void) {
    this.changed = changed;
  }

  begin(): void {
    this.open = true;
    this.changed();
  }

  /** Leaves the tool; what was measured is gone. */
  end(): void {
    if (!this.open) return;
    this.open = false;
    this.drawn = NOTHING;
    this.changed();
  }

  /** Adds a place. One within `reach` metres of the first closes the ring; after that a new line begins. */
  add(place: Point, reach: number): void {
    const { points, closed } = this.drawn;
    const [first] = points;
    if (closed) this.drawn = { points: [place], closed: false };
    else if (first && points.length >= 3 && apart(first, place) <= reach) this.drawn = { points, closed: true };
    else this.drawn = { points: [...points, place], closed: false };
    this.changed();
  }

  /** Opens a closed ring again, else takes the last place back. */
  back(): void {
    const { points, closed } = this.drawn;
    this.drawn = { points: closed ? points : points.slice(0, -1), closed: false };
    this.changed();
  }

  /** Closes the ring without pointing at its first place. */
  close(): void {
    if (this.drawn.points.length >= 3) this.drawn = { ...this.drawn, closed: true };
    this.changed();
  }
}

/** Metres along the line, or around the ring. */
export function lengthOf({ points, closed }: Measured): number {
  const ends = closed ? [...points, ...points.slice(0, 1)] : points;
  return ends.slice(1).reduce((sum, point, index) => sum + apart(ends[index] ?? point, point), 0);
}

/** Square metres inside the ring; null for a line, and for a ring whose sides cross. */
export function areaOf({ points, closed }: Measured): number | null {
  if (!closed || points.length < 3 || crossesItself(points)) return null;
  return Math.abs(points.reduce((sum, point, index) => sum + cross(points.at(index - 1) ?? point, point), 0)) / 2;
}

/** Whether two sides of a ring cross that do not meet in a corner. */
export function crossesItself(ring: readonly Point[]): boolean {
  const sides = ring.map((from, index): [Point, Point] => [from, ring[(index + 1) % ring.length] ?? from]);
  return sides.some((one, index) =>
    sides.slice(index + 2).some((other, gap) => (index > 0 || gap + index + 2 < sides.length - 1) && meet(one, other)),
  );
}

function meet([a, b]: [Point, Point], [c, d]: [Point, Point]): boolean {
  return turnOf(a, b, c) * turnOf(a, b, d) < 0 && turnOf(c, d, a) * turnOf(c, d, b) < 0;
}

/** Above 0 where the path over three places turns to one side, below 0 to the other. */
function turnOf(a: Point, b: Point, c: Point): number {
  return (b.North - a.North) * (c.East - a.East) - (b.East - a.East) * (c.North - a.North);
}

function cross(a: Point, b: Point): number {
  return a.East * b.North - b.East * a.North;
}

function apart(a: Point, b: Point): number {
  return Math.hypot(a.North - b.North, a.East - b.East);
}
