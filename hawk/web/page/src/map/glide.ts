import type { DroneMark } from "./flight-scene.ts";
import { turn } from "./geometry.ts";

/** Heartbeats come every 200 ms; the drone's mark glides from one place to the next in so long. */
const GLIDE_MS = 200;
const STEP_MS = 100;
/** Where the map turns with the drone it is all of the picture that moves. */
const TURNING_STEP_MS = 33;
/** Less is not to be seen: pixels and radians. */
const LEAST_PX = 0.5;
const LEAST_RAD = 0.02;

/** Where the drone's mark is between two heartbeats. */
export class Glide {
  shown: DroneMark | null = null;
  /** Whether the map turns with the mark. */
  turning = false;

  private target: DroneMark | null = null;
  private under: { from: DroneMark; began: number } | null = null;
  private timer = 0;
  private readonly moved: () => void;

  constructor(moved: () => void) {
    this.moved = moved;
  }

  get isGliding(): boolean {
    return this.under !== null;
  }

  /** Goes to a place; at once where nothing was shown or movement is not wanted. `resolution`: metres a pixel. */
  to(target: DroneMark | null, resolution: number, atOnce: boolean): void {
    const known = this.target !== null;
    this.target = target;
    if (atOnce || !this.shown || !target || !known) {
      this.shown = target;
      this.under = null;
      return;
    }
    const pixels = Math.hypot(target.north - this.shown.north, target.east - this.shown.east) / resolution;
    const turned = Math.abs(turn(0, target.yaw - this.shown.yaw, 1));
    if (pixels < LEAST_PX && turned < LEAST_RAD) return;
    this.under = { from: this.shown, began: performance.now() };
    if (this.timer === 0) this.wait();
  }

  stop(): void {
    clearTimeout(this.timer);
  }

  private wait(): void {
    this.timer = window.setTimeout(this.step, this.turning ? TURNING_STEP_MS : STEP_MS);
  }

  private readonly step = (): void => {
    this.timer = 0;
    const { target, under } = this;
    if (!under || !target) return;
    const share = Math.min(1, (performance.now() - under.began) / GLIDE_MS);
    this.shown = between(under.from, target, share);
    if (share < 1) this.wait();
    else this.under = null;
    this.moved();
  };
}

function between(from: DroneMark, to: DroneMark, share: number): DroneMark {
  return {
    north: from.north + (to.north - from.north) * share,
    east: from.east + (to.east - from.east) * share,
    yaw: turn(from.yaw, to.yaw, share),
  };
}
