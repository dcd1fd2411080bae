import type { Changed, Estimate, StallLabel, StateChange } from "../api.ts";
import { partsOf } from "../plan/values.ts";
import { number, say } from "../words/say.ts";

/** The most labels that a sentence names. */
const NAMED = 6;

/** By how many more stalls are free, in large letters. */
export function headline({ value }: Estimate): string {
  if (value === null) return say("compare-none-seen");
  return value === 0 ? say("compare-as-many") : say(value > 0 ? "compare-more" : "compare-fewer", { count: Math.abs(value) });
}

/** Between which numbers that lies: whole stalls, rounded outward. "" where nothing is known. */
export function interval({ low, high }: Estimate, level: number): string {
  if (low === null || high === null) return "";
  const [least, most] = [Math.floor(low), Math.ceil(high)];
  const times = number(10 * level);
  if (least >= 0) return say("compare-interval-more", { low: least, high: most, times });
  if (most <= 0) return say("compare-interval-fewer", { low: -most, high: -least, times });
  return say("compare-interval-both", { fewer: -least, more: most, times });
}

/** How many stalls became taken, free and unclear: those of the list. */
export function became(stalls: readonly StateChange[]): string {
  const count = (state: StateChange["after"]): number => stalls.filter(({ after }) => after === state).length;
  return say("compare-became", { taken: count("taken"), free: count("free"), unknown: count("unknown") });
}

/** What could not be compared, and what is compared though its plan was drawn again: a sentence each. */
export function notCompared({ unknown, matched, begin, gone }: Changed): string[] {
  return [
    ...(unknown === 0 ? [] : [say("compare-unclear", { count: unknown })]),
    ...lone("compare-new", begin),
    ...lone("compare-gone", gone),
    ...(matched === 0 ? [] : [say("compare-redrawn", { count: matched })]),
  ];
}

function lone(key: "compare-new" | "compare-gone", stalls: readonly StallLabel[]): string[] {
  if (stalls.length === 0) return [];
  const labels = stalls.slice(0, NAMED).map(({ label }) => label).join(", ");
  return [say(key, { count: stalls.length, labels, rest: Math.max(0, stalls.length - NAMED) })];
}

/** Whatever has a label, by row. */
export function byRow<T extends { label: string }>(all: readonly T[]): [string, T[]][] {
  const rows = new Map<string, T[]>();
  for (const each of all) {
    const row = partsOf(each.label)?.row ?? "";
    const found = rows.get(row);
    if (found) found.push(each);
    else rows.set(row, [each]);
  }
  return [...rows];
}

/** The order in which people count: AA after Z, 10 after 9. */
export function inOrder(one: string, other: string): number {
  const [[row, number], [otherRow, otherNumber]] = [orderOf(one), orderOf(other)];
  return row.length - otherRow.length || (row < otherRow ? -1 : row > otherRow ? 1 : number - otherNumber);
}

function orderOf(label: string): [string, number] {
  const parts = partsOf(label);
  return parts ? [parts.row, parts.number] : [label, 0];
}
