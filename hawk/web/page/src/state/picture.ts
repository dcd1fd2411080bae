import type { DaemonClock } from "./daemon-clock.ts";

/** The picture that is shown, and how old its light is. Times are seconds of this page's clock. */
export class Picture {
  /** When it was shown; null before the first. */
  shownAt: number | null = null;
  private captureTime: number | null = null;
  private readonly clock: DaemonClock;

  constructor(clock: DaemonClock) {
    this.clock = clock;
  }

  /** `captureTime`: seconds of the daemon's clock. */
  shown(captureTime: number, at: number): void {
    this.captureTime = captureTime;
    this.shownAt = at;
  }

  /** Nothing is shown any more: what is not shown has no age. */
  left(): void {
    this.shownAt = null;
  }

  /** Seconds since the light of the last picture was caught; null before the first. */
  age(now: number): number | null {
    if (this.shownAt === null) return null;
    const waited = now - this.shownAt;
    const theirs = this.clock.at(now);
    if (theirs === null || this.captureTime === null) return waited;
    return Math.max(waited, (theirs - this.captureTime) / this.clock.rate);
  }
}
