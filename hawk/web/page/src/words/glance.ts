import type { Heartbeat } from "../protocol.ts";
import * as format from "./format.ts";
import { ageNow, autopilotLost, BATTERY_STALE_S, linkOf, OLD_S, oldestAge, STALE_S, type View } from "./view.ts";

export type Tone = "fine" | "warn" | "idle";

export interface StateWords {
  tone: Tone;
  title: string;
  detail: string;
  /** The same for a narrow page. */
  short: string;
}

export interface GlanceValue {
  name: "free" | "battery" | "height" | "link";
  value: string;
  /** Set when the value is old: "6 s old". */
  age: string;
  label: string;
  /** What stands behind the age of an old value. */
  staleLabel: string;
  trouble: boolean;
}

const TITLES: Record<string, string> = {
  Idle: "On the ground",
  Configure: "Storing heights",
  Arm: "Arming",
  Takeoff: "Taking off",
  Hover: "Holding",
  "Autonomous Explore": "Exploring",
  "Autonomous Move": "Moving",
  "Compulsive Move": "Moving",
  "Return To Launch": "Returning home",
  Land: "Landing",
  CommunicationLost: "Operator lost",
  Manual: "Flown by hand",
};

/** A state in the words of the page. */
export function stateTitle(state: string): string {
  return TITLES[state] ?? state;
}

/** Per cent seen of the lot found so far, which grows with the survey; null when it is not known, as it is when stalls were found and yet nothing counts as seen. */
export function seenPercent(heartbeat: Heartbeat): number | null {
  const share = heartbeat.Explored;
  if (share === null || (share === 0 && heartbeat.State !== "Autonomous Explore")) return null;
  return Math.round(share * 100);
}

export function stateWords(view: View): StateWords {
  const heartbeat = view.heartbeat;
  if (!heartbeat) return same("warn", "Not connected", view.link === "open" ? "Waiting for the drone" : "Looking for the drone");
  if (linkOf(view) === "lost") {
    const was = stateTitle(heartbeat.State).toLowerCase();
    return same("warn", "No link", `was ${was} ${format.age(view.silence ?? 0)} ago`);
  }
  if (autopilotLost(view)) return same("warn", "Autopilot silent", "The drone's computer does not hear it");
  if (heartbeat["Kill State"] === "sending") return same("warn", "Cutting motors", "Sent until the motors are off");
  if (heartbeat["Kill State"] === "not confirmed") return same("warn", "Cut not confirmed", "The motors may still run");
  return heartbeat.State === "Idle" ? grounded(view, heartbeat) : active(view, heartbeat);
}

/** Control was given back in the air, or ran out, and nobody has taken it: nobody is lost. */
export function isGivenBack(heartbeat: Heartbeat): boolean {
  return heartbeat.State === "CommunicationLost" && heartbeat.Controller === null;
}

function grounded(view: View, heartbeat: Heartbeat): StateWords {
  if (heartbeat.Killed) return same("warn", "Motors cut", "Clear it to arm again");
  const failed = heartbeat.Checks.filter((check) => !check.Passed).length;
  if (failed > 0) {
    const short = `${format.count(failed, "check", "checks")} failed`;
    return { tone: "warn", title: TITLES.Idle ?? "", detail: `${short}. Fix ${failed === 1 ? "it" : "them"} to arm.`, short };
  }
  if (view.landedAt !== null) return same("idle", "Landed", `Motors off since ${format.clock(view.landedAt)}`);
  const passed = heartbeat.Checks.length;
  return same(toned(view, heartbeat, "idle"), TITLES.Idle ?? "", passed > 0 ? `${passed} checks passed` : heartbeat.Detail);
}

function active(view: View, heartbeat: Heartbeat): StateWords {
  const tone = toned(view, heartbeat, "fine");
  const armed = heartbeat.State === "Arm" && heartbeat.Armed === true;
  const title = armed ? "Armed" : isGivenBack(heartbeat) ? "Nobody has control" : stateTitle(heartbeat.State);
  const seen = seenPercent(heartbeat);
  if (heartbeat.State !== "Autonomous Explore" || seen === null) return same(tone, title, `${heartbeat.Detail}${oldPicture(view)}`);
  const toGo = timeToGo(view, heartbeat);
  return {
    tone,
    title,
    detail: `${seen} % seen of the lot found so far${toGo ? `, about ${toGo} to go` : ""}${oldPicture(view)}`,
    short: `${seen} % seen so far${toGo ? `, ${toGo} to go` : ""}${oldPicture(view)}`,
  };
}

