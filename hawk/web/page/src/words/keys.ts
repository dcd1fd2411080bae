import type { ActionName } from "./actions.ts";
import { say } from "./say.ts";

/** What a key does: an action of the bar, or something of the page. */
export type KeyDeed = Extract<ActionName, "hold" | "arm" | "takeoff" | "explore" | "move" | "resume"> | "keys" | "swap" | "survey";

/** Keys of the page. Only Hold acts at once. The others ask first, and there is none for Land and Cut motors: a stray key must not end a flight. */
export const KEYS: { key: string; deed: KeyDeed }[] = [
  { key: "h", deed: "hold" },
  { key: "a", deed: "arm" },
  { key: "t", deed: "takeoff" },
  { key: "e", deed: "explore" },
  { key: "m", deed: "move" },
  { key: "r", deed: "resume" },
  { key: "v", deed: "swap" },
  { key: "s", deed: "survey" },
  { key: "?", deed: "keys" },
];

/** Keys with what they do, for the list: the page's own, and those that every page has. */
export function keyRows(): [key: string, label: string][] {
  const own = KEYS.map(({ key, deed }): [string, string] => [key.toUpperCase(), keyLabel(deed)]);
  return [...own, [say("escape-key"), say("key-escape")], [say("tab-key"), say("key-tab")], [say("enter-key"), say("key-enter")]];
}

function keyLabel(deed: KeyDeed): string {
  switch (deed) {
    case "arm":
    case "takeoff":
    case "explore":
      return say(deed);
    default:
      return say(`key-${deed}`);
  }
}
