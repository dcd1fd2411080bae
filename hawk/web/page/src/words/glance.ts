import type { Heartbeat } from "../protocol.ts";
import * as format from "./format.ts";
import { language, number, say } from "./say.ts";
import { type Parked, parkedInAll } from "./section.ts";
import { ageNow, autopilotLost, BATTERY_STALE_S, isLotKnown, linkOf, OLD_S, oldestAge, STALE_S, stallCount, type View } from "./view.ts";

export type Tone = "fine" | "warn" | "idle" | "alarm";

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

const TITLES = {
  Idle: "state-idle",
  Configure: "state-configure",
  Arm: "state-arm",
  Takeoff: "state-takeoff",
  Hover: "state-hover",
  "Autonomous Explore": "state-explore",
  "Autonomous Move": "state-move",
  "Compulsive Move": "state-move",
  "Return To Launch": "state-home",
  Land: "state-land",
  CommunicationLost: "state-operator-lost",
  Manual: "state-manual",
} as const;

/** A state in the words of the page. */
export function stateTitle(state: string): string {
  return Object.hasOwn(TITLES, state) ? say(TITLES[state as keyof typeof TITLES]) : state;
}

/** Per cent seen of the lot found so far, which grows with the survey; null when it is not known, as it is when stalls were found and yet nothing counts as seen. */
export function seenPercent(heartbeat: Heartbeat): number | null {
  const share = heartbeat.Explored;
  if (share === null || (share === 0 && heartbeat.State !== "Autonomous Explore")) return null;
  return Math.round(share * 100);
}

export function stateWords(view: View): StateWords {
  const heartbeat = view.heartbeat;
  if (!heartbeat) return same("warn", say("not-connected"), view.link === "open" ? say("waiting-for-drone") : say("looking-for-drone"));
  if (linkOf(view) === "lost") {
    const state = stateTitle(heartbeat.State).toLocaleLowerCase(language());
    return same("warn", say("no-link"), say("was-in-state", { state, age: format.age(view.silence ?? 0) }));
  }
  if (autopilotLost(view)) return same("warn", say("autopilot-silent"), say("autopilot-silent-text"));
  if (heartbeat["Kill State"] === "sending") return same("warn", say("cutting-motors"), say("cutting-motors-text"));
  if (heartbeat["Kill State"] === "not confirmed") return same("warn", say("cut-not-confirmed"), say("cut-not-confirmed-text"));
  return heartbeat.State === "Idle" ? grounded(view, heartbeat) : active(view, heartbeat);
}

/** Control was given back in the air, or ran out, and nobody has taken it: nobody is lost. */
export function isGivenBack(heartbeat: Heartbeat): boolean {
  return heartbeat.State === "CommunicationLost" && heartbeat.Controller === null;
}

function grounded(view: View, heartbeat: Heartbeat): StateWords {
  if (heartbeat.Fallen) return fallen(heartbeat);
  if (heartbeat.Killed) return same("warn", say("motors-cut"), say("motors-cut-text"));
  const failed = heartbeat.Checks.filter((check) => !check.Passed).length;
  if (failed > 0) {
    const detail = say("fix-to-arm", { checks: failed });
    return { tone: "warn", title: say("state-idle"), detail, short: say("checks-failed", { checks: failed }) };
  }
  if (view.landedAt !== null) return same("idle", say("landed"), say("motors-off-since", { time: format.clock(view.landedAt) }));
  const passed = heartbeat.Checks.length;
  return same(toned(view, heartbeat, "idle"), say("state-idle"), passed > 0 ? say("checks-passed", { checks: passed }) : heartbeat.Detail);
}

/** Nobody cut the motors: where and when they went off is what the check of the motors says. */
function fallen(heartbeat: Heartbeat): StateWords {
  const motors = heartbeat.Checks.find((check) => !check.Passed && check["Remedy Command"] === "Clear Kill");
  const where = motors ? `${motors.Name}: ${motors.Value}. ` : "";
  return { tone: "alarm", title: say("fell"), detail: `${where}${say("fell-text")}`, short: say("fell-text") };
}

function active(view: View, heartbeat: Heartbeat): StateWords {
  const tone = toned(view, heartbeat, "fine");
  const armed = heartbeat.State === "Arm" && heartbeat.Armed === true;
  const title = armed ? say("state-armed") : isGivenBack(heartbeat) ? say("state-free") : stateTitle(heartbeat.State);
  const seen = seenPercent(heartbeat);
  if (heartbeat.State !== "Autonomous Explore" || seen === null) return same(tone, title, `${heartbeat.Detail}${oldPicture(view)}`);
  return { tone, title, detail: `${exploring(heartbeat, seen, "")}${oldPicture(view)}`, short: `${exploring(heartbeat, seen, "-short")}${oldPicture(view)}` };
}

