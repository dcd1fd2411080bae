import type { CheckItem } from "../protocol.ts";
import { cannot, control } from "./actions.ts";
import type { View } from "./view.ts";

/** Commands that mend a failed check, with the words of their buttons. */
export const REMEDIES = { "Set Failsafes": "remedy-failsafes", "Clear Kill": "remedy-kill", "Set Fence": "remedy-fence" } as const;
export type Remedy = keyof typeof REMEDIES;

/** What the one in control does next about failed checks: a command, or to look at what no command mends. */
export interface NextRemedy {
  command: Remedy | null;
  /** Failed checks that it is about. */
  checks: number;
}

const GROUNDED = new Set(["Idle", "Configure"]);

/** The next remedy before Arm, in the order of the checks; null when none failed, or somebody else has to see to it. */
export function nextRemedy(view: View): NextRemedy | null {
  const failed = view.heartbeat?.Checks.filter((check) => !check.Passed) ?? [];
  if (failed.length === 0 || control(view) !== "mine" || !GROUNDED.has(view.heartbeat?.State ?? "")) return null;
  const command = failed.map(remedyOf).find((each) => each !== null && cannot(view, each) === "") ?? null;
  return { command, checks: command === null ? failed.length : failed.filter((check) => remedyOf(check) === command).length };
}

function remedyOf(check: CheckItem): Remedy | null {
  return check["Remedy Command"];
}
