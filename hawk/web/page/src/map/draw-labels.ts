import { FONT_FAMILY } from "../font.ts";
import { partsOf } from "../plan/values.ts";
import { type Rectangle, type Sight, toPixel } from "./geometry.ts";

/** A stall with its label, "A 12" as painted. */
export interface Labelled extends Rectangle {
  label: string;
}

/** Letters of a row beside its first stall. */
export interface RowMark {
  row: string;
  north: number;
  east: number;
  /** Where the row begins, seen from its stalls: metres north and east, together 1. */
  out: readonly [number, number];
}

/** A stall that is narrower on the screen has no number. */
const LEAST_PX = 18;
const DISC_PX = 12;
/** Half discs by which a letter goes out at most. */
const MOST_STEPS = 6;
/** Of the stall's length from its middle: there the number stands clear of the question mark. */
const OFF_MIDDLE = 0.3;
/** A row's letters stand so far before its first stall, widths of it. */
const BEFORE = 1.1;

/** Where the letters of each row stand: before its first stall, in line with the second one. */
export function rowMarks(stalls: readonly Labelled[]): RowMark[] {
  const rows = new Map<string, { number: number; stall: Labelled }[]>();
  for (const stall of stalls) {
    const parts = partsOf(stall.label);
    if (!parts) continue;
    const found = rows.get(parts.row) ?? [];
    if (found.push({ number: parts.number, stall }) === 1) rows.set(parts.row, found);
  }
  return [...rows].flatMap(([row, all]) => {
    const [first, second] = all.sort((one, other) => one.number - other.number);
    return first ? [{ row, ...before(first.stall, second?.stall) }] : [];
  });
}

function before(first: Labelled, second: Labelled | undefined): Omit<RowMark, "row"> {
  const [up, right] = second ? [first.north - second.north, first.east - second.east] : [-Math.sin(first.angle), -Math.cos(first.angle)];
  const length = Math.max(0.1, Math.hypot(up, right));
  const out = [up / length, right / length] as const;
  return { north: first.north + out[0] * BEFORE * first.width, east: first.east + out[1] * BEFORE * first.width, out };
}

/** The number of each stall, upright, where it has room. */
export function drawNumbers(context: CanvasRenderingContext2D, stalls: Iterable<Labelled>, sight: Sight): void {
  context.font = `700 11px ${FONT_FAMILY}`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.lineJoin = "round";
  context.lineWidth = 3;
  context.strokeStyle = "rgba(16,22,28,.8)";
  context.fillStyle = "#fff";
  for (const stall of stalls) {
    if (stall.width / sight.resolution < LEAST_PX) continue;
    const along = (Math.cos(stall.angle) < 0 ? -1 : 1) * OFF_MIDDLE * stall.length; // the same end all along a row
    const [x, y] = toPixel(sight, [stall.east + along * Math.sin(stall.angle), stall.north + along * Math.cos(stall.angle)]);
    const text = String(partsOf(stall.label)?.number ?? stall.label);
    context.strokeText(text, x, y);
    context.fillText(text, x, y);
  }
}

/** Where discs are drawn: one that would cover another one goes farther out of its row. */
export function discsOf(rows: readonly RowMark[], sight: Sight): (readonly [number, number])[] {
  const found: (readonly [number, number])[] = [];
  const isFree = ([x, y]: readonly [number, number]): boolean => found.every(([a, b]) => Math.hypot(a - x, b - y) >= 2 * DISC_PX);
  for (const { north, east, out } of rows) {
    let at = toPixel(sight, [east, north]);
    for (let step = 1; step <= MOST_STEPS && !isFree(at); step += 1) {
      const away = step * DISC_PX * sight.resolution;
      at = toPixel(sight, [east + out[1] * away, north + out[0] * away]);
    }
    found.push(at);
  }
  return found;
}

/** The letters of rows, each in a disc. */
export function drawRows(context: CanvasRenderingContext2D, rows: readonly RowMark[], sight: Sight): void {
  context.font = `700 13px ${FONT_FAMILY}`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  const places = discsOf(rows, sight);
  for (const [index, { row }] of rows.entries()) {
    const [x, y] = places[index] ?? [0, 0];
    const half = Math.max(DISC_PX, context.measureText(row).width / 2 + 6);
    context.beginPath();
    context.roundRect(x - half, y - DISC_PX, 2 * half, 2 * DISC_PX, DISC_PX);
    context.fillStyle = "#fff";
    context.fill();
    context.lineWidth = 2;
    context.strokeStyle = "#15202b";
    context.stroke();
    context.fillStyle = "#15202b";
    context.fillText(row, x, y + 0.5);
  }
}
