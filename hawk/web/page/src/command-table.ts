// Written by packaging/page_protocol.py from hawk/comm/protocol/command_table.py: change that and run this again.

import type { Messages } from "./messages/keys.ts";
import type { Command } from "./protocol.ts";

/** What the page must know of a command. */
export interface CommandRow {
  /** Key of the label of the button that sends it; null where there is none. */
  button: keyof Messages | null;
  /** How it is confirmed on the page; "overruling": by a slide while somebody else flies, and sent as confirmed. */
  confirm: "never" | "slide" | "overruling" | "two_steps";
}

export const COMMAND_TABLE = {
  Configure: { button: "change-heights", confirm: "never" },
  Arm: { button: "arm", confirm: "slide" },
  Takeoff: { button: "takeoff", confirm: "slide" },
  "Autonomous Explore": { button: "explore", confirm: "slide" },
  "Autonomous Move": { button: "move", confirm: "slide" },
  "Compulsive Move": { button: "move", confirm: "slide" },
  Hold: { button: "hold", confirm: "never" },
  "Return To Launch": { button: "home", confirm: "overruling" },
  Land: { button: "land", confirm: "overruling" },
  Disarm: { button: "disarm", confirm: "never" },
  Resume: { button: "resume", confirm: "overruling" },
  "Kill Request": { button: "cut-motors", confirm: "never" },
  Kill: { button: "cut-press", confirm: "two_steps" },
  "Clear Kill": { button: "remedy-kill", confirm: "never" },
  "Set Failsafes": { button: "remedy-failsafes", confirm: "never" },
  "Set Fence": { button: "save-fence", confirm: "never" },
  "Clear Fence": { button: "set-aside-label", confirm: "never" },
  "Set Outline": { button: "set-outline", confirm: "never" },
  "Clear Outline": { button: "remove-outline", confirm: "never" },
  "Survey Again": { button: "survey-again", confirm: "never" },
  "Fly Plan": { button: "fly-plan", confirm: "never" },
  "New Survey": { button: "new-survey", confirm: "slide" },
  "Route Request": { button: null, confirm: "never" },
  "Check Fence": { button: null, confirm: "never" },
  Name: { button: "save", confirm: "never" },
  Control: { button: "take-control", confirm: "never" },
  Heartbeat: { button: null, confirm: "never" },
  "Map Resync": { button: null, confirm: "never" },
} as const satisfies Record<Command["Type"], CommandRow>;

type Table = typeof COMMAND_TABLE;

/** Labels of the buttons that send commands. */
export type CommandButton = Exclude<Table[keyof Table]["button"], null>;

/** The commands that a button sends. */
export type SentBy<Button extends CommandButton> = {
  [T in keyof Table]: Table[T]["button"] extends Button ? T : never;
}[keyof Table];

/** The commands that a slide confirms. */
export type Slid = {
  [T in keyof Table]: Table[T]["confirm"] extends "slide" | "overruling" ? T : never;
}[keyof Table];
