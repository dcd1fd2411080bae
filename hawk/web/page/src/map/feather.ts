/** What was seen fades in over this number of cells inside its edge, which is full of stairs. */
export const SOFT = 8;

/** One of the eight tiles around a tile: rows down and columns right. */
export type Side = readonly [down: number, right: number];

export const SIDES: readonly Side[] = [[-1, -1], [-1, 0], [-1, 1], [0, -1], [0, 1], [1, -1], [1, 0], [1, 1]];

/**
 * Which cells of a tile and of a rim around it were seen: 1 or 0, (size + 2 × SOFT)² of them. `cells` gives the classes of
 * the tile itself (0, 0) or of one beside it; null: nothing is known of it, and nothing was seen.
 */
export function seenWithRim(size: number, cells: (side: Side) => Uint8Array | null): Uint8Array {
  const wide = size + 2 * SOFT;
  const seen = new Uint8Array(wide * wide);
  for (const side of [[0, 0], ...SIDES] as const) {
    const classes = cells(side);
    if (!classes) continue;
    const [top, height, intoRow] = part(side[0], size);
    const [left, width, intoColumn] = part(side[1], size);
    for (let row = 0; row < height; row += 1) {
      const from = (top + row) * size + left;
      const into = (intoRow + row) * wide + intoColumn;
      for (let column = 0; column < width; column += 1) seen[into + column] = classes[from + column] === 0 ? 0 : 1;
    }
  }
  return seen;
}

/** Rows (or columns) of a tile that belong to the rim or the middle: first one, how many, and where they go. */
function part(step: number, size: number): [from: number, count: number, into: number] {
  if (step < 0) return [size - SOFT, SOFT, 0];
  return step > 0 ? [0, SOFT, size + SOFT] : [0, size, SOFT];
}

/**
 * How much of each cell is shown, 0 to 255: nothing of one that was not seen, more the farther from the next such cell, all
 * from SOFT cells on. Null where everything is shown.
 */
export function softened(seen: Uint8Array, size: number): Uint8Array | null {
  if (!seen.includes(0)) return null;
  const wide = size + 2 * SOFT;
  const away = distances(seen, wide);
  const shown = new Uint8Array(size * size);
  for (let row = 0; row < size; row += 1) {
    const from = (row + SOFT) * wide + SOFT;
    for (let column = 0; column < size; column += 1) shown[row * size + column] = RAMP[away[from + column] ?? 0] ?? 255;
  }
  return shown;
}

/** Steps to a neighbour and to one across a corner; their ratio is near to that of the lengths. */
const STRAIGHT = 3;
const ACROSS = 4;

/** How far each cell is from the next one that was not seen, in thirds of a cell, by one pass down and one up. */
function distances(seen: Uint8Array, wide: number): Uint8Array {
  const most = SOFT * STRAIGHT;
  const away = new Uint8Array(seen.length);
  for (let at = 0; at < away.length; at += 1) away[at] = seen[at] === 0 ? 0 : most;
  for (let row = 1; row < wide; row += 1) {
    for (let at = row * wide + 1; at < (row + 1) * wide - 1; at += 1) relax(away, at, -1, -wide);
  }
  for (let row = wide - 2; row >= 0; row -= 1) {
    for (let at = (row + 1) * wide - 2; at > row * wide; at -= 1) relax(away, at, 1, wide);
  }
  return away;
}

/** Takes a shorter path over one of the four neighbours that were looked at before. */
function relax(away: Uint8Array, at: number, beside: number, row: number): void {
  const now = away[at] ?? 0;
  if (now === 0) return;
  const straight = Math.min(away[at + beside] ?? 0, away[at + row] ?? 0) + STRAIGHT;
  const across = Math.min(away[at + row - 1] ?? 0, away[at + row + 1] ?? 0) + ACROSS;
  const least = Math.min(straight, across);
  if (least < now) away[at] = least;
}

const RAMP = Uint8Array.from({ length: SOFT * STRAIGHT + 1 }, (_, distance) => {
  const share = distance / (SOFT * STRAIGHT);
  return Math.round(255 * share * share * (3 - 2 * share));
});

/** The tiles beside one whose rim changes when its classes change. */
export function changedSides(before: Uint8Array | null, after: Uint8Array, size: number): Side[] {
  return SIDES.filter((side) => {
    // The rim of the tile on one side is this tile's strip on that side.
    const [top, height] = part(-side[0], size);
    const [left, width] = part(-side[1], size);
    for (let row = top; row < top + height; row += 1) {
      for (let at = row * size + left; at < row * size + left + width; at += 1) {
        if (((before?.[at] ?? 0) === 0) !== (after[at] === 0)) return true;
      }
    }
    return false;
  });
}

/** Makes pixels as transparent as a mask says. Changes the pixels given. */
export function fade(pixels: Uint8ClampedArray, shown: Uint8Array | null): void {
  if (!shown) return;
  for (let cell = 0; cell < shown.length; cell += 1) {
    const at = cell * 4 + 3;
    pixels[at] = ((pixels[at] ?? 0) * (shown[cell] ?? 255)) / 255;
  }
}
