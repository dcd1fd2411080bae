import { isFlying } from "../state/flight.ts";
import type { Heartbeat } from "../protocol.ts";
import * as format from "./format.ts";
import { say } from "./say.ts";
import { linkOf, type View } from "./view.ts";

/** What this page asks or reports about control, beside the bar. */
export interface ControlNote {
  kind: "asked" | "asking" | "free" | "releasing" | "changed";
  title: string;
  text: string;
}

/** The question about a plan of the lot that somebody changed in flight; null without one, and for those who watch. `left`: the id of the one that this operator leaves. */
export function offerNote(view: View, left: string | null): ControlNote | null {
  const heartbeat = view.heartbeat;
  const offer = heartbeat?.["Plan Offer"] ?? null;
  if (offer === null || heartbeat?.["In Control"] !== true || linkOf(view) !== "live" || offer.Plan === left) return null;
  const { By: name, Lot: lot, Before: before, Stalls: stalls } = offer;
  return { kind: "changed", title: say("plan-changed", { name: name ?? say("plan-nameless"), lot }), text: `${say("lot-stalls", { stalls: before })} → ${say("lot-stalls", { stalls })}` };
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
  const name = heartbeat.Controller;
  if (left > 0) {
    const title = name === null ? say("free-title") : say("was-asked", { name });
    return { kind: "asking", title, text: say("you-can-take-in", { time: seconds(left) }) };
  }
  const title = name === null ? say("free-title") : say("does-not-answer", { name });
  return { kind: "free", title, text: say("you-can-take-now") };
}

function asked(asker: string, left: number): ControlNote {
  const name = asker;
  const text = left > 0 ? say("other-can-take-in", { name, time: seconds(left) }) : say("other-can-take-now", { name });
  return { kind: "asked", title: say("asks-for-control", { name }), text };
}

function release(view: View): ControlNote {
  const time = view.welcome && format.duration(view.welcome["Operator Hold"] / view.welcome.Speed);
  const text = time === null ? say("release-text") : say("release-text-for", { time });
  return { kind: "releasing", title: say("release-title"), text };
}

/** Never rounded down to 0 while there is time left. */
function seconds(left: number): string {
  return format.wholeSeconds(Math.ceil(left));
}

/** What somebody else made the drone do between two heartbeats, in a sentence; null when nobody else did. */
export function doneByAnother(before: Heartbeat | null, now: Heartbeat): string | null {
  const by = now["Asked By"];
  if (!before || by === null || by === now["Own Name"]) return null;
  if (before.State === now.State && before["Asked By"] === by) return null;
  switch (now.State) {
    case "Hover":
      return say("stopped-by", { name: by });
    case "Return To Launch":
      return say("returning-by", { name: by });
    case "Land":
      return say("landing-by", { name: by });
    default:
      return null;
  }
}
