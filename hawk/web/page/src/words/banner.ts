import type { Heartbeat } from "../protocol.ts";
import { isFlying } from "../state/flight.ts";
import * as format from "./format.ts";
import { isGivenBack } from "./glance.ts";
import { autopilotLost, linkOf, type View } from "./view.ts";

/** A point on the banner's time line; `at` in seconds after the link was lost. */
export interface Mark {
  label: string;
  at: number;
}

export interface Banner {
  tone: "warn" | "bad";
  title: string;
  text: string;
  /** Offers to connect at once. */
  connect: boolean;
  timeline: { marks: Mark[]; now: number; countdown: string } | null;
}

const COMMANDED = new Set(["Takeoff", "Hover", "Autonomous Explore", "Autonomous Move", "Compulsive Move"]);

/** What is wrong with the link, what the drone does by its settings and what can be done; null when all is well. */
export function banner(view: View): Banner | null {
  if (linkOf(view) === "never") return neverConnected(view);
  const heartbeat = view.heartbeat;
  if (!heartbeat) return null;
  if (linkOf(view) === "lost") return linkLost(view, heartbeat);
  if (heartbeat["Kill State"] === "not confirmed") return cutNotConfirmed();
  if (autopilotLost(view)) return silentAutopilot(heartbeat);
  if (heartbeat.State === "CommunicationLost") return operatorLost(view, heartbeat);
  return null;
}

function neverConnected(view: View): Banner | null {
  if (view.link === "open") return null;
  const text = "Is it switched on and in reach? This page keeps trying by itself.";
  return { ...plain("Not connected to the drone", text), connect: view.link !== "connecting" || view.attempts > 1 };
}

function linkLost(view: View, heartbeat: Heartbeat): Banner {
  const silence = view.silence ?? 0;
  const title = `No word from the drone for ${format.age(silence)}`;
  const base = { ...plain(title, bySettings(view, heartbeat)), connect: true };
  const returns = returnAfter(view, heartbeat);
  if (!returns) return base;
  const left = returns.home - silence;
  const marks = [
    { label: "lost", at: 0 },
    { label: "holds", at: returns.hold },
    { label: left > 0 ? "returns home at the latest in" : "returned home", at: returns.home },
  ];
  return { ...base, timeline: { marks, now: silence, countdown: left > 0 ? format.duration(left) : "" } };
}

/** Seconds of ours after the last word at which it stops and at which it returns home; null in states that wait for nobody. */
function returnAfter(view: View, heartbeat: Heartbeat): { hold: number; home: number } | null {
  if (!view.welcome || !isFlying(heartbeat) || !heartbeat["In Control"] || !COMMANDED.has(heartbeat.State)) return null;
  const { "Operator Timeout": timeout, "Operator Hold": hold, Speed: speed } = view.welcome;
  return { hold: timeout / speed, home: (timeout + hold) / speed };
}

/** The page cannot know whether only its own link is gone or the drone's computer, for which the autopilot waits less. */
function bySettings(view: View, heartbeat: Heartbeat): string {
  const remote = "To take over, use the remote control.";
  if (!isFlying(heartbeat)) return "It was on the ground when it was last heard.";
  if (heartbeat.State === "Return To Launch") return `By its settings it goes on home and lands there. ${remote}`;
  if (heartbeat.State === "Land") return `By its settings it goes on landing. ${autopilotActs("acts")} ${remote}`;
  if (heartbeat.State === "Manual") return "It was flown with the remote control when it was last heard.";
  const returns = returnAfter(view, heartbeat);
  if (!returns) return `Another operator had control, or it was already waiting: it goes on by its settings. ${remote}`;
  const lostAt = view.now - (view.silence ?? 0) * 1000;
  const silence = view.silence ?? 0;
  const homeAt = format.clock(lostAt + returns.home * 1000);
  if (silence >= returns.home) {
    return `By its settings it is on its way home since ${homeAt} and lands there. ${autopilotActs("acted sooner")} ${remote}`;
  }
  const holds =
    silence >= returns.hold
      ? "By its settings it now holds its place."
      : `By its settings it goes on until ${format.clock(lostAt + returns.hold * 1000)}, then holds its place.`;
  return `${holds} At ${homeAt} it returns home and lands. ${autopilotActs("acts sooner")} ${remote}`;
}

function autopilotActs(when: string): string {
  return `If its computer stopped, the autopilot ${when} by its own failsafe.`;
}

function silentAutopilot(heartbeat: Heartbeat): Banner {
  const text = isFlying(heartbeat)
    ? "By its settings the autopilot returns home when it hears nothing. To take over, use the remote control."
    : "Is the autopilot switched on and its cable in place? The drone's computer keeps trying.";
  return plain("The drone's computer does not hear the autopilot", text);
}

function operatorLost(view: View, heartbeat: Heartbeat): Banner {
  const left = heartbeat["Return In"];
  const remaining = left === null ? null : left - (view.silence ?? 0);
  const home =
    remaining === null ? "Then it returns home and lands." : `In ${format.duration(remaining)} it returns home and lands.`;
  const mine = heartbeat["In Control"] ? "" : " Take control to go on.";
  return plain(isGivenBack(heartbeat) ? "Nobody has control" : "The operator was lost", `It holds its place. ${home}${mine}`);
}

function cutNotConfirmed(): Banner {
  const text = "The drone did not say that the motors are off. Cut motors again if it is still needed.";
  return { ...plain("Cutting the motors is not confirmed", text), tone: "bad" };
}

function plain(title: string, text: string): Banner {
  return { tone: "warn", title, text, connect: false, timeline: null };
}
