import type { ActionName } from "./actions.ts";

/** What a key does: an action of the bar, or something of the page. */
export type KeyDeed = Extract<ActionName, "hold" | "arm" | "takeoff" | "explore" | "move" | "resume"> | "keys" | "swap" | "survey";

export interface KeyWords {
  key: string;
  deed: KeyDeed;
  label: string;
}

/** Only Hold acts at once. The others ask first, and there is none for Land and Cut motors: a stray key must not end a flight. */
export const KEYS: KeyWords[] = [
  { key: "h", deed: "hold", label: "Hold: stop and stay, at once" },
  { key: "a", deed: "arm", label: "Arm" },
  { key: "t", deed: "takeoff", label: "Take off" },
  { key: "e", deed: "explore", label: "Explore" },
  { key: "m", deed: "move", label: "Move: then click the map" },
  { key: "r", deed: "resume", label: "Resume after a pilot flew" },
  { key: "v", deed: "swap", label: "Video large, map small, and back" },
  { key: "s", deed: "survey", label: "Show the survey" },
  { key: "?", deed: "keys", label: "Show these keys" },
];

/** Keys that every page has, for the list. */
export const OTHER_KEYS: [string, string][] = [
  ["Esc", "Leave what is asked"],
  ["Tab", "To the next button"],
  ["Enter", "Press it; kept pressed on a slide: slide it"],
];
