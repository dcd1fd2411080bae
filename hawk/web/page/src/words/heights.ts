import * as format from "./format.ts";

/** What is wrong with three heights, or nothing. */
export function heightsProblem(min: number, des: number, max: number, ceiling: number | null): string {
  const named: [string, number][] = [
    ["Never below", min],
    ["Flies at", des],
    ["Never above", max],
  ];
  const wrong = named.find(([, value]) => !Number.isFinite(value) || value <= 0);
  if (wrong) return `${wrong[0]}: give a number of metres above 0.`;
  if (min > des) return `Flies at: ${format.height(des)} is below the lowest height of ${format.height(min)}.`;
  if (des > max) return `Flies at: ${format.height(des)} is above the highest height of ${format.height(max)}.`;
  if (ceiling !== null && max > ceiling) return `Never above: the fence ends at ${format.height(ceiling)}.`;
  return "";
}