function oldPicture(view: View): string {
  const age = view.pictureAge;
  return age !== null && age > OLD_S ? ` Picture ${format.age(age)} old.` : "";
}

/** How long the rest takes; null while no route is planned or the drone's speed is not known. */
function timeToGo(view: View, heartbeat: Heartbeat): string | null {
  const left = heartbeat.Remaining;
  if (left === null || view.cruise === null) return null;
  const seconds = left / view.cruise;
  return seconds < 1 ? null : format.duration(seconds);
}

/** Trouble turns any mark into the triangle. */
function toned(view: View, heartbeat: Heartbeat, otherwise: Tone): Tone {
  if (oldestAge(view) > OLD_S) return "warn";
  const attention = heartbeat.State === "CommunicationLost" || heartbeat.State === "Manual";
  return attention || heartbeat["Health Status"] !== 0 || heartbeat["User Error"] !== 0 ? "warn" : otherwise;
}

function same(tone: Tone, title: string, detail: string): StateWords {
  return { tone, title, detail, short: detail };
}

export function glanceValues(view: View): GlanceValue[] {
  return [freeValue(view), batteryValue(view), heightValue(view), linkValue(view)];
}

function freeValue(view: View): GlanceValue {
  const heartbeat = view.heartbeat;
  const known = heartbeat !== null && heartbeat.Free + heartbeat.Taken + heartbeat.Unknown > 0;
  const lost = linkOf(view) === "lost" && view.silence !== null;
  const label = lost && known ? `free, at ${format.clock(view.now - (view.silence ?? 0) * 1000)}` : "free stalls";
  return { name: "free", value: known ? String(heartbeat.Free) : "–", age: "", label, staleLabel: "", trouble: false };
}

function batteryValue(view: View): GlanceValue {
  const level = view.heartbeat?.["Battery Percentage"] ?? null;
  const left = view.heartbeat?.["Battery Time Left"] ?? null;
  const old = oldAge(ageNow(view, view.heartbeat?.["Battery Age"] ?? null), BATTERY_STALE_S);
  const value = left !== null ? format.timeLeft(left) : format.percent(level);
  const label = left !== null && level !== null ? `battery, ${format.percent(level)}` : "battery";
  return { name: "battery", value, age: level === null ? "" : old, label, staleLabel: left === null ? "" : `, ${format.percent(level)}`, trouble: false };
}

function heightValue(view: View): GlanceValue {
  const metres = view.heartbeat?.["Relative Altitude"] ?? null;
  const old = oldAge(ageNow(view, view.heartbeat?.["Pose Age"] ?? null), STALE_S);
  return { name: "height", value: format.height(metres, view.units), age: metres === null ? "" : old, label: "height", staleLabel: "", trouble: false };
}

function linkValue(view: View): GlanceValue {
  const base = { name: "link" as const, age: "", staleLabel: "" };
  if (linkOf(view) === "never") return { ...base, value: "–", label: "no link", trouble: true };
  const silence = view.silence ?? 0;
  if (linkOf(view) === "lost") return { ...base, value: format.age(silence), label: "link lost", trouble: true };
  const vehicle = ageNow(view, view.heartbeat?.["Link Age"] ?? null) ?? silence;
  const worst = Math.max(silence, autopilotLost(view) ? vehicle : Math.min(vehicle, 1));
  if (autopilotLost(view)) return { ...base, value: format.age(worst), label: "autopilot silent", trouble: true };
  if (vehicle > OLD_S) return { ...base, value: format.age(vehicle), label: "autopilot, slow", trouble: true };
  return { ...base, value: format.age(Math.max(silence, view.gap)), label: silence > STALE_S ? "link, slow" : "link, good", trouble: silence > STALE_S };
}

function oldAge(seconds: number | null, limit: number): string {
  return seconds !== null && seconds > limit ? `${format.age(seconds)} old` : "";
}
