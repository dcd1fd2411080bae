import type { ReactiveController, ReactiveControllerHost } from "lit";
import type { Film } from "../api.ts";

/** A film is drawn so often while it plays, milliseconds: the drone's mark glides between. */
const DRAW_MS = 100;

/** Calls with the seconds since the call before until the answer is called. */
export type Every = (draw: (passed: number) => void) => () => void;

/** Where a film stands, and whether it goes on by itself. */
export class Player implements ReactiveController {
  at = 0;
  speed = 1;
  private seconds = 0;
  private name = "";
  /** What the address asked for last: another time is followed. */
  private asked = NaN;
  private stop: (() => void) | null = null;
  private since = 0;
  private readonly host: ReactiveControllerHost;
  private readonly every: Every;

  constructor(host: ReactiveControllerHost, every: Every) {
    this.host = host;
    this.every = every;
    host.addController(this);
  }

  hostDisconnected(): void {
    this.pause();
  }

  get isPlaying(): boolean {
    return this.stop !== null;
  }

  /** Takes a film, and where the address says that it stands. */
  film({ name, seconds }: Film, asked: number): void {
    if (this.name === name && asked === this.asked) return;
    Object.assign(this, { name, seconds, asked });
    this.at = this.within(asked);
  }

  seek(at: number): void {
    this.at = this.within(at);
    this.host.requestUpdate();
  }

  /** Sets the speed, and plays or stops; at the end it begins again. */
  play(speed: number, isOn: boolean): void {
    this.speed = speed;
    if (!isOn) this.pause();
    else if (this.stop === null) {
      if (this.at >= this.seconds) this.at = 0;
      this.stop = this.every((passed) => this.step(passed));
    }
    this.host.requestUpdate();
  }

  pause(): void {
    this.stop?.();
    this.stop = null;
    this.host.requestUpdate();
  }

  private step(passed: number): void {
    this.at = this.within(this.at + passed * this.speed);
    this.since += 1000 * passed;
    if (this.at >= this.seconds) this.pause();
    if (this.since < DRAW_MS) return;
    this.since = 0;
    this.host.requestUpdate();
  }

  private within(at: number): number {
    return Math.min(Math.max(0, at), this.seconds);
  }
}

/** At each frame of the browser. */
export function everyFrame(draw: (passed: number) => void): () => void {
  let before = performance.now();
  let asked = requestAnimationFrame(function next(now) {
    asked = requestAnimationFrame(next);
    draw(Math.min(1, Math.max(0, now - before) / 1000));
    before = now;
  });
  return () => cancelAnimationFrame(asked);
}
