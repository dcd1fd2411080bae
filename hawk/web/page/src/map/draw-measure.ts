import { FONT_FAMILY } from "../font.ts";
import { type Measured } from "../state/measure.ts";
import * as format from "../words/format.ts";
import type { Units } from "../words/units.ts";
import { toCoordinate } from "./geometry.ts";
import { path, type Pixel, stroke, type Surface } from "./surface.ts";

/** A line that is measured, and how its lengths are written. */
export interface MeasureMark extends Measured {
  units: Units;
}

const INK = "#15202b";
/** Sides shorter than this on the screen carry no length, pixels. */
const LABELLED_PX = 56;

/** The line with its places, and the length of each of its sides. */
export function drawMeasure(surface: Surface, { points, closed, units }: MeasureMark): void {
  const { context, resolution } = surface;
  const pixels = points.map((point) => surface.pixel(toCoordinate(point)));
  path(context, pixels, closed);
  if (closed) {
    context.fillStyle = "rgba(255,255,255,.22)";
    context.fill();
  }
  context.lineJoin = "round";
  stroke(context, { colour: "#fff", width: 6 });
  stroke(context, { colour: INK, width: 2.5 });
  for (const pixel of pixels) drawPlace(context, pixel);
  const ends = closed ? [...pixels, ...pixels.slice(0, 1)] : pixels;
  ends.slice(1).forEach((there, index) => {
    const here = ends[index] ?? there;
    const long = Math.hypot(there[0] - here[0], there[1] - here[1]);
    if (long < LABELLED_PX) return;
    drawLabel(context, [(here[0] + there[0]) / 2, (here[1] + there[1]) / 2], format.distance(long * resolution, units));
  });
}

function drawPlace(context: CanvasRenderingContext2D, [x, y]: Pixel): void {
  context.beginPath();
  context.arc(x, y, 6, 0, 2 * Math.PI);
  context.fillStyle = "#fff";
  context.fill();
  stroke(context, { colour: INK, width: 2.5 });
}

function drawLabel(context: CanvasRenderingContext2D, [x, y]: Pixel, words: string): void {
  context.font = `600 13px ${FONT_FAMILY}`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.strokeStyle = "#fff";
  context.lineWidth = 4;
  context.lineJoin = "round";
  context.strokeText(words, x, y);
  context.fillStyle = INK;
  context.fillText(words, x, y);
}
