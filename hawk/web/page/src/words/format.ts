import { onClock } from "./clock.ts";
import { number, say } from "./say.ts";
import { SCALES, type Units } from "./units.ts";

const NONE = "–";

/** Height: tenths below 10. */
export function height(metres: number | null, units: Units): string {
  if (metres === null) return NONE;
  const value = metres / SCALES[units].metres;
  return say("length", { units, value: number(value, Math.abs(value) < 9.95 ? 1 : 0) });
}

export function distance(metres: number, units: Units): string {
  const value = metres / SCALES[units].metres;
  return say("length", { units, value: number(value, value < 9.5 ? 1 : 0) });
}

/** A length to the whole unit. */
export function length(metres: number, units: Units): string {
  return say("length", { units, value: number(Math.round(metres / SCALES[units].metres)) });
}

/** A length as it was set, to a tenth where it has one. */
export function margin(metres: number, units: Units): string {
  return say("length", { units, value: number(metres / SCALES[units].metres, 1, 0) });
}

/** The length of a scale bar, in the units. */
export function scaleLength(value: number, units: Units): string {
  if (units === "metres" && value >= 1000) return say("length-km", { value: number(value / 1000, 2, 0) });
  return say("length", { units, value: number(value, 2, 0) });
}

/** Two sides: "150 × 146 m". */
export function extent(one: number, other: number, units: Units): string {
  return say("extent", { one: number(Math.round(one / SCALES[units].metres)), other: length(other, units) });
}

/** A span: seconds below 90 s, then minutes. */
export function duration(seconds: number): string {
  const whole = Math.max(0, Math.round(seconds));
  return whole < 90 ? wholeSeconds(whole) : wholeMinutes(Math.round(whole / 60));
}

/** A span with both units, for a flight that is over. */
export function longDuration(seconds: number): string {
  const whole = Math.max(0, Math.round(seconds));
  if (whole < 60) return wholeSeconds(whole);
  return say("minutes-seconds", { minutes: number(Math.floor(whole / 60)), seconds: number(whole % 60) });
}

/** Battery time: whole minutes from 2 min on, seconds below, never rounded up. */
export function timeLeft(seconds: number): string {
  return seconds >= 120 ? wholeMinutes(Math.floor(seconds / 60)) : wholeSeconds(Math.max(0, Math.floor(seconds)));
}

export function age(seconds: number): string {
  return seconds < 1 ? say("seconds", { value: number(Math.max(0, seconds), 1) }) : duration(Math.floor(seconds));
}

/** Whole seconds, as they are counted down. */
export function wholeSeconds(seconds: number): string {
  return say("seconds", { value: number(seconds) });
}

export function percent(value: number | null): string {
  return value === null ? NONE : say("percent", { value: number(Math.round(value)) });
}

export function speed(metresPerSecond: number | null, units: Units): string {
  if (metresPerSecond === null) return NONE;
  return say("speed", { units, value: number(metresPerSecond / SCALES[units].metresPerSecond, 1) });
}

/** Area in words of its size: square metres or feet, or hectares or acres from a tenth on. */
export function area(squareMetres: number | null, units: Units): string {
  if (squareMetres === null) return NONE;
  const large = squareMetres / SCALES[units].largeSquareMetres;
  if (large >= 0.1) return say("large-area", { units, value: number(large, large < 2 ? 2 : 1) });
  return say("area", { units, value: number(Math.round(squareMetres / SCALES[units].squareMetres)) });
}

export function volts(value: number | null): string {
  return value === null ? NONE : say("volts", { value: number(value, 1) });
}

/** Size of a file, in decimal units as in file managers. */
export function bytes(size: number): string {
  if (size < 1000) return say("file-size", { unit: "B", value: number(size) });
  const units = ["kB", "MB", "GB"] as const;
  const power = Math.min(Math.floor(Math.log10(size) / 3), units.length);
  const value = size / 1000 ** power;
  return say("file-size", { unit: units[power - 1] ?? "GB", value: number(value, value < 10 ? 1 : 0) });
}

/** Time of day on the page's clock, from UTC in ISO 8601 or milliseconds. */
export function clock(time: string | number): string {
  return onPageClock(time)?.slice(11, 19) ?? NONE;
}

/** Day on the page's clock, from UTC in ISO 8601: 2026-05-04. */
export function day(time: string): string {
  return onPageClock(time)?.slice(0, 10) ?? NONE;
}

function onPageClock(time: string | number): string | null {
  return Number.isNaN(new Date(time).getTime()) ? null : new Date(onClock(time)).toISOString();
}

/** Degrees with five decimals (about a metre) and their hemisphere. */
export function place(latitude: number | null, longitude: number | null): string {
  if (latitude === null || longitude === null) return NONE;
  return say("place", {
    latitude: say("latitude", { degrees: number(Math.abs(latitude), 5), side: northOrSouth(latitude) }),
    longitude: say("longitude", { degrees: number(Math.abs(longitude), 5), side: eastOrWest(longitude) }),
  });
}

/** How far east and north: "60 m E, 59 m N". */
export function offset(north: number, east: number, units: Units): string {
  return say("offset", {
    east: say("offset-east", { length: length(Math.abs(east), units), side: eastOrWest(east) }),
    north: say("offset-north", { length: length(Math.abs(north), units), side: northOrSouth(north) }),
  });
}

const COMPASS = ["north", "north-east", "east", "south-east", "south", "south-west", "west", "north-west"] as const;
/** A direction, as messages take it. */
export type Direction = (typeof COMPASS)[number];

/** Direction of a path, metres north and east. */
export function direction(north: number, east: number): Direction {
  const eighth = Math.round(Math.atan2(east, north) / (Math.PI / 4));
  return COMPASS[(eighth + 8) % 8] ?? "north";
}

/** Wind: "5.2 m/s from the west"; `from` in radians clockwise from north. */
export function wind(metresPerSecond: number | null, from: number | null, units: Units): string {
  if (metresPerSecond === null || from === null) return NONE;
  return say("wind", { speed: speed(metresPerSecond, units), from: direction(Math.cos(from), Math.sin(from)) });
}

function wholeMinutes(minutes: number): string {
  return say("minutes", { value: number(minutes) });
}

function northOrSouth(value: number): "north" | "south" {
  return value < 0 ? "south" : "north";
}

function eastOrWest(value: number): "east" | "west" {
  return value < 0 ? "west" : "east";
}
