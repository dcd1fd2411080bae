import type { Heartbeat, Point } from "../protocol.ts";
import { CELL } from "../state/tile-data.ts";
import * as format from "./format.ts";
import type { Units } from "./units.ts";
import { option, type View } from "./view.ts";

/** Inside the lot (the drone refuses other places), or anywhere inside the fence. */
export type MoveKind = "Autonomous Move" | "Compulsive Move";

export interface MovePlan {
  metres: number;
  seconds: number | null;
  question: string;
  /** How far, where to and how high: the question without its verb. */
  journey: string;
  /** Distance and time, for the pill beside the target. */
  pill: string;
  insideFence: boolean;
  /** Why the place is not inside; empty when it is. */
  outside: string;
  ways: { kind: MoveKind; label: string; possible: boolean; reason: string }[];
  suggested: MoveKind | null;
  /** Reason why the suggested kind is not possible; empty when it is. */
  refusal: string;
}

/** The route over the lot in words: its length, or the reason why there is none. */
export interface PlannedRoute {
  metres: number | null;
  reason: string;
}

const IN_ZONE = "In a zone or its margin";
const NO_ROUTE: PlannedRoute = { metres: null, reason: "" };

/** What a move to a place on the map would be; null while the drone's own place is not known. */
export function planMove(view: View, target: Point, cell: number, route: PlannedRoute = NO_ROUTE): MovePlan | null {
  const heartbeat = view.heartbeat;
  if (heartbeat?.North == null || heartbeat.East === null) return null;
  const north = target.North - heartbeat.North;
  const east = target.East - heartbeat.East;
  const metres = Math.hypot(north, east);
  const seconds = view.cruise === null ? null : metres / view.cruise;
  const outside = whyOutside(heartbeat, target);
  const insideFence = outside === "";
  const here = { North: heartbeat.North, East: heartbeat.East };
  const leaves = insideFence ? whyNotStraight(heartbeat, here, target) : "";
  const journey = `${format.distance(metres, view.units)} ${format.direction(north, east)}${staying(heartbeat, view.units)}`;
  const ways = [
    way(view, "Autonomous Move", "Inside the lot", outside, cell === CELL.nonLot ? "Not a place inside the lot" : route.reason.replace(/^X, Y: /, "")),
    way(view, "Compulsive Move", "Anywhere inside the fence", outside, leaves),
  ];
  const lot = cell === CELL.lot || cell === CELL.free || cell === CELL.taken;
  const order = lot ? ways : ways.toReversed();
  return {
    metres,
    seconds,
    question: `Move ${journey}?`,
    journey,
    pill: seconds === null ? format.distance(metres, view.units) : `${format.distance(metres, view.units)}, ${format.duration(seconds)}`,
    insideFence,
    outside,
    ways,
    suggested: order.find((each) => each.possible)?.kind ?? null,
    refusal: order.some((each) => each.possible) ? "" : (order[0]?.reason ?? ""),
  };
}

/** The second line of the confirm bar. */
export function consequence(view: View, plan: MovePlan, kind: MoveKind, route: PlannedRoute = NO_ROUTE): string {
  if (!plan.insideFence) return `${plan.outside}. Choose a place inside the dotted line${plan.outside === IN_ZONE ? " and out of zones" : ""}.`;
  const parts = plan.seconds === null ? [] : [`${format.duration(plan.seconds)}.`];
  const length = route.metres === null ? "" : `, ${format.distance(route.metres, view.units)} on the way`;
  parts.push(kind === "Autonomous Move" ? `Stays inside the lot${length}.` : "Inside the fence, lot or not.");
  if (view.heartbeat?.State === "Autonomous Explore") parts.push("Exploring stops.");
  return parts.join(" ");
}

function whyOutside(heartbeat: Heartbeat, target: Point): string {
  if (heartbeat.Fence.length >= 3 && !contains(heartbeat.Fence, target)) return "Outside the fence";
  return heartbeat["Fence Zones"].some((zone) => contains(zone, target)) ? IN_ZONE : "";
}

function whyNotStraight(heartbeat: Heartbeat, here: Point, target: Point): string {
  if (crosses(heartbeat.Fence, here, target)) return "The straight way there leaves the fence";
  return heartbeat["Fence Zones"].some((zone) => crosses(zone, here, target)) ? "The straight way there crosses a zone" : "";
}

function way(view: View, kind: MoveKind, label: string, outside: string, wrongPlace: string): MovePlan["ways"][number] {
  const offered = option(view, kind);
  const reason = outside !== "" ? outside : !offered.Possible ? offered.Reason : wrongPlace;
  return { kind, label, possible: outside === "" && offered.Possible && wrongPlace === "", reason };
}

/** Moves stay at the present height, but never below Min. */
function staying(heartbeat: Heartbeat, units: Units): string {
  const height = heartbeat["Relative Altitude"];
  const lowest = heartbeat.Heights[0];
  if (height === null) return "";
  if (height < lowest - 0.5) return `, climbing to ${format.height(lowest, units)}`;
  return `, staying at ${format.height(height, units)}`;
}

/** Even-odd rule. */
export function contains(polygon: readonly Point[], place: Point): boolean {
  let inside = false;
  let previous = polygon.at(-1);
  for (const corner of polygon) {
    if (previous && corner.North > place.North !== previous.North > place.North) {
      const share = (place.North - corner.North) / (previous.North - corner.North);
      if (place.East < corner.East + share * (previous.East - corner.East)) inside = !inside;
    }
    previous = corner;
  }
  return inside;
}

/** True when the straight line between two places crosses a side of the polygon. */
export function crosses(polygon: readonly Point[], from: Point, to: Point): boolean {
  return polygon.some((corner, index) => {
    const next = polygon[(index + 1) % polygon.length] ?? corner;
    const apart = side(from, to, corner) * side(from, to, next) < 0;
    return apart && side(corner, next, from) * side(corner, next, to) < 0;
  });
}

/** Above 0 on one side of the line, below on the other. */
function side(from: Point, to: Point, place: Point): number {
  return (to.North - from.North) * (place.East - from.East) - (to.East - from.East) * (place.North - from.North);
}
