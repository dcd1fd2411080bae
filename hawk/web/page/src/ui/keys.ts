import type { Operator } from "../state/operator.ts";
import { type Action, guidedActions, safetyActions } from "../words/actions.ts";
import { KEYS, type KeyAction } from "../words/keys.ts";
import { startAction } from "./start-action.ts";
import { isTouch } from "./touch.ts";

/** Inputs in which a letter is no text. */
const NO_TEXT = new Set(["button", "checkbox", "color", "file", "radio", "range", "reset", "submit"]);

/** Does what a key stands for; `page`: what the page itself does. */
export function actOnKey(event: KeyboardEvent, model: Operator, page: (name: KeyAction) => void): void {
  // a key kept down would press the button that has the focus by now: Hold, after Return home
  if (event.repeat && event.key === "Enter" && event.target instanceof HTMLElement && event.target.tagName === "BUTTON") event.preventDefault();
  if (event.defaultPrevented || event.repeat || event.ctrlKey || event.metaKey || event.altKey || isTyping(event.target)) return;
  const name = KEYS.find((each) => each.key === event.key.toLowerCase())?.action;
  if (name === undefined) return;
  if (name === "keys" || name === "swap" || name === "survey") page(name);
  else actOn(model, name);
  event.preventDefault();
}

function actOn(model: Operator, name: KeyAction): void {
  const view = model.view();
  const { hold } = safetyActions(view);
  if (name === "hold") {
    if (hold.kind !== "impossible") startAction(model, hold);
    return;
  }
  if (model.cut.current || model.drawing) return; // what is asked there comes first
  const action: Action | undefined = guidedActions(view, isTouch()).find((each) => each.name === name);
  if (action?.kind === "possible") startAction(model, action);
}

/** Whether keys are text there. */
export function isTyping(target: EventTarget | null): boolean {
  if (!(target instanceof HTMLElement)) return false;
  if (target instanceof HTMLInputElement) return !NO_TEXT.has(target.type);
  return target.closest("textarea, select, [contenteditable]") !== null;
}
