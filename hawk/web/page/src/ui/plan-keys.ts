import type { Operator } from "../state/operator.ts";
import { isTyping } from "./keys.ts";

/** Undo and redo of a plan that is corrected, wherever the focus is: Ctrl+Z, and Ctrl+Shift+Z or Ctrl+Y. */
export function undoByKey(event: KeyboardEvent, model: Operator): void {
  const { plan } = model;
  if (!plan.open || event.defaultPrevented || event.altKey || !(event.ctrlKey || event.metaKey) || isTyping(event.target)) return;
  const key = event.key.toLowerCase();
  if (key === "z" && !event.shiftKey) plan.undo();
  else if (key === "y" || key === "z") plan.redo();
  else return;
  event.preventDefault();
}
