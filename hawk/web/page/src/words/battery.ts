import type { Heartbeat } from "../protocol.ts";
import * as format from "./format.ts";
import { say } from "./say.ts";

/** A part of the battery, per cent of a full one. */
export interface BatteryPart {
  name: "home" | "survey" | "left" | "missing";
  label: string;
  percent: number;
  /** Its length in the bar: what is needed ends at the charge, and what is missing begins there. */
  shown: number;
}

export interface BatteryWords {
  /** Whether it suffices, in words. */
  verdict: string;
  /** Not enough for the rest of the survey. */
  short: boolean;
  parts: BatteryPart[];
  /** Everything in one sentence, for screen readers. */
  spoken: string;
}

/** What the battery is needed for; null while nothing of it is known. */
export function batteryWords(heartbeat: Heartbeat): BatteryWords | null {
  const charge = heartbeat["Battery Percentage"];
  const home = heartbeat["Battery Needed Home"];
  if (charge === null || home === null) return null;
  const survey = heartbeat["Battery Needed Survey"];
  const parts = partsOf(charge, home, survey);
  const verdict = verdictOf(heartbeat);
  const list = parts.map((part) => say(`battery-spoken-${part.name}`, { percent: format.percent(part.percent) })).join(", ");
  const short = parts.some((part) => part.name === "missing");
  return { verdict, short, parts, spoken: say("battery-spoken", { percent: format.percent(charge), parts: list, verdict }) };
}

/** The flight home comes first: the drone returns when no more than that is left. */
function partsOf(charge: number, home: number, survey: number | null): BatteryPart[] {
  const left = charge - home - (survey ?? 0);
  const parts: BatteryPart[] = [{ name: "home", label: say("battery-home"), percent: home, shown: Math.min(home, charge) }];
  if (survey !== null) {
    parts.push({ name: "survey", label: say("battery-survey"), percent: survey, shown: Math.min(survey, Math.max(0, charge - home)) });
  }
  if (left >= 0) parts.push({ name: "left", label: say("battery-left"), percent: left, shown: left });
  else parts.push({ name: "missing", label: say("battery-missing"), percent: -left, shown: Math.min(-left, 100 - charge) });
  return parts;
}

function verdictOf(heartbeat: Heartbeat): string {
  const { "Battery Needed Survey": survey, "Battery Left": left, "Survey Basis": basis, "Survey Share": share } = heartbeat;
  if (survey === null || left === null || share === null) return say("battery-not-known");
  if (survey === 0) return say("battery-nothing-left");
  const of = basis === "fence" ? "fence" : basis === "planner" && heartbeat["Outline Area"] === null ? "found" : "survey";
  if (left >= 0) return say(`battery-enough-${of}`);
  return say(`battery-part-${of}`, { percent: format.percent(Math.floor(share * 10) * 10) });
}
