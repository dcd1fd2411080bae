import { isFlying } from "../state/flight.ts";
import type { Heartbeat } from "../protocol.ts";
import * as format from "./format.ts";
import { linkOf, type View } from "./view.ts";

/** What this page asks or reports about control, beside the bar. */
export interface ControlNote {
  kind: "asked" | "asking" | "free" | "releasing";
  title: string;
  text: string;
}

/** Seconds of this page until the one who asks may take control; null while nobody asks. */
export function freeIn(view: View): number | null {
  const left = view.heartbeat?.["Control Free In"] ?? null;
  return left === null ? null : Math.max(0, left / (view.welcome?.Speed ?? 1) - (view.silence ?? 0));
}

/** The question for control as this page shows it; null when there is none. `releasing`: this operator wants to give control back. */
export function controlNote(view: View, releasing: boolean): ControlNote | null {
  const heartbeat = view.heartbeat;
  if (!heartbeat || linkOf(view) !== "live") return null;
  const asker = heartbeat["Control Asked By"];
  const left = freeIn(view);
  if (heartbeat["In Control"]) {
    if (asker !== null && left !== null) return asked(asker, left);
    return releasing && isFlying(heartbeat) ? release(view) : null;
  }
  if (asker === null || left === null || asker !== heartbeat["Own Name"]) return null;
  const title = `${heartbeat.Controller ?? "Nobody"} was asked for control.`;
  if (left > 0) return { kind: "asking", title, text: `Without an answer you can take control in ${seconds(left)}.` };
  return { kind: "free", title: `${heartbeat.Controller ?? "Nobody"} does not answer.`, text: "You can take control. The drone goes on with what it does." };
}

function asked(asker: string, left: number): ControlNote {
  const text = left > 0 ? `Without an answer ${asker} can take control in ${seconds(left)}.` : `Without an answer ${asker} can take control now.`;
  return { kind: "asked", title: `${asker} asks for control.`, text };
}

function release(view: View): ControlNote {
  const hold = view.welcome ? ` for ${format.duration(view.welcome["Operator Hold"] / view.welcome.Speed)}` : "";
  const text = `It stops and holds${hold}, then returns home and lands, unless somebody takes control.`;
  return { kind: "releasing", title: "Give back control in the air?", text };
}

/** Never rounded down to 0 while there is time left. */
function seconds(left: number): string {
  return `${Math.ceil(left)} s`;
}

/** What somebody else made the drone do between two heartbeats, in a sentence; null when nobody else did. */
export function doneByAnother(before: Heartbeat | null, now: Heartbeat): string | null {
  const by = now["Asked By"];
  if (!before || by === null || by === now["Own Name"]) return null;
  if (before.State === now.State && before["Asked By"] === by) return null;
  const words: Record<string, string> = {
    Hover: `Stopped by ${by}.`,
    "Return To Launch": `Returning home, asked by ${by}.`,
    Land: `Landing, asked by ${by}.`,
  };
  return words[now.State] ?? null;
}
