import * as format from "./format.ts";
import { say } from "./say.ts";
import type { Units } from "./units.ts";

/** What is wrong with three heights (metres), or nothing. */
export function heightsProblem(min: number, des: number, max: number, ceiling: number | null, units: Units): string {
  const isHeight = (value: number): boolean => Number.isFinite(value) && value > 0;
  if (!isHeight(min)) return say("lowest-no-number", { units });
  if (!isHeight(des)) return say("desired-no-number", { units });
  if (!isHeight(max)) return say("highest-no-number", { units });
  const height = format.height(des, units);
  if (min > des) return say("desired-too-low", { height, lowest: format.height(min, units) });
  if (des > max) return say("desired-too-high", { height, highest: format.height(max, units) });
  if (ceiling !== null && max > ceiling) return say("highest-above-fence", { ceiling: format.height(ceiling, units) });
  return "";
}
