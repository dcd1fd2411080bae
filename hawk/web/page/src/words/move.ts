import type { SentBy } from "../command-table.ts";
import type { Heartbeat, Point } from "../protocol.ts";
import { CELL } from "../state/tile-data.ts";
import * as format from "./format.ts";
import { say, sentences } from "./say.ts";
import type { Units } from "./units.ts";
import { option, type View } from "./view.ts";

/** Inside the lot (the drone refuses other places), or anywhere inside the fence. */
export type MoveKind = SentBy<"move">;

/** A kind of move as the bar offers it; `reason`: why it is not possible. */
export interface MoveChoice {
  kind: MoveKind;
  label: string;
  possible: boolean;
  reason: string;
}

export interface MovePlan {
  metres: number;
  seconds: number | null;
  /** Per cent of a full battery that flying there takes; null while it is not known. */
  battery: number | null;
  question: string;
  /** The same in a sentence, when a stall is looked at again. */
  flown: string;
  /** Distance and time, for the pill beside the target. */
  pill: string;
  insideFence: boolean;
  /** Why the place is not inside; empty when it is. */
  outside: string;
  /** What to choose in its place; empty when it is inside. */
  choose: string;
  choices: MoveChoice[];
  suggested: MoveKind | null;
  /** Reason why the suggested kind is not possible; empty when it is. */
  refusal: string;
}

/** The route over the lot in words: its length, or the reason why there is none. */
export interface PlannedRoute {
  metres: number | null;
  reason: string;
}

const NO_ROUTE: PlannedRoute = { metres: null, reason: "" };

/** What a move to a place on the map would be; null while the drone's own place is not known. */
export function planMove(view: View, target: Point, cell: number, route: PlannedRoute = NO_ROUTE, height?: number): MovePlan | null {
  const heartbeat = view.heartbeat;
  if (heartbeat?.North == null || heartbeat.East === null) return null;
  const north = target.North - heartbeat.North;
  const east = target.East - heartbeat.East;
  const metres = Math.hypot(north, east);
  const speed = view.welcome?.["Travel Speed"];
  const seconds = speed === undefined ? null : metres / speed;
  const inside = whereInside(heartbeat, target);
  const insideFence = inside === "inside";
  const outside = insideFence ? "" : say(inside);
  const here = { North: heartbeat.North, East: heartbeat.East };
  const leaves = insideFence ? whyNotStraight(heartbeat, here, target) : "";
  const distance = format.distance(metres, view.units);
  const journey = { distance, to: format.direction(north, east), ...staying(heartbeat, view.units, height) };
  const onlyStraight = height === undefined ? "" : say("move-height-straight");
  const choices = [
    choice(view, "Autonomous Move", say("inside-lot"), outside, onlyStraight !== "" ? onlyStraight : cell === CELL.nonLot ? say("no-place-in-lot") : route.reason.replace(/^X, Y: /, "")),
    choice(view, "Compulsive Move", say("inside-fence"), outside, leaves),
  ];
  const lot = cell === CELL.lot || cell === CELL.free || cell === CELL.taken;
  const order = lot ? choices : choices.toReversed();
  return {
    metres,
    seconds,
    battery: batteryCost(heartbeat, seconds),
    question: say("move-question", journey),
    flown: say("look-again-line", journey),
    pill: seconds === null ? distance : say("move-pill", { distance, time: format.duration(seconds) }),
    insideFence,
    outside,
    choose: insideFence ? "" : say(inside === "in-zone" ? "choose-out-of-zone" : "choose-inside"),
    choices,
    suggested: order.find((each) => each.possible)?.kind ?? null,
    refusal: order.some((each) => each.possible) ? "" : (order[0]?.reason ?? ""),
  };
}

/** The second line of the confirm bar. */
export function consequence(view: View, plan: MovePlan, kind: MoveKind, route: PlannedRoute = NO_ROUTE): string {
  if (!plan.insideFence) return plan.choose;
  const time = plan.seconds === null ? "" : takes(format.duration(plan.seconds), plan.battery);
  const stops = view.heartbeat?.State === "Autonomous Explore" ? say("exploring-stops") : "";
  return sentences(time, kind === "Autonomous Move" ? staysInLot(view, route) : say("stays-in-fence"), stops);
}

function takes(time: string, battery: number | null): string {
  return battery === null ? say("takes", { time }) : say("takes-battery", { time, percent: format.percent(battery) });
}

/** Per cent of a full battery for seconds of flight, by the drain that the drone's own time left is computed with; never rounded down. */
function batteryCost(heartbeat: Heartbeat, seconds: number | null): number | null {
  const { "Battery Percentage": charge, "Battery Needed Home": home, "Battery Time Left": left } = heartbeat;
  if (seconds === null || charge === null || home === null || left === null || left < 1 || charge <= home) return null;
  return Math.max(1, Math.ceil(((charge - home) / left) * seconds));
}

function staysInLot(view: View, { metres }: PlannedRoute): string {
  return metres === null ? say("stays-in-lot") : say("stays-in-lot-distance", { distance: format.distance(metres, view.units) });
}

function whereInside(heartbeat: Heartbeat, target: Point): "inside" | "outside-fence" | "in-zone" {
  if (heartbeat.Fence.length >= 3 && !contains(heartbeat.Fence, target)) return "outside-fence";
  return heartbeat["Fence Zones"].some((zone) => contains(zone, target)) ? "in-zone" : "inside";
}

function whyNotStraight(heartbeat: Heartbeat, here: Point, target: Point): string {
  if (crosses(heartbeat.Fence, here, target)) return say("leaves-fence");
  return heartbeat["Fence Zones"].some((zone) => crosses(zone, here, target)) ? say("crosses-zone") : "";
}

function choice(view: View, kind: MoveKind, label: string, outside: string, wrongPlace: string): MoveChoice {
  const offered = option(view, kind);
  const reason = outside !== "" ? outside : !offered.Possible ? offered.Reason : wrongPlace;
  return { kind, label, possible: outside === "" && offered.Possible && wrongPlace === "", reason };
}

/** Moves stay at the present height, but never below Min, unless a height is asked for. */
function staying(heartbeat: Heartbeat, units: Units, asked?: number): { then: "climbing" | "sinking" | "staying" | "unknown"; height: string } {
  const height = heartbeat["Relative Altitude"];
  if (asked !== undefined) {
    const then = height === null || Math.abs(asked - height) < 0.5 ? "staying" : asked > height ? "climbing" : "sinking";
    return { then, height: format.height(asked, units) };
  }
  const lowest = heartbeat.Heights[0];
  if (height === null) return { then: "unknown", height: "" };
  if (height < lowest - 0.5) return { then: "climbing", height: format.height(lowest, units) };
  return { then: "staying", height: format.height(height, units) };
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
