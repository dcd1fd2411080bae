import type { Point } from "../protocol.ts";
import { toCoordinate } from "./geometry.ts";
import { path, stroke, type Surface } from "./surface.ts";

/** Stalls of a lot that begin and end if a survey is taken over: corners on the map. */
export interface ChangesMark {
  begin: readonly (readonly Point[])[];
  end: readonly (readonly Point[])[];
}

/** Stalls that begin are framed; those that end are crossed out, so that they differ in any colours. */
export function drawChanges(surface: Surface, { begin, end }: ChangesMark): void {
  const { context, palette } = surface;
  for (const stall of end) {
    outline(surface, stall, palette.ends, true);
  }
  for (const stall of begin) {
    outline(surface, stall, palette.begins, false);
  }
  context.lineJoin = "miter";
}

function outline(surface: Surface, stall: readonly Point[], colour: string, crossed: boolean): void {
  const { context, palette } = surface;
  const pixels = stall.map((place) => surface.pixel(toCoordinate(place)));
  const [a, b, c, d] = pixels;
  if (!a || !b || !c || !d) return;
  path(context, pixels, true);
  if (crossed) {
    context.moveTo(...a);
    context.lineTo(...c);
    context.moveTo(...b);
    context.lineTo(...d);
  }
  context.lineJoin = "round";
  stroke(context, { colour: palette.planCase, width: 5 });
  stroke(context, { colour, width: 2.5 });
}
