import type { LinkStatus } from "../link/reconnect.ts";
import type { CommandOption, Heartbeat, Welcome } from "../protocol.ts";
import type { FlownSection } from "../state/flown-sections.ts";
import type { Units } from "./units.ts";

/** Everything that the words depend on, at one moment. */
export interface View {
  link: LinkStatus;
  attempts: number;
  welcome: Welcome | null;
  heartbeat: Heartbeat | null;
  /** Seconds since the last heartbeat arrived; null before the first. */
  silence: number | null;
  /** Seconds between the last two heartbeats: how fresh this page is at best. */
  gap: number;
  /** Time of day, milliseconds. */
  now: number;
  landedAt: string | null;
  /** Age of the camera's picture that is shown, seconds; null before the first. */
  pictureAge: number | null;
  /** The motors went off before take-off, and this operator had not asked for it. */
  selfDisarmed?: boolean;
  /** Sections of the lot that is flown over, as they are counted so far. */
  sections: readonly FlownSection[];
  /** Units in which lengths are shown. */
  units: Units;
}

/** Older than this, a value is shown as stale; the pose comes several times a second, the battery about once. */
export const STALE_S = 1;
export const BATTERY_STALE_S = 2;
/** Nothing that is older counts as good anywhere on the page. */
export const OLD_S = 2;
/** So long without a word, the link counts as lost. */
export const LOST_S = 2.5;

export type Link = "never" | "live" | "lost";

export function linkOf(view: View): Link {
  if (view.heartbeat === null || view.silence === null) return "never";
  return view.silence >= LOST_S || view.link !== "open" ? "lost" : "live";
}

/** Number of stalls that the drone knows. */
export function stallCount({ heartbeat }: View): number {
  return heartbeat ? heartbeat.Free + heartbeat.Taken + heartbeat.Unknown : 0;
}

/** The autopilot does not answer although the drone's computer does. */
export function autopilotLost(view: View): boolean {
  return linkOf(view) === "live" && view.heartbeat !== null && !view.heartbeat.Connected;
}

/** Whether the size of what is explored is known: an outline is, or a lot that is surveyed again. The share of what was found so far is no progress: it falls when more lot comes in sight. */
export function isLotKnown(heartbeat: Heartbeat): boolean {
  return heartbeat["Outline Area"] !== null;
}

export function option(view: View, command: string): CommandOption {
  const found = view.heartbeat?.Options.find((each) => each.Command === command);
  return found ?? { Command: command, Possible: false, Reason: "" };
}

/** Age of the oldest value that the operator flies by: the drone's word, its position, the autopilot's word, the picture. */
export function oldestAge(view: View): number {
  const { "Pose Age": pose = null, "Link Age": link = null } = view.heartbeat ?? {};
  const sent = [pose, link].map((age) => (age === null ? 0 : (ageNow(view, age) ?? 0)));
  return Math.max(view.silence ?? 0, view.pictureAge ?? 0, ...sent);
}

/** Age now of a value that was so old when it was sent. */
export function ageNow(view: View, ageWhenSent: number | null): number | null {
  if (view.silence === null) return null;
  return (ageWhenSent ?? 0) + view.silence;
}
