import type { Estimate } from "../api.ts";
import { number, say } from "../words/say.ts";
import { onClock } from "./time-bar-days.ts";

const NONE = "–";

/** A share as percent with its interval. */
export function share({ value, low, high }: Estimate): string {
  if (value === null || low === null || high === null) return NONE;
  return say("archive-share", { value: number(100 * value, 1), low: number(100 * low, 1), high: number(100 * high, 1) });
}

/** A number of stalls, or of space-hours, with its interval. */
export function amount({ value, low, high }: Estimate): string {
  if (value === null || low === null || high === null) return NONE;
  return say("archive-amount", { value: number(value), low: number(low), high: number(high) });
}

/** Day and time on the clock of a lot: 2026-05-04 10:30; without a time zone on the browser's. */
export function moment(iso: string, zone?: string): string {
  if (Number.isNaN(Date.parse(iso))) return NONE;
  return new Date(onClock(iso, zone)).toISOString().slice(0, 16).replace("T", " ");
}

/** The class of a share of looks, 0 to 4, by which a stall is coloured; -1 without looks. */
export function heatClass(value: number | null): number {
  return value === null ? -1 : Math.min(4, Math.floor(value * 5));
}
