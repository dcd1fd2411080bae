import type { Heartbeat } from "../protocol.ts";
import { isFlying } from "../state/flight.ts";
import * as format from "./format.ts";
import { isGivenBack } from "./glance.ts";
import { say, sentences } from "./say.ts";
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
  if (view.welcome?.Desk) return null;
  if (heartbeat["Kill State"] === "not confirmed") return cutNotConfirmed();
  if (autopilotLost(view)) return silentAutopilot(heartbeat);
  if (heartbeat.State === "CommunicationLost") return operatorLost(view, heartbeat);
  return null;
}

function neverConnected(view: View): Banner | null {
  if (view.link === "open") return null;
  return { ...plain(say("never-connected-title"), say("never-connected-text")), connect: view.link !== "connecting" || view.attempts > 1 };
}

function linkLost(view: View, heartbeat: Heartbeat): Banner {
  const silence = view.silence ?? 0;
  if (view.welcome?.Desk) return { ...plain(say("desk-silent-title", { age: format.age(silence) }), say("desk-silent-text")), connect: true };
  const title = say("no-word-title", { age: format.age(silence) });
  const base = { ...plain(title, bySettings(view, heartbeat)), connect: true };
  const returns = returnAfter(view, heartbeat);
  if (!returns) return base;
  const left = returns.home - silence;
  const marks = [
    { label: say("mark-lost"), at: 0 },
    { label: say("mark-holds"), at: returns.hold },
    { label: left > 0 ? say("mark-returns-in") : say("mark-returned"), at: returns.home },
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
  const remote = say("use-remote");
  if (!isFlying(heartbeat)) return say("was-on-ground");
  if (heartbeat.State === "Return To Launch") return sentences(say("goes-on-home"), remote);
  if (heartbeat.State === "Land") return sentences(say("goes-on-landing"), say("autopilot-acts"), remote);
  if (heartbeat.State === "Manual") return say("was-flown-by-hand");
  const returns = returnAfter(view, heartbeat);
  if (!returns) return sentences(say("goes-on-otherwise"), remote);
  const silence = view.silence ?? 0;
  const clockAt = (seconds: number): string => format.clock(view.now + (seconds - silence) * 1000);
  const homeAt = clockAt(returns.home);
  if (silence >= returns.home) return sentences(say("returning-since", { time: homeAt }), say("autopilot-acted-sooner"), remote);
  const holds = silence >= returns.hold ? say("holds-now") : say("holds-at", { time: clockAt(returns.hold) });
  return sentences(holds, say("returns-at", { time: homeAt }), say("autopilot-acts-sooner"), remote);
}

function silentAutopilot(heartbeat: Heartbeat): Banner {
  return plain(say("autopilot-lost-title"), isFlying(heartbeat) ? say("autopilot-lost-flying") : say("autopilot-lost-ground"));
}

function operatorLost(view: View, heartbeat: Heartbeat): Banner {
  const left = heartbeat["Return In"];
  const remaining = left === null ? null : left - (view.silence ?? 0);
  const home = remaining === null ? say("then-returns") : say("returns-in", { time: format.duration(remaining) });
  const mine = heartbeat["In Control"] ? "" : say("take-control-to-go-on");
  const title = isGivenBack(heartbeat) ? say("nobody-has-control") : say("operator-was-lost");
  return plain(title, sentences(say("holds-its-place"), home, mine));
}

function cutNotConfirmed(): Banner {
  return { ...plain(say("cut-unconfirmed-title"), say("cut-unconfirmed-text")), tone: "bad" };
}

function plain(title: string, text: string): Banner {
  return { tone: "warn", title, text, connect: false, timeline: null };
}
