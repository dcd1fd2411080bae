import { linkOf, type View } from "../words/view.ts";
import * as format from "../words/format.ts";
import { say } from "../words/say.ts";
import { isFlying } from "./flight.ts";

/** Per cent above what the flight home needs from which the battery counts as low, and above which it counts as well again. */
const LOW = 5;
const WELL = 15;

/** What must be heard by those who look elsewhere: a lost link, a low battery. Each is said once. */
export class Alarms {
  private lost = false;
  private low = false;

  /** Looks at the present view; returns what is to be said. */
  look(view: View): string[] {
    const said = this.link(view);
    const battery = this.battery(view);
    return battery === null ? said : [...said, battery];
  }

  private link(view: View): string[] {
    const lost = linkOf(view) === "lost" && isFlying(view.heartbeat);
    if (lost === this.lost) return [];
    this.lost = lost;
    if (lost) return [say("link-lost-note")];
    return linkOf(view) === "live" ? [say("link-back-note")] : [];
  }

  private battery(view: View): string | null {
    const charge = view.heartbeat?.["Battery Percentage"] ?? null;
    const home = view.heartbeat?.["Battery Needed Home"] ?? null;
    if (charge === null || home === null || !isFlying(view.heartbeat)) return null;
    if (charge - home > WELL) this.low = false;
    if (charge - home > LOW || this.low) return null;
    this.low = true;
    return say("battery-low", { percent: format.percent(charge) });
  }
}
