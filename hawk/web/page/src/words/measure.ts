import { areaOf, lengthOf, type Measured } from "../state/measure.ts";
import * as format from "./format.ts";
import type { Units } from "./units.ts";

export interface MeasureWords {
  title: string;
  /** What to do next. */
  line: string;
}

/** What was measured so far. */
export function measureWords(drawn: Measured, units: Units, touch: boolean): MeasureWords {
  const point = touch ? "Tap" : "Click";
  const { points, closed } = drawn;
  if (points.length === 0) return { title: "Measure", line: `${point} two or more places.` };
  if (points.length === 1) return { title: "Measure", line: `${point} the next place.` };
  const length = format.distance(lengthOf(drawn), units);
  if (!closed) {
    const more = points.length < 3 ? `${point} more places to go on.` : `${point} the first place to close it and see the area.`;
    return { title: length, line: more };
  }
  const area = areaOf(drawn);
  const title = area === null ? `${length} around` : `${format.area(area, units)}, ${length} around`;
  return { title, line: area === null ? "Its sides cross: it has no one area." : `${point} to begin again.` };
}
