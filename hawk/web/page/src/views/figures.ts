import type { Estimate } from "../api.ts";
import { dateFormat, dateLanguage, onClock } from "../words/clock.ts";
import { number, say } from "../words/say.ts";

const NONE = "–";

/** A share as percent with its interval. */
export function share({ value, low, high }: Estimate): string {
  if (value === null || low === null || high === null) return NONE;
  return say("archive-share", { value: number(100 * value, 1), low: number(100 * low, 1), high: number(100 * high, 1) });
}

/** Hours and minutes of a clock's time, as 10:02. */
export function timeWords(clock: number): string {
  return new Date(clock).toISOString().slice(11, 16);
}

/** Day and time on the clock of a lot: 2026-05-04 10:30; without a time zone on the page's. */
export function moment(iso: string, zone?: string): string {
  if (Number.isNaN(Date.parse(iso))) return NONE;
  return new Date(onClock(iso, zone)).toISOString().slice(0, 16).replace("T", " ");
}

/** A day in the order in which people of the language write it. */
export function dayWords(clock: number, parts: Intl.DateTimeFormatOptions): string {
  return dateFormat(dateLanguage(), { ...parts, timeZone: "UTC" }).format(clock).replace(/^(\p{L}+\.?), /u, "$1 ");
}

/** The same for people: Mon 4 May, 10:02; with the year where it is another one than now. */
export function dayAndTime(iso: string, zone?: string): string {
  const clock = onClock(iso, zone);
  const isThisYear = new Date(clock).getUTCFullYear() === new Date().getUTCFullYear();
  const day = dayWords(clock, { weekday: "short", day: "numeric", month: "short", ...(isThisYear ? {} : { year: "numeric" }) });
  return say("compare-day-time", { day, time: timeWords(clock) });
}

/** The class of a share of looks, 0 to 4, by which a stall is coloured; -1 without looks. */
export function heatClass(value: number | null): number {
  return value === null ? -1 : Math.min(4, Math.floor(value * 5));
}
