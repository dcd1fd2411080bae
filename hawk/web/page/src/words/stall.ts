import { isFlying } from "../state/flight.ts";
import type { Stall, StallState } from "../state/map-store.ts";
import { cannot, control } from "./actions.ts";
import * as format from "./format.ts";
import type { View } from "./view.ts";

/** Seen in this number of pictures or more, a stall is known well. */
const OFTEN = 10;
/** From these probabilities on a stall is almost surely, or probably, free or taken. */
export const ALMOST_SURE = 0.9;
export const PROBABLE = 0.6;

export const STALL_WORDS: Record<StallState, string> = { free: "free", taken: "taken", unknown: "unclear" };

/** How sure it is that a stall is free or taken, in words. */
export function likelihood({ state, taken }: Pick<Stall, "state" | "taken">): string {
  if (taken === null) return STALL_WORDS[state];
  const free = state === "free" || (state === "unknown" && taken < 0.5);
  const sure = free ? 1 - taken : taken;
  const word = STALL_WORDS[free ? "free" : "taken"];
  if (state === "unknown") return sure >= PROBABLE ? `unclear, probably ${word}` : "unclear";
  return sure >= ALMOST_SURE ? `almost surely ${word}` : `probably ${word}`;
}

/** When a stall was seen, and that it was seen seldom. */
export function stallDetail(stall: Stall, lastSeenAt: number | null): string {
  const times = seenWords(stall.seen);
  const last = lastSeenAt === null || stall.seen === 0 ? "" : `${times === "" ? "Last seen" : "last"} at ${format.clock(lastSeenAt)}`;
  const seen = [times, last].filter((part) => part !== "").join(", ");
  return seen === "" ? "" : `${seen}.`;
}

/** Why the drone cannot be sent to look at a stall again; empty when it can; null where that is not offered at all. */
export function lookAgain(view: View): string | null {
  return isFlying(view.heartbeat) && control(view) === "mine" ? cannot(view, "Autonomous Move") : null;
}

/** The number of pictures, for a stall that was seen seldom. */
function seenWords(pictures: number | null): string {
  if (pictures === null || pictures >= OFTEN) return "";
  if (pictures === 0) return "Not seen itself, found from its row";
  return `Seen in ${format.count(pictures, "picture", "pictures")} only`;
}
