import type { Stall } from "../state/map-store.ts";
import * as format from "./format.ts";
import type { Units } from "./units.ts";

export interface StallRow {
  id: number;
  state: string;
  place: string;
  seen: string;
}

const WORDS = { free: "Free", taken: "Taken", unknown: "Unclear" };

/** Stalls as lines of a table, free ones first, then by their distance from home. `timeOf`: time of day of the drone's time. */
export function stallRows(stalls: Iterable<Stall>, home: { North: number; East: number } | null, timeOf: (at: number) => number, units: Units): StallRow[] {
  const from = home ?? { North: 0, East: 0 };
  const away = (stall: Stall): number => Math.hypot(stall.north - from.North, stall.east - from.East);
  const sorted = [...stalls].sort((a, b) => rank(a) - rank(b) || away(a) - away(b) || a.id - b.id);
  return sorted.map((stall) => ({
    id: stall.id,
    state: WORDS[stall.state],
    place: `${format.distance(away(stall), units)} ${direction(stall.north - from.North, stall.east - from.East)} of home`,
    seen: stall.lastSeen === null || stall.seen === 0 ? "not seen itself" : format.clock(timeOf(stall.lastSeen)),
  }));
}

function rank(stall: Stall): number {
  return ["free", "unknown", "taken"].indexOf(stall.state);
}

const DIRECTIONS = ["north", "north-east", "east", "south-east", "south", "south-west", "west", "north-west"];

function direction(north: number, east: number): string {
  const eighth = Math.round((Math.atan2(east, north) / Math.PI) * 4);
  return DIRECTIONS[(eighth + 8) % 8] ?? "north";
}
