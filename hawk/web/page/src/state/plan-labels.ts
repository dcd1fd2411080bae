import { partsOf } from "../plan/values.ts";
import type { PlanEditing } from "./plan-edit.ts";

/** Names of the rows of the stalls that are chosen, in their order. */
export function rowsChosen({ chosen }: PlanEditing): string[] {
  return [...new Set(chosen.flatMap(({ label }) => partsOf(label)?.row ?? []))];
}

/** Gives the chosen stalls the name of a row; their numbers stay. */
export function renameRow(editing: PlanEditing, to: string): void {
  if (editing.selection.size > 0) editing.do({ do: "rename", ...whatIsChosen(editing), to });
}

/** Numbers the chosen stalls from the other end of their row. */
export function reverseRow(editing: PlanEditing): void {
  if (editing.selection.size > 0) editing.do({ do: "reverse", ...whatIsChosen(editing) });
}

/** Adds to the numbers of the chosen stalls. */
export function shiftNumbers(editing: PlanEditing, by: number): void {
  if (editing.selection.size > 0) editing.do({ do: "shift", ...whatIsChosen(editing), by });
}

/** Exchanges the names of the two rows whose stalls are chosen. */
export function swapRows(editing: PlanEditing): void {
  const [one, other, third] = rowsChosen(editing);
  if (one !== undefined && other !== undefined && third === undefined) editing.do({ do: "swap", rows: [one, other] });
}

/** Does what a key stands for: X swaps, I reverses, N names, Page up and Page down shift. Returns whether it was one of these. */
export function labelByKey(key: string, editing: PlanEditing): boolean {
  switch (key.length === 1 ? key.toLowerCase() : key) {
    case "x":
      swapRows(editing);
      return true;
    case "i":
      reverseRow(editing);
      return true;
    case "n":
      editing.name();
      return true;
    case "PageUp":
      shiftNumbers(editing, 1);
      return true;
    case "PageDown":
      shiftNumbers(editing, -1);
      return true;
    default:
      return false;
  }
}

/** A whole row by its name: the store then takes the whole name from a row of hawk's own. */
function whatIsChosen(editing: PlanEditing): { row: string } | { stalls: string[] } {
  const { chosen, plan } = editing;
  const [row, other] = rowsChosen(editing);
  const members = [...plan.stalls.values()].filter(({ label }) => partsOf(label)?.row === row);
  const isWhole = row !== undefined && other === undefined && members.length === chosen.length;
  return isWhole ? { row } : { stalls: chosen.map(({ id }) => id) };
}
