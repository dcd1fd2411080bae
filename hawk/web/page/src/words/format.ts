const NONE = "–";

/** Height in metres: tenths below 10 m. */
export function height(metres: number | null): string {
  if (metres === null) return NONE;
  const tenths = Math.abs(metres) < 9.95;
  return `${trim(metres, tenths ? 1 : 0)} m`;
}

export function distance(metres: number): string {
  return metres < 9.5 ? `${trim(metres, 1)} m` : `${Math.round(metres)} m`;
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

export function speed(metresPerSecond: number | null): string {
  return metresPerSecond === null ? NONE : `${trim(metresPerSecond, 1)} m/s`;
}

/** Area in words of its size: square metres, or hectares from a tenth on. */
export function area(squareMetres: number | null): string {
  if (squareMetres === null) return NONE;
  return squareMetres < 1000 ? `${Math.round(squareMetres)} m²` : `${trim(squareMetres / 10_000, squareMetres < 20_000 ? 2 : 1)} ha`;
}

export function count(value: number, one: string, many: string): string {
  return `${value} ${value === 1 ? one : many}`;
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

/** Metres east and north: "60 m E, 59 m N". */
export function offset(north: number, east: number): string {
  const part = (value: number, plus: string, minus: string): string =>
    `${Math.round(Math.abs(value))} m ${value < 0 ? minus : plus}`;
  return `${part(east, "E", "W")}, ${part(north, "N", "S")}`;
}

const COMPASS = ["north", "north-east", "east", "south-east", "south", "south-west", "west", "north-west"];

/** Direction in words of a path, metres north and east. */
export function direction(north: number, east: number): string {
  const eighth = Math.round(Math.atan2(east, north) / (Math.PI / 4));
  return COMPASS[(eighth + 8) % 8] ?? "north";
}

/** Wind: "5.2 m/s from the west"; `from` in radians clockwise from north. */
export function wind(metresPerSecond: number | null, from: number | null): string {
  if (metresPerSecond === null || from === null) return NONE;
  return `${speed(metresPerSecond)} from the ${direction(Math.cos(from), Math.sin(from))}`;
}

function trim(value: number, digits: number): string {
  const text = value.toFixed(digits);
  return Number(text) === 0 ? (0).toFixed(digits) : text;
}
