import { SCALES, type Units } from "./units.ts";

const NONE = "–";

/** Height: tenths below 10. */
export function height(metres: number | null, units: Units): string {
  if (metres === null) return NONE;
  const value = metres / SCALES[units].metres;
  return `${trim(value, Math.abs(value) < 9.95 ? 1 : 0)} ${SCALES[units].symbol}`;
}

export function distance(metres: number, units: Units): string {
  const value = metres / SCALES[units].metres;
  return `${trim(value, value < 9.5 ? 1 : 0)} ${SCALES[units].symbol}`;
}

/** A length to the whole unit. */
export function length(metres: number, units: Units): string {
  return `${Math.round(metres / SCALES[units].metres)} ${SCALES[units].symbol}`;
}

/** A length as it was set, to a tenth where it has one. */
export function margin(metres: number, units: Units): string {
  return `${Number((metres / SCALES[units].metres).toFixed(1))} ${SCALES[units].symbol}`;
}

/** Two sides: "150 × 146 m". */
export function extent(one: number, other: number, units: Units): string {
  return `${Math.round(one / SCALES[units].metres)} × ${length(other, units)}`;
}

/** A span: seconds below 90 s, then minutes. */
export function duration(seconds: number): string {
  const whole = Math.max(0, Math.round(seconds));
  return whole < 90 ? `${whole} s` : `${Math.round(whole / 60)} min`;
}

/** A span with both units, for a flight that is over. */
export function longDuration(seconds: number): string {
  const whole = Math.max(0, Math.round(seconds));
  return whole < 60 ? `${whole} s` : `${Math.floor(whole / 60)} min ${whole % 60} s`;
}

/** Battery time: whole minutes from 2 min on, seconds below, never rounded up. */
export function timeLeft(seconds: number): string {
  return seconds >= 120 ? `${Math.floor(seconds / 60)} min` : `${Math.max(0, Math.floor(seconds))} s`;
}

export function age(seconds: number): string {
  return seconds < 1 ? `${Math.max(0, seconds).toFixed(1)} s` : duration(Math.floor(seconds));
}

export function percent(value: number | null): string {
  return value === null ? NONE : `${Math.round(value)} %`;
}

export function speed(metresPerSecond: number | null, units: Units): string {
  if (metresPerSecond === null) return NONE;
  const { symbol, metresPerSecond: one } = SCALES[units].speed;
  return `${trim(metresPerSecond / one, 1)} ${symbol}`;
}

/** Area in words of its size: square metres or feet, or hectares or acres from a tenth on. */
export function area(squareMetres: number | null, units: Units): string {
  if (squareMetres === null) return NONE;
  const { area: small, land } = SCALES[units];
  const lands = squareMetres / land.squareMetres;
  return lands < 0.1 ? `${Math.round(squareMetres / small.squareMetres)} ${small.symbol}` : `${trim(lands, lands < 2 ? 2 : 1)} ${land.symbol}`;
}

export function count(value: number, one: string, many: string): string {
  return `${value} ${value === 1 ? one : many}`;
}

/** Size of a file, in decimal units as in file managers. */
export function bytes(size: number): string {
  if (size < 1000) return `${size} B`;
  const units = ["kB", "MB", "GB"];
  const power = Math.min(Math.floor(Math.log10(size) / 3), units.length);
  const value = size / 1000 ** power;
  return `${trim(value, value < 10 ? 1 : 0)} ${units[power - 1]}`;
}

/** Time of day where this page is, from UTC in ISO 8601 or milliseconds. */
export function clock(time: string | number): string {
  const date = new Date(time);
  if (Number.isNaN(date.getTime())) return NONE;
  return [date.getHours(), date.getMinutes(), date.getSeconds()].map((part) => String(part).padStart(2, "0")).join(":");
}

/** Degrees with five decimals (about a metre) and their hemisphere. */
export function place(latitude: number | null, longitude: number | null): string {
  if (latitude === null || longitude === null) return NONE;
  const one = (value: number, plus: string, minus: string): string =>
    `${Math.abs(value).toFixed(5)}° ${value < 0 ? minus : plus}`;
  return `${one(latitude, "N", "S")}, ${one(longitude, "E", "W")}`;
}

/** How far east and north: "60 m E, 59 m N". */
export function offset(north: number, east: number, units: Units): string {
  const part = (value: number, plus: string, minus: string): string =>
    `${length(Math.abs(value), units)} ${value < 0 ? minus : plus}`;
  return `${part(east, "E", "W")}, ${part(north, "N", "S")}`;
}

const COMPASS = ["north", "north-east", "east", "south-east", "south", "south-west", "west", "north-west"];

/** Direction in words of a path, metres north and east. */
export function direction(north: number, east: number): string {
  const eighth = Math.round(Math.atan2(east, north) / (Math.PI / 4));
  return COMPASS[(eighth + 8) % 8] ?? "north";
}

/** Wind: "5.2 m/s from the west"; `from` in radians clockwise from north. */
export function wind(metresPerSecond: number | null, from: number | null, units: Units): string {
  if (metresPerSecond === null || from === null) return NONE;
  return `${speed(metresPerSecond, units)} from the ${direction(Math.cos(from), Math.sin(from))}`;
}

function trim(value: number, digits: number): string {
  const text = value.toFixed(digits);
  return Number(text) === 0 ? (0).toFixed(digits) : text;
}
