import { FONT_FAMILY } from "../font.ts";
import type { Stall, StallState } from "../state/map-store.ts";
import { corners } from "./geometry.ts";
import type { StallFrame } from "./square-pictures.ts";
import { css, DASHES, type Detail, FILLS, HATCH, HATCH_SHARE, hatchPeriod, HEAT, inset, LINES } from "./stall-style.ts";

const ORDER: readonly StallState[] = ["suggested", "free", "taken", "unknown"];

/** Draws stalls, all of a kind at once: where they overlap, nothing becomes darker. Question marks are drawn apart. */
export function drawStalls(context: CanvasRenderingContext2D, stalls: Iterable<Stall>, frame: StallFrame, detail: Detail): void {
  const kinds: Record<StallState, Stall[]> = { free: [], taken: [], unknown: [], suggested: [] };
  const heat: Stall[][] = HEAT.map(() => []);
  for (const stall of stalls) (heat[stall.heat ?? -1] ?? kinds[stall.state]).push(stall);
  for (const state of ORDER) {
    if (kinds[state].length === 0) continue;
    outline(context, kinds[state], frame, detail);
    context.fillStyle = css(FILLS[state]);
    context.fill();
    if (state === "taken") fillHatched(context, frame, detail);
    if (detail.line === 0) continue;
    context.strokeStyle = LINES[state];
    context.lineWidth = detail.line;
    context.setLineDash(DASHES[state]);
    context.stroke();
  }
  context.setLineDash([]);
  HEAT.forEach((fill, step) => {
    const alike = heat[step] ?? [];
    if (alike.length === 0) return;
    outline(context, alike, frame, detail);
    context.fillStyle = css(fill);
    context.fill();
    context.strokeStyle = LINES.unknown;
    context.lineWidth = 1;
    if (detail.line > 0) context.stroke();
  });
}

function outline(context: CanvasRenderingContext2D, stalls: readonly Stall[], { west, north, resolution }: StallFrame, { line }: Detail): void {
  context.beginPath();
  for (const stall of stalls) {
    corners(inset(stall, line, resolution)).forEach((corner, index) => {
      const [x, y] = [(corner[0] - west) / resolution, (north - corner[1]) / resolution];
      if (index === 0) context.moveTo(x, y);
      else context.lineTo(x, y);
    });
    context.closePath();
  }
}

/** Hatching too fine to be seen is drawn as the colour that it would have from afar. */
function fillHatched(context: CanvasRenderingContext2D, { resolution, ratio }: StallFrame, { hatched }: Detail): void {
  const pattern = hatched ? hatching(context, hatchPeriod(resolution), ratio) : null;
  context.fillStyle = pattern ?? css({ ...HATCH, alpha: HATCH.alpha * HATCH_SHARE });
  context.fill();
}

const made = new Map<number, HTMLCanvasElement>();

/** Lines from lower left to upper right. Its canvas is made once for each size. */
function hatching(context: CanvasRenderingContext2D, period: number, ratio: number): CanvasPattern | null {
  const size = Math.round(period * Math.SQRT2 * ratio);
  const canvas = made.get(size) ?? hatchCanvas(size);
  made.set(size, canvas);
  const pattern = context.createPattern(canvas, "repeat");
  pattern?.setTransform(new DOMMatrix([1 / ratio, 0, 0, 1 / ratio, 0, 0]));
  return pattern;
}

function hatchCanvas(size: number): HTMLCanvasElement {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = size;
  const context = canvas.getContext("2d");
  if (!context) return canvas;
  context.strokeStyle = css(HATCH);
  context.lineWidth = (size / Math.SQRT2) * HATCH_SHARE;
  context.beginPath();
  for (const shift of [-size, 0, size]) {
    context.moveTo(shift - 1, size + 1);
    context.lineTo(shift + size + 1, -1);
  }
  context.stroke();
  return canvas;
}

/** A question mark in the middle of each unclear stall, upright on the screen. */
export function drawMarks(context: CanvasRenderingContext2D, places: readonly (readonly [number, number])[]): void {
  context.font = `700 14px ${FONT_FAMILY}`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.lineWidth = 2;
  context.strokeStyle = "rgba(16,22,28,.8)";
  context.fillStyle = "#fff";
  for (const [x, y] of places) {
    context.strokeText("?", x, y);
    context.fillText("?", x, y);
  }
}
