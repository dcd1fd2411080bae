import { COMMAND_TABLE, type CommandButton, type SentBy } from "../command-table.ts";
import type { Command } from "../protocol.ts";
import { isFlying } from "../state/flight.ts";
import * as format from "./format.ts";
import { pointer, say } from "./say.ts";
import { isLotKnown, linkOf, option, type View } from "./view.ts";

/** Buttons of the bar. */
export type ActionName = Extract<CommandButton, "arm" | "takeoff" | "explore" | "move" | "home" | "land" | "hold" | "disarm" | "resume">;
export type ActionKind = "possible" | "running" | "impossible" | "failed";

export interface Action {
  name: ActionName;
  label: string;
  /** What it does, or why it cannot be done. */
  note: string;
  kind: ActionKind;
  /** 0 to 1, of a running one. */
  progress: number | null;
}

/** The command of each button that sends only one. */
export const COMMANDS = Object.fromEntries(Object.entries(COMMAND_TABLE).map(([type, { button }]) => [button, type])) as {
  [Name in Exclude<ActionName, "move">]: SentBy<Name>;
};

/** The guided actions, in the order of a flight. */
export function guidedActions(view: View, touch: boolean): Action[] {
  const first = view.heartbeat?.State === "Manual" ? resume(view) : armOrDisarm(view);
  return [first, takeoff(view), explore(view), move(view, touch), home(view)];
}

/** Land and Hold: in the same corner whatever happens. */
export function safetyActions(view: View): { land: Action; hold: Action } {
  return { land: land(view), hold: hold(view) };
}

export type Whose = "mine" | "free" | "lost" | "other" | "unknown";

/** Whether this operator commands the drone; Return home, Land and Cut motors are also free to all when nobody does or the one who does is lost. */
export function control(view: View): Whose {
  const heartbeat = view.heartbeat;
  if (!heartbeat || linkOf(view) !== "live") return "unknown";
  if (heartbeat["In Control"]) return "mine";
  if (heartbeat.Controller === null) return "free";
  return heartbeat["Controller Lost"] ? "lost" : "other";
}

/** Whether this page may only watch. */
export function isViewer(view: View): boolean {
  return view.welcome?.Role === "viewer";
}

/** What is said to a viewer. */
export function viewerWords(): { title: string; text: string } {
  return { title: say("viewer-title"), text: say("viewer-text") };
}

/** What is said of control to those who watch. */
export function watchingWords(view: View, whose: "free" | "lost" | "other"): { title: string; text: string } {
  if (whose === "free") return { title: say("free-title"), text: say("free-text") };
  if (whose === "lost") return { title: say("lost-title"), text: say("lost-text") };
  const taker = view.heartbeat?.["Control Taken By"] ?? null;
  if (taker !== null) return { title: say("other-has-control", { name: taker }), text: say("taken-text") };
  return { title: say("watching-title"), text: say("watching-text") };
}

/** Why a command would not be taken from this operator now; empty when it would. */
export function cannot(view: View, command: Command["Type"]): string {
  if (linkOf(view) !== "live") return say("no-link");
  if (isViewer(view)) return say("you-are-viewer");
  const offered = option(view, command);
  if (!offered.Possible) return offered.Reason.replace(/\.$/, "") || say("not-possible");
  return control(view) === "mine" ? "" : say("not-in-control");
}

function armOrDisarm(view: View): Action {
  if (option(view, "Disarm").Possible) return offered(view, "disarm", say("disarm"), say("disarm-note"));
  const failed = view.heartbeat?.Checks.filter((check) => !check.Passed).length ?? 0;
  const flying = view.heartbeat?.Armed === true;
  const checks = view.heartbeat?.Checks.length ?? 0;
  const action = offered(view, "arm", say("arm"), checks > 0 ? say("checks-passed", { checks }) : say("arm-note"));
  if (action.kind !== "impossible" || linkOf(view) !== "live") return action;
  if (flying) return { ...action, note: say("already-armed") };
  return failed > 0 ? { ...action, kind: "failed", note: say("checks-failed", { checks: failed }) } : action;
}

function resume(view: View): Action {
  return offered(view, "resume", say("resume"), say("resume-note"));
}

function takeoff(view: View): Action {
  const desired = view.heartbeat?.Heights[1];
  const note = desired === undefined ? say("takeoff-note") : say("takeoff-to", { height: format.height(desired, view.units) });
  const action = offered(view, "takeoff", say("takeoff"), note);
  if (view.selfDisarmed && action.kind === "impossible" && linkOf(view) === "live") return { ...action, note: say("takeoff-disarmed") };
  return view.heartbeat?.State === "Takeoff" ? running(view, action, climbProgress(view)) : action;
}

