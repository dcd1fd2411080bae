import type { Heartbeat, Point } from "../protocol.ts";
import * as format from "./format.ts";
import { say } from "./say.ts";
import { metresOf, signedMetresOf, type Units } from "./units.ts";

/** What was typed for a move: how far north and east, and optionally the height above where it was armed. */
export interface TypedMove {
  north: string;
  east: string;
  height: string;
  /** From where the drone is (20.4.2 of the specification), or from where it was armed. */
  from: "drone" | "home";
}

export const NOTHING_TYPED: TypedMove = { north: "", east: "", height: "", from: "drone" };

export interface TypedPlace {
  target: Point;
  height?: number;
}

/** The place that was typed, or what is wrong with it in words. An empty field of north or east is 0, not both. */
export function typedPlace(heartbeat: Heartbeat | null, { north, east, height, from }: TypedMove, units: Units): TypedPlace | string {
  const home = heartbeat?.Home ?? null;
  const drone = heartbeat?.North == null || heartbeat.East === null ? null : { North: heartbeat.North, East: heartbeat.East };
  const origin = from === "home" ? home : drone;
  if (origin === null) return say(from === "home" ? "home-not-known" : "place-not-known");
  const [up, right] = [north, east].map((text) => (text.trim() === "" ? 0 : signedMetresOf(text, units)));
  if (up == null || right == null || (north.trim() === "" && east.trim() === "")) return say("move-no-number");
  const target = { North: origin.North + up, East: origin.East + right };
  if (height.trim() === "") return { target };
  const [lowest = 0, , highest = Infinity] = heartbeat?.Heights ?? [];
  const metres = metresOf(height, units);
  if (metres === null || metres < lowest || metres > highest) {
    return say("move-height-bounds", { lowest: format.height(lowest, units), highest: format.height(highest, units) });
  }
  return { target, height: metres };
}
