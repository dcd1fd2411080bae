import { isFlying } from "../state/flight.ts";
import type { Stall, StallState } from "../state/map-store.ts";
import { cannot, control } from "./actions.ts";
import * as format from "./format.ts";
import { say } from "./say.ts";
import type { View } from "./view.ts";

/** Seen in this number of pictures or more, a stall is known well. */
const OFTEN = 10;
/** From these probabilities on a stall is almost surely, or probably, free or taken. */
export const ALMOST_SURE = 0.9;
export const PROBABLE = 0.6;

export function stallWords(state: StallState): string {
  return say(state);
}

/** How sure it is that a stall is free or taken, in words. */
export function likelihood({ state, taken }: Pick<Stall, "state" | "taken">): string {
  if (taken === null || state === "suggested") return stallWords(state);
  const free = state === "free" || (state === "unknown" && taken < 0.5);
  const sure = free ? 1 - taken : taken;
  const kind = free ? "free" : "taken";
  if (state === "unknown") return sure >= PROBABLE ? say(`unclear-probably-${kind}`) : stallWords(state);
  return sure >= ALMOST_SURE ? say(`almost-surely-${kind}`) : say(`probably-${kind}`);
}

/** When a stall was seen, and that it was seen seldom. */
export function stallDetail(stall: Stall, lastSeenAt: number | null): string {
  const { seen: pictures } = stall;
  const time = lastSeenAt === null ? null : format.clock(lastSeenAt);
  if (stall.state === "suggested") return say("stood-in", { passes: pictures ?? 0 });
  if (pictures === 0) return say("not-seen-from-row");
  if (pictures !== null && pictures < OFTEN) return time === null ? say("seen-in", { pictures }) : say("seen-in-last", { pictures, time });
  return time === null ? "" : say("last-seen", { time });
}

/** Why the drone cannot be sent to look at a stall again; empty when it can; null where that is not offered at all. */
export function lookAgain(view: View): string | null {
  return isFlying(view.heartbeat) && control(view) === "mine" ? cannot(view, "Autonomous Move") : null;
}