/** What was seen, and the time to the end; of a lot whose size is not known, to the end of what is in sight. */
function exploring(heartbeat: Heartbeat, seen: number, size: "" | "-short"): string {
  const left = heartbeat["Survey Time Left"];
  const time = left === null || left <= 0 ? "" : format.duration(left);
  if (isLotKnown(heartbeat)) {
    const percent = format.percent(seen);
    return time === "" ? say(`seen-of-outline${size}`, { percent }) : say(`seen-of-outline-time${size}`, { percent, time });
  }
  const stalls = heartbeat.Free + heartbeat.Taken + heartbeat.Unknown;
  return time === "" ? say(`found-so-far${size}`, { stalls }) : say(`found-so-far-time${size}`, { stalls, time });
}

function oldPicture(view: View): string {
  const age = view.pictureAge;
  return age !== null && age > OLD_S ? ` ${say("picture-old", { age: format.age(age) })}` : "";
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
  const parked = stallCount(view) > 0 ? null : parkedInAll(view.sections.map(({ look }) => look));
  if (parked !== null) return parkedValue(view, parked);
  const known = heartbeat !== null && heartbeat.Free + heartbeat.Taken + heartbeat.Unknown > 0;
  const lost = linkOf(view) === "lost" && view.silence !== null;
  const label = lost && known ? say("free-at", { time: format.clock(view.now - (view.silence ?? 0) * 1000) }) : say("free-stalls");
  return { name: "free", value: known ? number(heartbeat.Free) : "–", age: "", label, staleLabel: "", trouble: false };
}

/** Vehicles of places, in a lot of sections alone. */
function parkedValue(view: View, { parked, capacity }: Parked): GlanceValue {
  const lost = linkOf(view) === "lost" && view.silence !== null;
  const label = lost ? say("parked-at", { time: format.clock(view.now - (view.silence ?? 0) * 1000) }) : say("parked");
  const value = capacity === null ? number(parked) : `${number(parked)}/${number(capacity)}`;
  return { name: "free", value, age: "", label, staleLabel: "", trouble: false };
}

function batteryValue(view: View): GlanceValue {
  const level = view.heartbeat?.["Battery Percentage"] ?? null;
  const left = view.heartbeat?.["Battery Time Left"] ?? null;
  const old = oldAge(ageNow(view, view.heartbeat?.["Battery Age"] ?? null), BATTERY_STALE_S);
  const value = left !== null ? format.timeLeft(left) : format.percent(level);
  const percent = format.percent(level);
  const label = left !== null && level !== null ? say("battery-percent", { percent }) : say("battery");
  const staleLabel = left === null ? "" : say("then-percent", { percent });
  return { name: "battery", value, age: level === null ? "" : old, label, staleLabel, trouble: false };
}

function heightValue(view: View): GlanceValue {
  const metres = view.heartbeat?.["Relative Altitude"] ?? null;
  const old = oldAge(ageNow(view, view.heartbeat?.["Pose Age"] ?? null), STALE_S);
  const value = format.height(metres, view.units);
  return { name: "height", value, age: metres === null ? "" : old, label: say("height"), staleLabel: "", trouble: false };
}

function linkValue(view: View): GlanceValue {
  const base = { name: "link" as const, age: "", staleLabel: "" };
  if (linkOf(view) === "never") return { ...base, value: "–", label: say("link-none"), trouble: true };
  const silence = view.silence ?? 0;
  if (linkOf(view) === "lost") return { ...base, value: format.age(silence), label: say("link-lost"), trouble: true };
  const vehicle = ageNow(view, view.heartbeat?.["Link Age"] ?? null) ?? silence;
  const worst = Math.max(silence, autopilotLost(view) ? vehicle : Math.min(vehicle, 1));
  if (autopilotLost(view)) return { ...base, value: format.age(worst), label: say("link-autopilot-silent"), trouble: true };
  if (vehicle > OLD_S) return { ...base, value: format.age(vehicle), label: say("link-autopilot-slow"), trouble: true };
  const slow = silence > STALE_S;
  return { ...base, value: format.age(Math.max(silence, view.gap)), label: slow ? say("link-slow") : say("link-good"), trouble: slow };
}

function oldAge(seconds: number | null, limit: number): string {
  return seconds !== null && seconds > limit ? say("age", { age: format.age(seconds) }) : "";
}
