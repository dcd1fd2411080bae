/** Watches a control that must be kept pressed, by pointer or by Enter or space. */
export class Press {
  private frame = 0;
  private began = 0;

  private readonly milliseconds: number;
  private readonly progress: (share: number) => void;
  private readonly done: () => void;

  constructor(
    milliseconds: number,
    progress: (share: number) => void,
    done: () => void,
  ) {
    this.milliseconds = milliseconds;
    this.progress = progress;
    this.done = done;
  }

  get running(): boolean {
    return this.frame !== 0;
  }

  begin(): void {
    if (this.running) return;
    this.began = performance.now();
    this.frame = requestAnimationFrame(this.step);
  }

  /** Lets go: that counts when it was pressed for long enough, though the page was too busy to draw a frame since. */
  release(): void {
    if (!this.running) return;
    const isEnough = performance.now() - this.began >= this.milliseconds;
    this.end();
    if (isEnough) this.done();
  }

  /** Ends it, whatever came of it. */
  end(): void {
    cancelAnimationFrame(this.frame);
    this.frame = 0;
    this.progress(0);
  }

  private readonly step = (): void => {
    const share = (performance.now() - this.began) / this.milliseconds;
    if (share >= 1) {
      this.end();
      this.done();
      return;
    }
    this.progress(share);
    this.frame = requestAnimationFrame(this.step);
  };
}

/** Whether a key event presses a control. */
export function isPressKey(event: KeyboardEvent): boolean {
  return event.key === "Enter" || event.key === " ";
}
