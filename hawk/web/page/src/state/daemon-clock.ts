const WINDOW = 40;
const SETTLED_S = 2;

/** Estimates the daemon's clock from heartbeats: it may run faster than ours against a simulated drone. */
export class DaemonClock {
  private readonly samples: { ours: number; theirs: number }[] = [];

  /** Takes a heartbeat's time (seconds of the daemon) that arrived at `ours` (seconds of this page). */
  add(ours: number, theirs: number): void {
    const last = this.samples.at(-1);
    if (last && (theirs < last.theirs || ours - last.ours > 10)) this.samples.length = 0;
    this.samples.push({ ours, theirs });
    if (this.samples.length > WINDOW) this.samples.shift();
  }

  /** Seconds of the daemon that pass in one of ours. */
  get rate(): number {
    const first = this.samples[0];
    const last = this.samples.at(-1);
    if (!first || !last || last.ours - first.ours < SETTLED_S) return 1;
    const rate = (last.theirs - first.theirs) / (last.ours - first.ours);
    return Math.abs(rate - 1) < 0.1 ? 1 : rate;
  }

  /** The daemon's time at `ours`, or null before the first heartbeat. The least delayed sample counts. */
  at(ours: number): number | null {
    if (this.samples.length === 0) return null;
    const rate = this.rate;
    return Math.max(...this.samples.map((sample) => sample.theirs + (ours - sample.ours) * rate));
  }
}
