import type { Bracket, Estimate } from "../api.ts";
import { number, say } from "../words/say.ts";

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

/** A bracket; an end that is not known is said to be so. */
export function bracket({ low, high }: Bracket, decimals = 0): string {
  if (low === null && high === null) return NONE;
  if (high === null) return say("archive-or-more", { value: number(low ?? 0, decimals) });
  if (low === null) return say("archive-or-less", { value: number(high, decimals) });
  return say("archive-from-to", { low: number(low, decimals), high: number(high, decimals) });
}

/** Day and time on the browser's clock: 2026-05-04 10:30. */
export function moment(iso: string): string {
  const date = new Date(iso);
  if (Number.isNaN(date.getTime())) return NONE;
  const two = (value: number): string => String(value).padStart(2, "0");
  return `${date.getFullYear()}-${two(date.getMonth() + 1)}-${two(date.getDate())} ${two(date.getHours())}:${two(date.getMinutes())}`;
}

/** The class of a share of looks, 0 to 4, by which a stall is coloured; -1 without looks. */
export function heatClass(value: number | null): number {
  return value === null ? -1 : Math.min(4, Math.floor(value * 5));
}
