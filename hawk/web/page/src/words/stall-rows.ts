import type { Stall, StallState } from "../state/map-store.ts";
import * as format from "./format.ts";
import { capital, say } from "./say.ts";
import { stallWords } from "./stall.ts";
import type { Units } from "./units.ts";

export interface StallRow {
  id: number;
  label: string;
  state: string;
  place: string;
  seen: string;
}

const ORDER: StallState[] = ["free", "unknown", "taken", "suggested"];

/** Stalls as lines of a table, free ones first, then by their distance from home, `most` of them. `timeOf`: time of day of the drone's time. */
export function stallRows(
  stalls: Iterable<Stall>,
  home: { North: number; East: number } | null,
  timeOf: (at: number) => number | null,
  units: Units,
  most = Infinity,
): StallRow[] {
  const from = home ?? { North: 0, East: 0 };
  const away = (stall: Stall): number => Math.hypot(stall.north - from.North, stall.east - from.East);
  const sorted = [...stalls].sort((a, b) => rank(a) - rank(b) || away(a) - away(b) || a.id - b.id);
  return sorted.slice(0, most).map((stall) => ({
    id: stall.id,
    label: stall.label,
    state: capital(stallWords(stall.state)),
    place: say("from-home-by", {
      distance: format.distance(away(stall), units),
      to: format.direction(stall.north - from.North, stall.east - from.East),
    }),
    seen: seenAt(stall, timeOf),
  }));
}

function rank(stall: Stall): number {
  return ORDER.indexOf(stall.state);
}

function seenAt(stall: Stall, timeOf: (at: number) => number | null): string {
  const at = stall.lastSeen === null || stall.seen === 0 ? null : timeOf(stall.lastSeen);
  return at === null ? say("not-seen-itself") : format.clock(at);
}
