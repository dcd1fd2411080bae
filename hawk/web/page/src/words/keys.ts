import type { ActionName } from "./actions.ts";
import { say } from "./say.ts";

/** What a key does: an action of the bar, or something of the page. */
export type KeyAction = Extract<ActionName, "hold" | "arm" | "takeoff" | "explore" | "move" | "resume"> | "keys" | "swap" | "survey";

/** Keys of the page. Only Hold acts at once. The others ask first, and there is none for Land and Cut motors: a stray key must not end a flight. */
export const KEYS: { key: string; action: KeyAction }[] = [
  { key: "h", action: "hold" },
  { key: "a", action: "arm" },
  { key: "t", action: "takeoff" },
  { key: "e", action: "explore" },
  { key: "m", action: "move" },
  { key: "r", action: "resume" },
  { key: "v", action: "swap" },
  { key: "s", action: "survey" },
  { key: "?", action: "keys" },
];

/** Keys with what they do, for the list: the page's own, and those that every page has. */
export function keyRows(): [key: string, label: string][] {
  const own = KEYS.map(({ key, action }): [string, string] => [key.toUpperCase(), keyLabel(action)]);
  return [...own, [say("escape-key"), say("key-escape")], [say("tab-key"), say("key-tab")], [say("enter-key"), say("key-enter")]];
}

function keyLabel(action: KeyAction): string {
  switch (action) {
    case "arm":
    case "takeoff":
    case "explore":
      return say(action);
    default:
      return say(`key-${action}`);
  }
}
