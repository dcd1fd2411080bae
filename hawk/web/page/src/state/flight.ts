import { LocalPlane } from "../fence/plane.ts";
import type { FenceCorner, FenceSetup, Heartbeat, LogEntry, Point, Welcome } from "../protocol.ts";
import { afterUpdate, NO_SECTIONS } from "./flown-sections.ts";

export interface LogLine {
  key: string;
  /** UTC, ISO 8601. */
  time: string;
  level: LogEntry["Level"];
  text: string;
  details: string;
  /** What the drone has worded of the text. */
  quoted?: string;
}

/** One point of the plots: seconds of this page and of the daemon, height in metres, battery in per cent. */
export interface Sample {
  at: number;
  theirs: number;
  height: number | null;
  battery: number | null;
}

const LINES = 200;
const SAMPLES = 1800;
const TRAIL = 5000;

/** What the drone last said, and what this page remembers of the flight. Times are seconds of this page's clock. */
export class Flight {
  welcome: Welcome | null = null;
  heartbeat: Heartbeat | null = null;
  /** When the last heartbeat arrived. */
  heardAt: number | null = null;
  /** Seconds between the last two heartbeats. */
  gap = 0;
  lines: LogLine[] = [];
  trail: Point[] = [];
  samples: Sample[] = [];
  /** When the motors stopped after a flight that this page saw, UTC. */
  landedAt: string | null = null;
  /** Seconds in the air of the last flight that is known. */
  airTime: number | null = null;

  /** The fence that the next Arm puts in force, as last reported. */
  fenceSetup: FenceSetup | null = null;
  /** Sections of the lot that is flown over, as the drone counts them. */
  sections = NO_SECTIONS;
  /** Where the map lies on Earth; before the first arm around where the drone was first heard to be. */
  plane: LocalPlane | null = null;

  private fresh = false;
  private localLines = 0;

  /** The server answered: it will send messages, trail and sections again from the beginning. */
  greet(welcome: Welcome): void {
    this.welcome = welcome;
    this.fresh = true;
  }

  hear(heartbeat: Heartbeat, at: number): void {
    if (this.fresh) this.forgetSent();
    this.gap = this.heardAt === null ? 0 : Math.min(at - this.heardAt, 1);
    this.watchLanding(heartbeat);
    this.heartbeat = heartbeat;
    this.heardAt = at;
    this.fenceSetup = heartbeat["Fence Setup"] ?? this.fenceSetup;
    this.sections = afterUpdate(this.sections, heartbeat.Sections);
    this.setPlane(heartbeat);
    if (heartbeat.Messages.length > 0) this.addLines(heartbeat.Messages.map(line));
    const before = heartbeat["Trail Start"] ? [] : this.trail;
    if (heartbeat.Trail.length > 0 || heartbeat["Trail Start"]) this.trail = [...before, ...heartbeat.Trail].slice(-TRAIL);
    this.sample(heartbeat, at);
    this.airTime = heartbeat["Flight Time"] ?? this.airTime;
  }

  /** Adds a line of this page's own, such as a lost link. */
  note(level: LogLine["level"], text: string, time: string, details = "", quoted = ""): void {
    this.localLines += 1;
    this.addLines([{ key: `page-${this.localLines}`, time, level, text, details, quoted }]);
  }

  private addLines(lines: LogLine[]): void {
    const all = [...lines.toReversed(), ...this.lines.filter((old) => !lines.some((line) => line.key === old.key))];
    this.lines = all.sort((a, b) => (a.time < b.time ? 1 : a.time > b.time ? -1 : 0)).slice(0, LINES);
  }

  private forgetSent(): void {
    this.fresh = false;
    this.trail = [];
    this.sections = NO_SECTIONS;
    this.lines = this.lines.filter((line) => line.key.startsWith("page-"));
  }

  private setPlane({ Datum, Latitude, Longitude }: Heartbeat): void {
    const [north, east] = Datum ?? [];
    const known: FenceCorner | null = north === undefined || east === undefined ? null : { Latitude: north, Longitude: east };
    const here = Latitude === null || Longitude === null ? null : { Latitude, Longitude };
    const origin = known ?? this.plane?.origin ?? here ?? this.fenceSetup?.Corners[0];
    if (!origin) return;
    const { origin: before } = this.plane ?? {};
    if (before?.Latitude !== origin.Latitude || before.Longitude !== origin.Longitude) this.plane = new LocalPlane(origin);
  }

  private watchLanding(heartbeat: Heartbeat): void {
    const before = this.heartbeat;
    if (before?.Armed === true && heartbeat.Armed === false) this.landedAt = heartbeat.Utc;
    if (heartbeat.Armed === true) this.landedAt = null;
  }

  private sample(heartbeat: Heartbeat, at: number): void {
    const last = this.samples.at(-1);
    if (last && at - last.at < 1) return;
    const next = { at, theirs: heartbeat.Time, height: heartbeat["Relative Altitude"], battery: heartbeat["Battery Percentage"] };
    this.samples = [...this.samples, next].slice(-SAMPLES);
  }
}

function line(entry: LogEntry): LogLine {
  return {
    key: `drone-${entry.Number}`,
    time: entry.Time,
    level: entry.Level,
    text: entry.Text,
    details: entry.Details,
    quoted: entry.Text,
  };
}

/** States in which the drone is in the air or about to be. */
const GROUNDED = new Set(["Idle", "Configure", "Arm"]);

export function isFlying(heartbeat: Heartbeat | null): boolean {
  if (!heartbeat) return false;
  if (heartbeat.Armed === false) return false;
  return !GROUNDED.has(heartbeat.State) && heartbeat.Landed !== "ON_GROUND";
}

/** Whether somebody must be able to steer: the motors are on, or may be. */
export function isSteered(heartbeat: Heartbeat | null): boolean {
  return heartbeat !== null && (heartbeat.Armed === true || isFlying(heartbeat));
}
