import type { Film, FilmMessage } from "../api.ts";
import type { DroneMark } from "../map/flight-scene.ts";
import { turn } from "../map/geometry.ts";
import type { Point } from "../protocol.ts";
import { onClock } from "../words/clock.ts";
import { stateTitle } from "../words/glance.ts";
import { say } from "../words/say.ts";

export const SPEEDS = [0.25, 0.5, 1, 2, 4, 8, 16] as const;
/** A row of numbers that begins with its time. */
export type Row = readonly (number | null)[];

const RADIANS = Math.PI / 180;
/** Values older than this are no more those of a moment, seconds: what the camera saw, say. */
const OLD_S = 5;

/** A stretch of the film in which the drone does one thing, seconds. */
export interface Phase {
  from: number;
  to: number;
  title: string;
}

/** What a recording says of a moment. */
export interface Instant {
  drone: DroneMark | null;
  home: Point | null;
  fence: readonly Point[];
  zones: readonly (readonly Point[])[];
  footprint: readonly Point[];
  height: number | null;
  fromHome: number | null;
  battery: number | null;
  /** Seconds until it had to return; null: not known. */
  left: number | null;
  free: number;
  taken: number;
  unknown: number;
}

/** The last of some rising times that is not after another one; -1 before the first. */
export function lastAt(times: readonly number[], at: number): number {
  return lastOf(times, (time) => time, at);
}

/** The last of some values by rising time that is not after another one; -1 before the first. */
function lastOf<T>(values: readonly T[], time: (value: T) => number, at: number): number {
  let [low, high] = [0, values.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    const value = values[middle];
    if (value !== undefined && time(value) <= at) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/** Index of the row that holds at a time; -1 before the first. */
export function rowAt(rows: readonly Row[], at: number): number {
  return lastOf(rows, (row) => row[0] ?? 0, at);
}

export function messageAt(messages: readonly FilmMessage[], at: number): number {
  return lastOf(messages, (each) => each.at, at);
}

/** The moment at a time of a film, milliseconds since 1970; null where the recording does not say it. */
export function momentAt({ began, clock }: Film, at: number): number | null {
  if (began === null) return null;
  const leap = clock[rowAt(clock, at)]?.[1] ?? 0;
  return Date.parse(began) + 1000 * (at + leap);
}

/** A time on the clock of a lot, 10:04:21; on the film's own one where the recording does not say the moment. */
export function clockAt(film: Film, at: number, zone: string | undefined): string {
  const moment = momentAt(film, at);
  return moment === null ? spanOf(at) : new Date(onClock(new Date(moment).toISOString(), zone)).toISOString().slice(11, 19);
}

const STEPS_S = [10, 30, 60, 120, 300, 600, 1800, 3600, 7200, 21_600] as const;
const MOST_CLOCKS = 7;

/** Times of a film at which the clock shows a round time, a few of them; the last part has room for its words. */
export function roundTimes(film: Film): number[] {
  const step = STEPS_S.find((each) => film.seconds / each <= MOST_CLOCKS) ?? film.seconds / MOST_CLOCKS;
  const first = step - ((momentAt(film, 0) ?? 0) / 1000 % step);
  const last = film.seconds * (1 - 0.5 / MOST_CLOCKS);
  return Array.from({ length: MOST_CLOCKS }, (_, k) => (first % step) + k * step).filter((at) => at <= last);
}

/** A time on the film's own clock: 2:21. */
export function spanOf(seconds: number): string {
  const whole = Math.max(0, Math.floor(seconds));
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
}

/** What the drone did, one after the other; before its first state it stood on the ground. */
export function phasesOf({ phases, seconds }: Film): Phase[] {
  const found: Phase[] = [];
  for (const { at, state } of [{ at: 0, state: "Idle" }, ...phases]) {
    const title = stateTitle(state);
    const last = found.at(-1);
    if (last) last.to = at;
    if (last?.title === title) continue;
    if (last && last.to === last.from) found.pop();
    const before = found.at(-1);
    if (before?.title !== title) found.push({ from: at, to: seconds, title });
  }
  const last = found.at(-1);
  if (last) last.to = seconds;
  return found;
}

/** Where a film begins to be of interest: at the take-off. */
export function beginOf({ phases }: Film): number {
  return phases.find(({ state }) => state === "Takeoff")?.at ?? 0;
}

export function instantAt(film: Film, at: number): Instant {
  const [battery, left] = valuesAt(film.battery, at);
  const [free, taken, unknown] = valuesAt(film.counts, at);
  const home = valuesAt(film.homes, at);
  const fence = film.fences[lastOf(film.fences, (each) => each.at, at)];
  const track = rowAt(film.track, at);
  const drone = droneAt(film.track, track, at);
  const place = home[0] == null ? null : { North: home[0], East: home[1] ?? 0 };
  return {
    drone,
    home: place,
    fence: (fence?.ring ?? []).map(pointOf),
    zones: (fence?.zones ?? []).map((zone) => zone.map(pointOf)),
    footprint: footprintAt(film, at),
    height: film.track[track]?.[3] ?? null,
    fromHome: drone && place && Math.hypot(drone.north - place.North, drone.east - place.East),
    battery: battery ?? null,
    left: left ?? null,
    free: free ?? 0,
    taken: taken ?? 0,
    unknown: unknown ?? 0,
  };
}

function valuesAt(rows: readonly Row[], at: number): Row {
  return rows[rowAt(rows, at)]?.slice(1) ?? [];
}

/** Between two rows the drone is between their places. */
function droneAt(track: readonly Row[], index: number, at: number): DroneMark | null {
  const one = track[index];
  if (!one) return null;
  const [time, north, east, , heading] = one;
  const [later, farNorth, farEast, , farHeading] = track[index + 1] ?? one;
  const share = Math.min(1, (at - (time ?? 0)) / Math.max(0.01, (later ?? 0) - (time ?? 0)));
  const between = (from: number | null | undefined, to: number | null | undefined): number => (from ?? 0) + ((to ?? 0) - (from ?? 0)) * share;
  const near = later === time || (later ?? 0) - (time ?? 0) < OLD_S;
  return { north: near ? between(north, farNorth) : (north ?? 0), east: near ? between(east, farEast) : (east ?? 0), yaw: turn((heading ?? 0) * RADIANS, (farHeading ?? 0) * RADIANS, share) };
}

function footprintAt({ footprints }: Film, at: number): Point[] {
  return cornersOf(footprints[rowAt(footprints, at)] ?? []);
}

/** What the camera has seen by a time. */
export function seenBy({ footprints }: Film, at: number): Point[][] {
  return footprints.slice(0, rowAt(footprints, at) + 1).map(cornersOf);
}

function cornersOf(row: Row): Point[] {
  return Array.from({ length: Math.max(0, (row.length - 1) >> 1) }, (_, k) => ({ North: row[2 * k + 1] ?? 0, East: row[2 * k + 2] ?? 0 }));
}

/** The path that was flown by a time. */
export function trailBy({ track }: Film, at: number): Point[] {
  return track.slice(0, rowAt(track, at) + 1).map((row) => ({ North: row[1] ?? 0, East: row[2] ?? 0 }));
}

function pointOf([north = 0, east = 0]: readonly number[]): Point {
  return { North: north, East: east };
}

/** "45 of 98 stalls seen at this moment"; `all`: 0 where their number is not known. */
export function seenWords({ free, taken, unknown }: Instant, all: number): string {
  const seen = free + taken + unknown;
  return all > 0 ? say("film-seen-of", { seen, all: Math.max(all, seen) }) : say("film-seen", { seen });
}
