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
}

/** A stall that is narrower on the screen has no number. */
const LEAST_PX = 18;
const DISC_PX = 12;
/** Of the stall's length from its middle: there the number stands clear of the question mark. */
const OFF_MIDDLE = 0.3;
/** A row's letters stand so far before its first stall, widths of it. */
const BEFORE = 1.1;

/** Where the letters of each row stand: before its first stall, in line with the second one. */
export function rowMarks(stalls: readonly Labelled[]): RowMark[] {
  const rows = new Map<string, { number: number; stall: Labelled }[]>();
  for (const stall of stalls) {
    const parts = partsOf(stall.label);
    if (parts) rows.set(parts.row, [...(rows.get(parts.row) ?? []), { number: parts.number, stall }]);
  }
  return [...rows].flatMap(([row, all]) => {
    const [first, second] = all.sort((one, other) => one.number - other.number);
    return first ? [{ row, ...before(first.stall, second?.stall) }] : [];
  });
}

function before(first: Labelled, second: Labelled | undefined): { north: number; east: number } {
  const [up, right] = second ? [first.north - second.north, first.east - second.east] : [-Math.sin(first.angle), -Math.cos(first.angle)];
  const away = (BEFORE * first.width) / Math.max(0.1, Math.hypot(up, right));
  return { north: first.north + up * away, east: first.east + right * away };
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

/** The letters of rows, each in a disc. */
export function drawRows(context: CanvasRenderingContext2D, rows: readonly RowMark[], sight: Sight): void {
  context.font = `700 13px ${FONT_FAMILY}`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  for (const { row, north, east } of rows) {
    const [x, y] = toPixel(sight, [east, north]);
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
