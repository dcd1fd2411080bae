import { COMMAND_TABLE } from "../command-table.ts";
import type { Command } from "../protocol.ts";
import type { Operator } from "../state/operator.ts";
import { type Action, COMMANDS } from "../words/actions.ts";
import type { AskedCommand } from "../words/confirm.ts";

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

/** One click is not enough to start the motors or to fly somewhere, and to overrule a pilot. */
function isAsked(type: Command["Type"], manual: boolean): type is AskedCommand {
  const { confirm } = COMMAND_TABLE[type];
  return confirm === "slide" || (manual && confirm === "overruling");
}
