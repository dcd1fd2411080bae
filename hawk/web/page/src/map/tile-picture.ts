import { CELL } from "../state/tile-data.ts";
import { SOFT } from "./feather.ts";
import { type Palette, rgb, type Rgb } from "./palette.ts";

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

/** Takes out of `seen` (1 or 0, a rim of SOFT cells around the tile) what the camera's picture does not show. */
export function leaveOutUnseen(mask: Uint8Array, size: number, seen: Uint8Array): void {
  const wide = size + 2 * SOFT;
  mask.forEach((shown, cell) => {
    if (shown === 0) seen[(Math.floor(cell / size) + SOFT) * wide + (cell % size) + SOFT] = 0;
  });
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
