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

/** Names of all clocks that the browser knows. */
export function clockNames(): string[] {
  return [...new Set(["UTC", ...Intl.supportedValuesOf("timeZone")])];
}
