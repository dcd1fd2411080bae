import { areaOf, lengthOf, type Measured } from "../state/measure.ts";
import * as format from "./format.ts";
import { pointer, say } from "./say.ts";
import type { Units } from "./units.ts";

export interface MeasureWords {
  title: string;
  /** What to do next. */
  line: string;
}

/** What was measured so far. */
export function measureWords(drawn: Measured, units: Units, touch: boolean): MeasureWords {
  const by = { pointer: pointer(touch) };
  const { points, closed } = drawn;
  if (points.length === 0) return { title: say("measure"), line: say("measure-begin", by) };
  if (points.length === 1) return { title: say("measure"), line: say("measure-next", by) };
  const length = format.distance(lengthOf(drawn), units);
  if (!closed) {
    return { title: length, line: points.length < 3 ? say("measure-go-on", by) : say("measure-close", by) };
  }
  const area = areaOf(drawn);
  if (area === null) return { title: say("measure-around", { length }), line: say("measure-crosses") };
  return { title: say("measure-area-around", { area: format.area(area, units), length }), line: say("measure-again", by) };
}
