import { language, say } from "./say.ts";

/** Whose clock it is: "Toronto time". */
export function clockWords(zone: string): string {
  return zone === "UTC" ? zone : say("clock-of", { city: (zone.split("/").at(-1) ?? zone).replaceAll("_", " ") });
}

/** The language in which dates are written; English as the British do: the day, then the month. */
export function dateLanguage(): string {
  return language() === "en" ? "en-GB" : language();
}

/** A time on the clock of a lot, in words. */
export function timeOnClock(iso: string, zone: string, options: Intl.DateTimeFormatOptions): string {
  return new Intl.DateTimeFormat(dateLanguage(), { ...options, timeZone: zone }).format(new Date(iso));
}

/** Names of all clocks that the browser knows. */
export function clockNames(): string[] {
  return [...new Set(["UTC", ...Intl.supportedValuesOf("timeZone")])];
}
