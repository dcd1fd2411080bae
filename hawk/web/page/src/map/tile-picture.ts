import { CELL } from "../state/tile-data.ts";
import { type Palette, rgb, type Rgb } from "./palette.ts";

/** The picture is made of blocks of this number of pixels a side; one that is all black was never seen. */
const BLOCK = 8;
const BLACK = 22;
/** A block with so much black lies at the edge of what was seen; less may be a dark car. */
const EDGE_SHARE = 0.2;

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

/** Makes transparent what the camera never saw: it is black in the picture. Changes the pixels given. */
export function clearUnseen(pixels: Uint8ClampedArray, size: number): void {
  const blocks = size / BLOCK;
  const black = Float32Array.from({ length: blocks * blocks }, (_, block) => blackShare(pixels, size, block));
  black.forEach((share, block) => {
    if (share === 1) clearBlock(pixels, size, block, 256);
    else if (share >= EDGE_SHARE || (share > 0 && besideBlack(black, blocks, block))) clearBlock(pixels, size, block, BLACK);
  });
}

function besideBlack(black: Float32Array, blocks: number, block: number): boolean {
  const column = block % blocks;
  const sides = [0, ...(column > 0 ? [-1] : []), ...(column < blocks - 1 ? [1] : [])];
  return [-blocks, 0, blocks].some((row) => sides.some((side) => black[block + row + side] === 1));
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

/** Clears the pixels of a block that are darker than given. */
function clearBlock(pixels: Uint8ClampedArray, size: number, block: number, below: number): void {
  const [left, top] = corner(size, block);
  for (let row = top; row < top + BLOCK; row += 1) {
    for (let column = left; column < left + BLOCK; column += 1) {
      const at = (row * size + column) * 4;
      if (brightness(pixels, at) < below) pixels[at + 3] = 0;
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
