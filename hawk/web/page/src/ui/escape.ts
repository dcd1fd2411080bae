import type { Operator } from "../state/operator.ts";

/** Escape leaves what is asked, wherever the focus is. A dialog that took the key for itself has prevented its default. */
export function leaveByEscape(event: KeyboardEvent, model: Operator, otherwise: () => void): void {
  if (event.key !== "Escape" || event.defaultPrevented) return;
  if (!model.leave()) otherwise();
}
