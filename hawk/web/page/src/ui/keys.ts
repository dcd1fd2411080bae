import type { Operator } from "../state/operator.ts";
import { type Action, guidedActions, safetyActions } from "../words/actions.ts";
import { KEYS, type KeyDeed } from "../words/keys.ts";
import { begin } from "./start-action.ts";
import { isTouch } from "./touch.ts";

/** Inputs in which a letter is no text. */
const NO_TEXT = new Set(["button", "checkbox", "color", "file", "radio", "range", "reset", "submit"]);

/** Does what a key stands for; `page`: what the page itself does. */
export function actOnKey(event: KeyboardEvent, model: Operator, page: (deed: KeyDeed) => void): void {
  if (event.defaultPrevented || event.repeat || event.ctrlKey || event.metaKey || event.altKey || isTyping(event.target)) return;
  const deed = KEYS.find((each) => each.key === event.key.toLowerCase())?.deed;
  if (deed === undefined) return;
  if (deed === "keys" || deed === "swap" || deed === "survey") page(deed);
  else actOn(model, deed);
  event.preventDefault();
}

function actOn(model: Operator, deed: KeyDeed): void {
  const view = model.view();
  const { hold } = safetyActions(view);
  if (deed === "hold") {
    if (hold.kind !== "impossible") begin(model, hold);
    return;
  }
  if (model.cut.current || model.drawing) return; // what is asked there comes first
  const action: Action | undefined = guidedActions(view, isTouch()).find((each) => each.name === deed);
  if (action?.kind === "possible") begin(model, action);
}

function isTyping(target: EventTarget | null): boolean {
  if (!(target instanceof HTMLElement)) return false;
  if (target instanceof HTMLInputElement) return !NO_TEXT.has(target.type);
  return target.closest("textarea, select, [contenteditable]") !== null;
}
