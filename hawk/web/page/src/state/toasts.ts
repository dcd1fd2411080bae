import type { Timers } from "../link/socket.ts";

/** A line over the map that goes by itself. */
export interface Toast {
  text: string;
  level: "warning" | "error" | "info";
  /** The drone's own words in it. */
  quoted?: string;
}

const SHOWN_MS = 8000;

/** The toast on the map: the newest, for some seconds. */
export class Toasts {
  shown: Toast | null = null;
  private cancelTimer: (() => void) | null = null;
  private readonly timers: Timers;
  private readonly changed: () => void;

  constructor(timers: Timers, changed: () => void) {
    this.timers = timers;
    this.changed = changed;
  }

  show(toast: Toast): void {
    this.cancelTimer?.();
    this.shown = toast;
    this.cancelTimer = this.timers.after(SHOWN_MS, () => this.dismiss());
    this.changed();
  }

  dismiss(): void {
    this.cancelTimer?.();
    this.cancelTimer = null;
    this.shown = null;
    this.changed();
  }
}
