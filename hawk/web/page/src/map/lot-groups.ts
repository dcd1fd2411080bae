import type { Coordinate } from "./geometry.ts";

/** A lot on the map of all: its place in metres east and north, and how full it is; null: nobody knows. */
export interface LotMark {
  id: string;
  name: string;
  words: () => string;
  /** Share of what is known that is taken, 0 to 1. */
  taken: number | null;
  place: Coordinate;
}

/** Lots that one pin stands for: the first one is where the pin is. */
export type LotGroup = readonly [LotMark, ...LotMark[]];

/** Pins stand so far apart, pixels: their circles do not touch. */
export const APART_PX = 24;
/** More than there are columns between two sides of the Earth: row and column make one number. */
const COLUMNS = 1e8;

/**
 * Lots whose pins would touch at a resolution, metres a pixel, as groups. The same lots make the same groups wherever the
 * map is moved to: their distances alone count.
 */
export function groupsOf(marks: readonly LotMark[], resolution: number): LotGroup[] {
  const apart = APART_PX * resolution;
  const squares = new Map<number, [LotMark, ...LotMark[]][]>();
  const groups: LotGroup[] = [];
  for (const mark of marks) {
    const [column, row] = [Math.floor(mark.place[0] / apart), Math.floor(mark.place[1] / apart)];
    const near = nearest(squares, column, row, mark.place, apart);
    if (near) {
      near.push(mark);
      continue;
    }
    const group: [LotMark, ...LotMark[]] = [mark];
    const key = column * COLUMNS + row;
    squares.set(key, [...(squares.get(key) ?? []), group]);
    groups.push(group);
  }
  return groups;
}

/** The nearest group whose pin touches one at a place; they are in the squares about it. */
function nearest(squares: ReadonlyMap<number, [LotMark, ...LotMark[]][]>, column: number, row: number, [east, north]: Coordinate, apart: number): [LotMark, ...LotMark[]] | null {
  let found: [LotMark, ...LotMark[]] | null = null;
  let least = apart;
  for (let k = 0; k < 9; k++) {
    const key = (column + (k % 3) - 1) * COLUMNS + row + Math.floor(k / 3) - 1;
    for (const group of squares.get(key) ?? []) {
      const [{ place }] = group;
      const distance = Math.hypot(place[0] - east, place[1] - north);
      if (distance < least) [found, least] = [group, distance];
    }
  }
  return found;
}
