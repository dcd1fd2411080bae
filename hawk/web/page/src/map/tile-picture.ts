import { CELL } from "../state/tile-data.ts";
import { SOFT } from "./feather.ts";
import { type Palette, rgb, type Rgb } from "./palette.ts";

/** The picture is made of blocks of this number of pixels a side; one that is all black was never seen. */
const BLOCK = 8;
const BLACK = 22;
/** A black car covers no more whole blocks. */
const CAR_BLOCKS = 18;

/** Colours of the cells as RGBA: what lies under the picture. */
export function classPixels(classes: Uint8Array, palette: Palette): Uint8ClampedArray<ArrayBuffer> {
  return paint(classes, (cell) => {
    if (cell === CELL.unknown) return null;
    return { colour: rgb(cell === CELL.nonLot ? palette.ground : palette.asphalt), alpha: 255 };
  });
}

/** A veil over what is not lot. */
export function veilPixels(classes: Uint8Array, palette: Palette): Uint8ClampedArray<ArrayBuffer> {
  const colour = rgb(palette.veil);
  return paint(classes, (cell) => (cell === CELL.nonLot ? { colour, alpha: 150 } : null));
}

/**
 * Takes out of `seen` (1 or 0, a rim of SOFT cells around the tile) what the camera's picture does not show yet: it is
 * black there. A black patch as small as a car, in the midst of what was seen, is one. `known`: the cells are known, so
 * that black alone proves little. Changes `seen`.
 */
export function leaveOutBlack(pixels: Uint8ClampedArray, size: number, seen: Uint8Array, known: boolean): void {
  const blocks = size / BLOCK;
  const black = Float32Array.from({ length: blocks * blocks }, (_, block) => blackShare(pixels, size, block));
  const unseen = known ? largePatches(black, blocks, (block) => hasUnseen(seen, size, block)) : black.map((share) => (share === 1 ? 1 : 0));
  black.forEach((share, block) => {
    if (unseen[block] === 1) takeOut(seen, pixels, size, block, 256);
    else if (share > 0 && beside(unseen, blocks, block)) takeOut(seen, pixels, size, block, BLACK);
  });
}

/** Marks the black blocks that hang together, unless they are so few as a dark car and nothing unseen is among them. */
function largePatches(black: Float32Array, blocks: number, hasUnseenIn: (block: number) => boolean): Float32Array {
  const found = new Float32Array(black.length);
  const visited = new Uint8Array(black.length);
  black.forEach((share, block) => {
    if (share !== 1 || visited[block] === 1) return;
    const patch = patchOf(black, blocks, block, visited);
    if (patch.length > CAR_BLOCKS || patch.some(hasUnseenIn)) for (const each of patch) found[each] = 1;
  });
  return found;
}

function patchOf(black: Float32Array, blocks: number, start: number, visited: Uint8Array): number[] {
  const patch = [start];
  visited[start] = 1;
  for (const block of patch) {
    for (const next of around(block, blocks)) {
      if (black[next] !== 1 || visited[next] === 1) continue;
      visited[next] = 1;
      patch.push(next);
    }
  }
  return patch;
}

function beside(marked: Float32Array, blocks: number, block: number): boolean {
  return around(block, blocks).some((each) => marked[each] === 1);
}

/** The blocks that touch a block, corners too. */
function around(block: number, blocks: number): number[] {
  const column = block % blocks;
  const sides = [0, ...(column > 0 ? [-1] : []), ...(column < blocks - 1 ? [1] : [])];
  const all = [-blocks, 0, blocks].flatMap((row) => sides.map((side) => block + row + side));
  return all.filter((each) => each !== block && each >= 0 && each < blocks * blocks);
}

function hasUnseen(seen: Uint8Array, size: number, block: number): boolean {
  const [left, top] = corner(size, block);
  const wide = size + 2 * SOFT;
  for (let row = top; row < top + BLOCK; row += 1) {
    const at = (row + SOFT) * wide + left + SOFT;
    if (seen.subarray(at, at + BLOCK).includes(0)) return true;
  }
  return false;
}

function blackShare(pixels: Uint8ClampedArray, size: number, block: number): number {
  const [left, top] = corner(size, block);
  let black = 0;
  for (let row = top; row < top + BLOCK; row += 2) {
    for (let column = left; column < left + BLOCK; column += 2) {
      if (brightness(pixels, (row * size + column) * 4) < BLACK) black += 1;
    }
  }
  return black / (BLOCK * BLOCK * 0.25);
}

/** Takes out the cells of a block whose pixels are darker than given. */
function takeOut(seen: Uint8Array, pixels: Uint8ClampedArray, size: number, block: number, below: number): void {
  const [left, top] = corner(size, block);
  const wide = size + 2 * SOFT;
  for (let row = top; row < top + BLOCK; row += 1) {
    for (let column = left; column < left + BLOCK; column += 1) {
      if (brightness(pixels, (row * size + column) * 4) < below) seen[(row + SOFT) * wide + column + SOFT] = 0;
    }
  }
}

function brightness(pixels: Uint8ClampedArray, at: number): number {
  return Math.max(pixels[at] ?? 0, pixels[at + 1] ?? 0, pixels[at + 2] ?? 0);
}

function corner(size: number, block: number): [left: number, top: number] {
  const blocks = size / BLOCK;
  return [(block % blocks) * BLOCK, Math.floor(block / blocks) * BLOCK];
}

type Paint = { colour: Rgb; alpha: number } | null;

/** Looks each cell's colour up, a whole pixel at a time. */
function paint(classes: Uint8Array, of: (cell: number) => Paint): Uint8ClampedArray<ArrayBuffer> {
  const lookup = new Uint32Array(256);
  const bytes = new Uint8Array(lookup.buffer);
  for (const cell of Object.values(CELL)) {
    const found = of(cell);
    if (found) bytes.set([...found.colour, found.alpha], cell * 4);
  }
  const pixels = new Uint32Array(classes.length);
  for (let index = 0; index < classes.length; index += 1) pixels[index] = lookup[classes[index] ?? 0] ?? 0;
  return new Uint8ClampedArray(pixels.buffer);
}
