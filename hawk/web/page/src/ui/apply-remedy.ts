import type { Operator } from "../state/operator.ts";
import { type Remedy, REMEDIES } from "../words/remedies.ts";
import { say } from "../words/say.ts";

/** Applies the remedy of a failed check: sends its command, or opens the editor of the fence. `from`: where the page hears it. */
export function applyRemedy(model: Operator, remedy: Remedy, from: EventTarget): void {
  if (remedy === "Set Fence") from.dispatchEvent(new CustomEvent("open-panel", { detail: "fence", bubbles: true }));
  else void model.command({ Type: remedy }, say(REMEDIES[remedy]));
}

/** Brings the failed checks in sight. */
export function showChecks(from: EventTarget): void {
  from.dispatchEvent(new CustomEvent("open-panel", { detail: "checks", bubbles: true }));
}