function explore(view: View): Action {
  const heartbeat = view.heartbeat;
  const action = offered(view, "explore", say("explore"), exploreNote(view));
  if (heartbeat?.State !== "Autonomous Explore") return action;
  return running(view, action, isLotKnown(heartbeat) ? heartbeat.Explored : null);
}

/** The flight over lots that are surveyed again is planned before it begins: its length is known. */
function exploreNote(view: View): string {
  const { "Again Distance": metres = null, "Survey Time Left": seconds = null, "Survey Batteries": batteries = null } = view.heartbeat ?? {};
  if (metres === null) return say("explore-note");
  const distance = format.distance(metres, view.units);
  if (seconds === null) return say("explore-again", { distance });
  const time = format.duration(seconds);
  return batteries === null || batteries < 2 ? say("explore-again-time", { distance, time }) : say("explore-again-batteries", { distance, time, batteries });
}

function move(view: View, touch: boolean): Action {
  const moves = [option(view, "Autonomous Move"), option(view, "Compulsive Move")];
  const possible = moves.some((each) => each.Possible);
  const reason = moves.find((each) => each.Reason !== "")?.Reason ?? "";
  const action = build(view, "move", say("move"), say("move-note", { pointer: pointer(touch) }), possible, reason);
  const moving = view.heartbeat?.State === "Autonomous Move" || view.heartbeat?.State === "Compulsive Move";
  return moving && action.kind === "possible" ? { ...action, kind: "running", note: say("move-running") } : action;
}

function home(view: View): Action {
  const action = offered(view, "home", say("home"), homeNote(view));
  if (view.heartbeat?.State === "Return To Launch") return running(view, action, null);
  if (linkOf(view) === "lost" && isFlying(view.heartbeat)) return { ...action, note: say("home-without-link") };
  return action;
}

function land(view: View): Action {
  const action = offered(view, "land", say("land"), say("land-note"));
  return view.heartbeat?.State === "Land" && action.kind !== "possible" ? { ...action, note: grounded(view) ?? say("land-running") } : action;
}

/** Hold is offered whenever there is an open socket and the drone is not on the ground. */
function hold(view: View): Action {
  const { Possible, Reason } = option(view, "Hold");
  const note = Possible || Reason === "" ? say("hold-note") : Reason.replace(/\.$/, "");
  const action = build(view, "hold", say("hold"), note, true, "");
  if (view.link !== "open" || !view.heartbeat) return { ...action, kind: "impossible", note: say("no-link") };
  const ground = grounded(view);
  return ground === null ? action : { ...action, kind: "impossible", note: ground };
}

function grounded(view: View): string | null {
  return isFlying(view.heartbeat) ? null : say("on-the-ground");
}

function offered(view: View, name: Exclude<ActionName, "move">, label: string, note: string): Action {
  const { Possible, Reason } = option(view, COMMANDS[name]);
  return build(view, name, label, note, Possible, Reason);
}

function build(view: View, name: ActionName, label: string, note: string, possible: boolean, reason: string): Action {
  const base = { name, label, progress: null };
  if (view.link !== "open" || linkOf(view) !== "live") return { ...base, kind: "impossible", note: say("no-link") };
  if (possible) return { ...base, kind: "possible", note };
  return { ...base, kind: "impossible", note: reason === "" ? say("not-possible") : reason.replace(/\.$/, "") };
}

function running(view: View, action: Action, progress: number | null): Action {
  if (linkOf(view) !== "live") return action;
  const note = progress === null ? say("running") : say("running-percent", { percent: format.percent(progress * 100) });
  return { ...action, kind: "running", note, progress };
}

function climbProgress(view: View): number | null {
  const height = view.heartbeat?.["Relative Altitude"] ?? null;
  const desired = view.heartbeat?.Heights[1] ?? 0;
  return height === null || desired <= 0 ? null : Math.min(1, Math.max(0, height / desired));
}

function homeNote(view: View): string {
  const { North, East, Home } = view.heartbeat ?? { North: null, East: null, Home: null };
  if (North === null || East === null || !Home) return say("home-note");
  const metres = Math.hypot(North - Home.North, East - Home.East);
  const distance = format.distance(metres, view.units);
  const time = view.heartbeat?.["Time Home"] ?? null;
  return time === null ? distance : say("home-distance", { distance, time: format.duration(time) });
}
