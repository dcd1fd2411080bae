import type { Extent, Rectangle } from "./geometry.ts";

/** Side of a square that keeps the stalls whose middle lies in it, metres. */
export const SQUARE_M = 32;
/** Half the diagonal of the largest stall that is drawn whole, metres. */
export const REACH_M = 6;

/** What is indexed: a rectangle with an id. */
export interface Indexed<Id> extends Rectangle {
  id: Id;
}

/** Stalls of one square of the ground. */
export class StallSquare<Id, Stall extends Indexed<Id>> {
  readonly stalls = new Map<Id, Stall>();
  /** All that may be drawn of them: the square and a rim around it. */
  readonly extent: Extent;
  /** Counts the changes. */
  version = 0;

  constructor(column: number, row: number) {
    const [west, south] = [column * SQUARE_M, row * SQUARE_M];
    this.extent = [west - REACH_M, south - REACH_M, west + SQUARE_M + REACH_M, south + SQUARE_M + REACH_M];
  }
}

/** Stalls by where they are. `sameState`: whether two of the same shape look alike. */
export class StallIndex<Id, Stall extends Indexed<Id>> {
  private readonly squares = new Map<string, StallSquare<Id, Stall>>();
  private readonly homes = new Map<Id, StallSquare<Id, Stall>>();
  private readonly sameState: (one: Stall, other: Stall) => boolean;

  constructor(sameState: (one: Stall, other: Stall) => boolean) {
    this.sameState = sameState;
  }

  clear(): void {
    this.squares.clear();
    this.homes.clear();
  }

  /** Puts or changes a stall. Returns whether anything changed that is drawn. */
  put(stall: Stall): boolean {
    const home = this.homes.get(stall.id);
    const before = home?.stalls.get(stall.id);
    if (before && sameShape(before, stall) && this.sameState(before, stall)) {
      home?.stalls.set(stall.id, stall);
      return false;
    }
    this.remove(stall.id);
    const square = this.square(stall.east, stall.north);
    square.stalls.set(stall.id, stall);
    square.version += 1;
    this.homes.set(stall.id, square);
    return true;
  }

  remove(id: Id): boolean {
    const home = this.homes.get(id);
    if (!home) return false;
    home.stalls.delete(id);
    home.version += 1;
    this.homes.delete(id);
    return true;
  }

  /** The squares of which something may be in an extent. */
  within([west, south, east, north]: Extent): StallSquare<Id, Stall>[] {
    return [...this.squares.values()].filter(
      ({ extent, stalls }) => stalls.size > 0 && extent[0] < east && extent[2] > west && extent[1] < north && extent[3] > south,
    );
  }

  /** The stall at a place, or so near to it (metres); of several the one whose middle is nearest. */
  at(north: number, east: number, tolerance: number): Stall | null {
    const reach = REACH_M + tolerance;
    const near = this.within([east - reach, north - reach, east + reach, north + reach]).flatMap((square) => [...square.stalls.values()]);
    const apart = (stall: Stall): number => Math.hypot(stall.north - north, stall.east - east);
    const hit = near.filter((stall) => isIn(stall, north, east, tolerance)).sort((one, other) => apart(one) - apart(other));
    return hit[0] ?? null;
  }

  private square(east: number, north: number): StallSquare<Id, Stall> {
    const [column, row] = [Math.floor(east / SQUARE_M), Math.floor(north / SQUARE_M)];
    const name = `${column}/${row}`;
    const found = this.squares.get(name) ?? new StallSquare<Id, Stall>(column, row);
    this.squares.set(name, found);
    return found;
  }
}

/** Whether a place lies in a stall, or so near to it (metres). */
export function isIn({ north, east, angle, width, length }: Rectangle, atNorth: number, atEast: number, tolerance: number): boolean {
  const [up, right] = [atNorth - north, atEast - east];
  const along = Math.abs(right * Math.sin(angle) + up * Math.cos(angle));
  const across = Math.abs(right * Math.cos(angle) - up * Math.sin(angle));
  return along <= length / 2 + tolerance && across <= width / 2 + tolerance;
}

function sameShape(one: Rectangle, other: Rectangle): boolean {
  return (
    one.north === other.north &&
    one.east === other.east &&
    one.angle === other.angle &&
    one.width === other.width &&
    one.length === other.length
  );
}
