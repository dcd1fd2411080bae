/** What was seen fades in over so many cells inside its edge: there the picture is half black and full of stairs. */
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
 * How much of each cell is shown, 0 to 255: nothing up to the edge of what was seen, all of it from SOFT cells inside on.
 * Null where everything is shown.
 */
export function softened(seen: Uint8Array, size: number): Uint8Array | null {
  if (seen.every((cell) => cell === 1)) return null;
  const wide = size + 2 * SOFT;
  const window = 2 * SOFT + 1;
  const across = new Uint8Array(wide * size);
  for (let row = 0; row < wide; row += 1) {
    let sum = 0;
    for (let column = 0; column < wide; column += 1) {
      sum += seen[row * wide + column] ?? 0;
      if (column >= window) sum -= seen[row * wide + column - window] ?? 0;
      if (column >= window - 1) across[row * size + column - window + 1] = sum;
    }
  }
  const shown = new Uint8Array(size * size);
  for (let column = 0; column < size; column += 1) {
    let sum = 0;
    for (let row = 0; row < wide; row += 1) {
      sum += across[row * size + column] ?? 0;
      if (row >= window) sum -= across[(row - window) * size + column] ?? 0;
      if (row >= window - 1) shown[(row - window + 1) * size + column] = RAMP[sum] ?? 255;
    }
  }
  return shown;
}

/** Half of the window is seen at a straight edge, all of it SOFT cells inside. */
const RAMP = Uint8Array.from({ length: (2 * SOFT + 1) ** 2 + 1 }, (_, sum) => {
  const share = Math.max(0, (2 * sum) / (2 * SOFT + 1) ** 2 - 1);
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
