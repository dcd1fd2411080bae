/** A press counts only while the page looks at it at least this often: a busy page learns too late that it was let go. */
const GAP_MS = 250;
const LOOK_MS = 50;
/** So long after its end a press waits for a release that was made before, and is only now reported. */
const LATE_MS = 50;

export interface PressEvents {
  /** How much of it is done, 0 to 1. */
  progress: (share: number) => void;
  done: () => void;
  /** The page was too busy to follow it: it does not count. */
  missed: () => void;
}

/**
 * Watches a control that must be kept pressed, by pointer or by Enter or space.
 *
 * Counts from the times at which the operator pressed and let go, not from those at which the page came to handle it.
 */
export class Press {
  private timer: ReturnType<typeof setInterval> | null = null;
  private frame = 0;
  private began = 0;
  private looked = 0;
  private reached: number | null = null;

  private readonly milliseconds: number;
  private readonly events: PressEvents;

  constructor(milliseconds: number, events: PressEvents) {
    this.milliseconds = milliseconds;
    this.events = events;
  }

  get running(): boolean {
    return this.timer !== null;
  }

  /** Begins with a pointer that goes down or a key; a key that repeats itself was pressed for something else. */
  begin(event: Event): void {
    if (this.running || (event as Partial<KeyboardEvent>).repeat === true) return;
    const now = performance.now();
    if (now - event.timeStamp > GAP_MS) {
      this.events.missed();
      return;
    }
    this.began = event.timeStamp;
    this.looked = now;
    this.reached = null;
    // frames to draw by, a timer to count by: a slow screen is no busy page
    this.timer = setInterval(this.look, LOOK_MS);
    this.frame = requestAnimationFrame(this.draw);
    window.addEventListener("blur", this.leave);
    document.addEventListener("visibilitychange", this.leave);
  }

  /** Lets go: that counts when it was pressed for long enough and the page followed until now. */
  release(event: Event): void {
    if (!this.running) return;
    const isFollowed = performance.now() - this.looked <= GAP_MS;
    const isEnough = event.timeStamp - this.began >= this.milliseconds;
    this.end();
    if (!isFollowed) this.events.missed();
    else if (isEnough) this.events.done();
  }

  /** Ends it, whatever came of it. */
  end(): void {
    if (this.timer === null) return;
    clearInterval(this.timer);
    cancelAnimationFrame(this.frame);
    this.timer = null;
    window.removeEventListener("blur", this.leave);
    document.removeEventListener("visibilitychange", this.leave);
    this.events.progress(0);
  }

  /** Without the focus nobody would report that it was let go. */
  private readonly leave = (): void => this.end();

  private readonly draw = (): void => {
    this.look();
    if (this.running) this.frame = requestAnimationFrame(this.draw);
  };

  private readonly look = (): void => {
    const now = performance.now();
    if (now - this.looked > GAP_MS) {
      this.end();
      this.events.missed();
      return;
    }
    this.looked = now;
    const share = (now - this.began) / this.milliseconds;
    this.events.progress(Math.min(1, share));
    if (share < 1) return;
    this.reached ??= now;
    if (now - this.reached < LATE_MS) return;
    this.end();
    this.events.done();
  };
}

/** Whether a key event presses a control. */
export function isPressKey(event: KeyboardEvent): boolean {
  return event.key === "Enter" || event.key === " ";
}
