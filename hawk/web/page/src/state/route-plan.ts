import { type Answer, isByDrone, reasonOf } from "../link/commands.ts";
import type { Command, Point } from "../protocol.ts";
import { say } from "../words/say.ts";

export type RouteState = "none" | "asking" | "known" | "refused";

/** The route of an Autonomous Move to the place that is asked about. Only the last question is answered. */
export class RoutePlan {
  state: RouteState = "none";
  points: readonly Point[] = [];
  metres: number | null = null;
  /** Reason why there is no route. */
  reason = "";
  /** The same, where the drone has worded it, without the fields that it names first. */
  quoted = "";

  private asked = 0;
  private readonly send: (command: Command) => Promise<Answer>;
  private readonly changed: () => void;

  constructor(send: (command: Command) => Promise<Answer>, changed: () => void) {
    this.send = send;
    this.changed = changed;
  }

  async ask(target: Point): Promise<void> {
    this.clear();
    this.state = "asking";
    const number = this.asked;
    const answer = await this.send({ Type: "Route Request", X: target.North, Y: target.East, Frame: "Map" });
    if (number !== this.asked) return;
    if (answer.Type === "Route" && answer.Refused === null && answer.Points.length > 0) {
      this.state = "known";
      this.points = answer.Points;
      this.metres = answer.Length;
    } else {
      this.state = "refused";
      const reason = answer.Type === "Route" ? answer.Refused : answer.Type === "Ack" ? reasonOf(answer) : null;
      this.reason = reason ?? say("no-route");
      this.quoted = reason !== null && isByDrone(answer) ? reason.replace(/^X, Y: /, "") : "";
    }
    this.changed();
  }

  /** Nothing is asked about any longer. */
  clear(): void {
    this.asked += 1;
    this.state = "none";
    this.points = [];
    this.metres = null;
    this.reason = this.quoted = "";
  }
}
