import { say } from "../words/say.ts";
import type { View } from "../words/view.ts";

/** Seconds of the drone's clock in which a page may be hidden in a task before it warns; twice as long, and the drone holds. */
const WARNS_S = 15;

const TASKS: ReadonlySet<string> = new Set(["Autonomous Explore", "Autonomous Move", "Compulsive Move"]);

/** What the one in control must hear of a hidden page: that the drone will hold. That it did, the drone reports. */
export class HiddenPage {
  private since: number | null = null;

  /** Looks whether the page is hidden, at a time in seconds of this page; returns what is to be reported, else null. */
  look(hidden: boolean, { heartbeat, welcome }: View, at: number): string | null {
    if (!hidden || heartbeat?.["In Control"] !== true || !TASKS.has(heartbeat.State)) {
      this.since = null;
      return null;
    }
    this.since ??= at;
    if ((at - this.since) * (welcome?.Speed ?? 1) < WARNS_S) return null;
    this.since = Infinity;
    return say("hidden-warning");
  }
}
