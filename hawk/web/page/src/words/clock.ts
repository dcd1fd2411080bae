import { language, say } from "./say.ts";

/** Whose clock it is: "Toronto time". */
export function clockWords(zone: string): string {
  return zone === "UTC" ? zone : say("clock-of", { city: (zone.split("/").at(-1) ?? zone).replaceAll("_", " ") });
}

/** A time on the clock of a lot, in words. */
export function timeOnClock(iso: string, zone: string, options: Intl.DateTimeFormatOptions): string {
  return new Intl.DateTimeFormat(language(), { ...options, timeZone: zone }).format(new Date(iso));
}

/** Names of all clocks that the browser knows. */
export function clockNames(): string[] {
  return [...new Set(["UTC", ...Intl.supportedValuesOf("timeZone")])];
}
