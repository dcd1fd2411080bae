import type { Sample } from "./flight.ts";

type Storage = Pick<globalThis.Storage, "getItem" | "setItem">;

const KEY = "hawk-plots";
/** Older ones are not drawn on, seconds. */
const OLDEST_S = 1800;
/** The starts of two daemons' clocks are farther apart, seconds; a message takes less to arrive. */
const SAME_START_S = 3;
/** Written so often at most, seconds: what a browser that dies may lose. */
const EVERY_S = 10;

interface Stored {
  /** When the daemon's clock began, by this computer's time of day, seconds. */
  start: number;
  /** Daemon's time in seconds, height in metres, battery in per cent. */
  samples: [number, number | null, number | null][];
}

/** A moment on all three clocks: this page's seconds, the daemon's seconds, time of day in milliseconds. */
export interface Moment {
  at: number;
  theirs: number;
  wall: number;
  /** Seconds of the daemon in one of ours. */
  rate: number;
}

/** Keeps the plots of a flight over a reload of the page, and only of the daemon that still runs. */
export class PlotHistory {
  private keptAt: number | null = null;

  private readonly storage: Storage;

  constructor(storage: Storage) {
    this.storage = storage;
  }

  /** The samples of before, at their own ages and with a gap after them; none of another start of the daemon. */
  read(now: Moment): Sample[] {
    const stored = parse(this.storage);
    if (!stored || Math.abs(stored.start - startOf(now)) > SAME_START_S) return [];
    const at = (theirs: number): number => now.at - (now.theirs - theirs) / now.rate;
    const old = stored.samples
      .filter(([theirs]) => theirs <= now.theirs && now.at - at(theirs) <= OLDEST_S)
      .map(([theirs, height, battery]) => ({ at: at(theirs), theirs, height, battery }));
    const last = old.at(-1);
    return last ? [...old, { ...last, at: last.at + 0.1, height: null, battery: null }] : [];
  }

  /** Stores them, unless that was done a moment ago. */
  keep(samples: readonly Sample[], now: Moment): void {
    if (this.keptAt !== null && now.at - this.keptAt < EVERY_S) return;
    this.keptAt = now.at;
    const round = (value: number | null): number | null => (value === null ? null : Math.round(value * 10) / 10);
    const stored: Stored = {
      start: startOf(now),
      samples: samples.map(({ theirs, height, battery }) => [Math.round(theirs * 10) / 10, round(height), round(battery)]),
    };
    try {
      this.storage.setItem(KEY, JSON.stringify(stored));
    } catch {
      return; // a browser that keeps nothing is no error
    }
  }
}

function startOf({ wall, theirs, rate }: Moment): number {
  return wall / 1000 - theirs / rate;
}

function parse(storage: Storage): Stored | null {
  try {
    const stored = JSON.parse(storage.getItem(KEY) ?? "null") as Partial<Stored> | null;
    if (typeof stored?.start !== "number" || !Array.isArray(stored.samples)) return null;
    return { start: stored.start, samples: stored.samples.filter(isSample) };
  } catch {
    return null;
  }
}

function isSample(value: unknown): value is Stored["samples"][number] {
  if (!Array.isArray(value) || value.length !== 3 || typeof value[0] !== "number") return false;
  return value.slice(1).every((each) => each === null || typeof each === "number");
}
