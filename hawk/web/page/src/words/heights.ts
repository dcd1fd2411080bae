import * as format from "./format.ts";
import type { Units } from "./units.ts";

/** What is wrong with three heights (metres), or nothing. */
export function heightsProblem(min: number, des: number, max: number, ceiling: number | null, units: Units): string {
  const named: [string, number][] = [
    ["Never below", min],
    ["Flies at", des],
    ["Never above", max],
  ];
  const wrong = named.find(([, value]) => !Number.isFinite(value) || value <= 0);
  if (wrong) return `${wrong[0]}: give a number of ${units} above 0.`;
  if (min > des) return `Flies at: ${format.height(des, units)} is below the lowest height of ${format.height(min, units)}.`;
  if (des > max) return `Flies at: ${format.height(des, units)} is above the highest height of ${format.height(max, units)}.`;
  if (ceiling !== null && max > ceiling) return `Never above: the fence ends at ${format.height(ceiling, units)}.`;
  return "";
}
