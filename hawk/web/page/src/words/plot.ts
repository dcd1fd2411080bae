import type { Sample } from "../state/flight.ts";
import { SCALES, type Units } from "./units.ts";

/** A plot of heights ends at a multiple of so much. */
const STEP: Record<Units, number> = { metres: 15, feet: 50 };

/** Upper end of a plot of heights, in the units; `highest` in metres. */
export function topHeight(highest: number | undefined, units: Units): number {
  const step = STEP[units];
  return Math.max(step, Math.ceil((highest ?? 60) / SCALES[units].metres / step) * step);
}

/** Heights of samples, in the units. */
export function heightsOf(samples: readonly Sample[], units: Units): (number | null)[] {
  return samples.map(({ height }) => (height === null ? null : height / SCALES[units].metres));
}
