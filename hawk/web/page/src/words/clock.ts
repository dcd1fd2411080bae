import { language, say } from "./say.ts";

/** Whose clock it is: "Toronto time". */
export function clockWords(zone: string): string {
  return zone === "UTC" ? zone : say("clock-of", { city: (zone.split("/").at(-1) ?? zone).replaceAll("_", " ") });
}

/** The language in which dates are written; English as the British do: the day, then the month. */
export function dateLanguage(): string {
  return language() === "en" ? "en-GB" : language();
}

const formats = new Map<string, Intl.DateTimeFormat>();

/** Writes dates so in a language; made once, which takes longer than a hundred dates. */
export function dateFormat(name: string, options: Intl.DateTimeFormatOptions): Intl.DateTimeFormat {
  const key = name + JSON.stringify(options);
  const format = formats.get(key) ?? new Intl.DateTimeFormat(name, options);
  formats.set(key, format);
  return format;
}

/** A time on the clock of a lot, in words. */
export function timeOnClock(iso: string, zone: string, options: Intl.DateTimeFormatOptions): string {
  return dateFormat(dateLanguage(), { ...options, timeZone: zone }).format(new Date(iso));
}

/** Time zone of the lot that the bar names, whose clock all times are by; undefined: no lot is known, and it is the browser's. */
let pageZone: string | undefined;

/** From now on times are by this clock where none is named. Returns whether it is another one than before. */
export function keepClock(zone: string | undefined): boolean {
  const isOther = zone !== pageZone;
  pageZone = zone;
  return isOther;
}

/** What a clock shows at a time, as if it were UTC, milliseconds; without a time zone that of the page. */
export function onClock(time: string | number, zone = pageZone): number {
  const parts = dateFormat("en", { ...(zone === undefined ? {} : { timeZone: zone }), hourCycle: "h23", year: "numeric", month: "numeric", day: "numeric", hour: "numeric", minute: "numeric", second: "numeric" }).formatToParts(new Date(time));
  const of = (type: string): number => Number(parts.find((part) => part.type === type)?.value ?? 0);
  return Date.UTC(of("year"), of("month") - 1, of("day"), of("hour"), of("minute"), of("second"));
}

/** Names of all clocks that the browser knows. */
export function clockNames(): string[] {
  return [...new Set(["UTC", ...Intl.supportedValuesOf("timeZone")])];
}
