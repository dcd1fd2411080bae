import type { Operator } from "../state/operator.ts";
import { type Action, COMMANDS } from "../words/actions.ts";
import { type AskedCommand, OVERRULING } from "../words/confirm.ts";

/** Starts the motors or makes the drone fly somewhere: one click is not enough. */
const ASKED = new Set(["Arm", "Takeoff", "Autonomous Explore", "Resume"]);

/** Starts an action of the bar: asks first, or sends its command. */
export function startAction(model: Operator, action: Action): void {
  if (action.name === "move") {
    model.pick(!model.picking);
    return;
  }
  const type = COMMANDS[action.name];
  const manual = model.view().heartbeat?.State === "Manual";
  if (isAsked(type, manual)) model.ask({ about: type });
  else void model.command({ Type: type }, action.label);
}

/** Land and Return home are asked about only while a pilot flies, who would be overruled. */
function isAsked(type: string, manual: boolean): type is AskedCommand {
  return ASKED.has(type) || (manual && OVERRULING.has(type as AskedCommand));
}
