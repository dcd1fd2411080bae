import type { Side, Spot } from "./values.ts";

const LEAST_M = 0.01;
/** A sharper corner is not mitred farther than this number of widths: the store says whether the strip can be. */
const LONGEST_MITRE = 4;

/** The ring of the strip on a side of a line, as one goes along it, this number of metres wide, with mitred corners. */
export function stripOf(line: readonly Spot[], width: number, side: Side): Spot[] {
  const course = line.filter((place, index) => index === 0 || apart(place, line[index - 1] ?? place) >= LEAST_M);
  const off = side === "right" ? width : -width;
  const directions = course.slice(1).map((place, index) => directionOf(course[index] ?? place, place));
  const [first] = directions;
  if (!first) return [];
  const far = course.map(([north, east], index): Spot => {
    const [before, after] = [directions[index - 1] ?? directions[index] ?? first, directions[index] ?? directions[index - 1] ?? first];
    const [up, right] = [-(before[1] + after[1]), before[0] + after[0]]; // to the right of both
    const mitre = Math.min(LONGEST_MITRE, 2 / Math.max(LEAST_M, up * up + right * right));
    return [north + off * up * mitre, east + off * right * mitre];
  });
  return [...course, ...far.reverse()];
}

function apart(one: Spot, other: Spot): number {
  return Math.hypot(one[0] - other[0], one[1] - other[1]);
}

/** North and east of the direction from one place to another one, together 1. */
function directionOf(from: Spot, to: Spot): Spot {
  const length = apart(from, to);
  return [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
}
