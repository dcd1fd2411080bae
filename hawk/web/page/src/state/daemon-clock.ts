const WINDOW = 20;

/** The daemon's clock, from the times in heartbeats. Against a simulated drone it may run faster than ours. */
export class DaemonClock {
  /** Seconds of the daemon that pass in one of ours. */
  rate = 1;
  private samples: { ours: number; theirs: number }[] = [];

  /** Begins again: another connection, perhaps another daemon. */
  reset(rate: number): void {
    this.rate = rate;
    this.samples = [];
  }

  /** Takes a heartbeat's time (seconds of the daemon) that arrived at `ours` (seconds of this page). */
  add(ours: number, theirs: number): void {
    this.samples = [...this.samples, { ours, theirs }].slice(-WINDOW);
  }

  /** The daemon's time at `ours`, or null before the first heartbeat. The least delayed of the last ones counts. */
  at(ours: number): number | null {
    if (this.samples.length === 0) return null;
    return Math.max(...this.samples.map((sample) => sample.theirs + (ours - sample.ours) * this.rate));
  }

  /** Time of day, milliseconds, of the daemon's time `theirs`, when it is `wall` at `ours`; null before the first heartbeat. */
  timeOfDay(theirs: number, ours: number, wall: number): number | null {
    const now = this.at(ours);
    return now === null ? null : wall - ((now - theirs) / this.rate) * 1000;
  }
}
