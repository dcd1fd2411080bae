/** A part that could not be read is asked for again after so long: nobody has to load the page again. */
const AGAIN_MS = 5000;

/** How each part is read: a file of its own, with what it shares with others. */
export const READING = {
  fly: () => import("../parts/fly.ts"),
  maps: () => import("../parts/maps.ts"),
  figures: () => import("../parts/figures.ts"),
  section: () => import("../ui/plan-section.ts"),
  fence: () => import("../parts/fence.ts"),
};

/** A part of the page that is read when it is wanted first. */
export class LatePart {
  state: "none" | "asked" | "there" | "failed" = "none";
  private readonly load: () => Promise<unknown>;
  private readonly changed: () => void;

  constructor(load: () => Promise<unknown>, changed: () => void) {
    this.load = load;
    this.changed = changed;
  }

  /** Asks for the part unless that was done. Returns whether it is there. */
  want(): boolean {
    if (this.state === "none") this.ask();
    return this.state === "there";
  }

  ask(): void {
    this.state = "asked";
    void this.load().then(
      () => this.become("there"),
      () => {
        this.become("failed");
        setTimeout(() => this.state === "failed" && this.ask(), AGAIN_MS);
      },
    );
  }

  private become(state: "there" | "failed"): void {
    this.state = state;
    this.changed();
  }
}
