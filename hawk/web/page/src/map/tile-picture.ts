import { CELL } from "../state/tile-data.ts";
import { type Palette, rgb, type Rgb } from "./palette.ts";

/** A block of so many pixels a side that is all black was never seen by the camera. */
const BLOCK = 8;
const BLACK = 14;

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

/** Makes blocks of the picture transparent that the camera never saw. Changes the pixels given. */
export function clearUnseen(pixels: Uint8ClampedArray, width: number, height: number): void {
  for (let top = 0; top < height; top += BLOCK) {
    for (let left = 0; left < width; left += BLOCK) {
      if (brightest(pixels, width, left, top) < BLACK) clearBlock(pixels, width, left, top);
    }
  }
}

function brightest(pixels: Uint8ClampedArray, width: number, left: number, top: number): number {
  let most = 0;
  for (let row = top; row < top + BLOCK; row += 2) {
    for (let column = left; column < left + BLOCK; column += 2) {
      const at = (row * width + column) * 4;
      most = Math.max(most, pixels[at] ?? 0, pixels[at + 1] ?? 0, pixels[at + 2] ?? 0);
    }
  }
  return most;
}

function clearBlock(pixels: Uint8ClampedArray, width: number, left: number, top: number): void {
  for (let row = top; row < top + BLOCK; row += 1) {
    for (let column = left; column < left + BLOCK; column += 1) pixels[(row * width + column) * 4 + 3] = 0;
  }
}

type Paint = { colour: Rgb; alpha: number } | null;

function paint(classes: Uint8Array, of: (cell: number) => Paint): Uint8ClampedArray<ArrayBuffer> {
  const paints = [0, 1, 2, 3, 4].map(of);
  const pixels = new Uint8ClampedArray(classes.length * 4);
  for (let index = 0; index < classes.length; index += 1) {
    const found = paints[classes[index] ?? 0];
    if (!found) continue;
    pixels[index * 4] = found.colour[0];
    pixels[index * 4 + 1] = found.colour[1];
    pixels[index * 4 + 2] = found.colour[2];
    pixels[index * 4 + 3] = found.alpha;
  }
  return pixels;
}
