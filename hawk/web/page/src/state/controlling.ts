import { type Answer, isByDrone } from "../link/commands.ts";
import type { Command, ControlCommand, Heartbeat } from "../protocol.ts";
import { doneByAnother } from "../words/control.ts";
import { say } from "../words/say.ts";
import { isFlying } from "./flight.ts";
import type { Toast } from "./toasts.ts";

export interface ControllingParts {
  /** Sends a command; a refusal is shown. */
  command: (command: Command, what: string) => Promise<boolean>;
  send: (command: Command) => Promise<Answer>;
  heartbeat: () => Heartbeat | null;
  /** The name that this browser keeps. */
  name: () => string | null;
  showToast: (toast: Toast) => void;
  note: (level: "ok" | "warning" | "info", text: string) => void;
  /** Reports the same by ear, where the browser allows it. */
  say: (text: string) => void;
  changed: () => void;
}

/** Control and names: asking, answering, giving back, and what others did meanwhile. */
export class Controlling {
  /** This operator wants to give control back in the air, and is asked first. */
  releasing = false;
  private readonly parts: ControllingParts;
  private before: Heartbeat | null = null;

  constructor(parts: ControllingParts) {
    this.parts = parts;
  }

  /** Takes control where that is possible, asks the one who has it otherwise. */
  async request(): Promise<void> {
    const heartbeat = this.parts.heartbeat();
    const { Controller = null, "Controller Lost": lost = false, "In Control": mine = false } = heartbeat ?? {};
    const due = heartbeat?.["Control Asked By"] === heartbeat?.["Own Name"] && heartbeat?.["Control Free In"] === 0;
    if (Controller !== null && !lost && !mine && !due) await this.control("Ask", say("ask-for-control"));
    else await this.control("Request", say("take-control"));
  }

  async withdraw(): Promise<void> {
    await this.control("Withdraw", say("withdraw"));
  }

  async answer(gives: boolean): Promise<void> {
    await this.control(gives ? "Give" : "Keep", gives ? say("give-control") : say("keep-control"));
  }

  /** Gives control back: on the ground at once, in the air after a question. */
  async release(): Promise<void> {
    if (!this.releasing && isFlying(this.parts.heartbeat())) {
      this.releasing = true;
      this.parts.changed();
      return;
    }
    this.keep();
    await this.control("Release", say("give-back-control"));
  }

  /** Does not give control back after all. */
  keep(): void {
    this.releasing = false;
    this.parts.changed();
  }

  /** Sends the drone the name that this browser keeps: after each connection, and when it changes. */
  async introduce(): Promise<void> {
    const name = this.parts.name() ?? "";
    const answer = await this.parts.send({ Type: "Name", Name: name === "" ? null : name });
    if (answer.Type === "Ack" && !answer.Accepted) this.parts.showToast({ level: "error", text: answer.Reason, quoted: isByDrone(answer) ? answer.Reason : "" });
  }

  /** Another connection: what was before it says nothing about what happens now. */
  greet(isOperator: boolean): void {
    this.before = null;
    if (isOperator && this.parts.name()) void this.introduce();
  }

  hear(now: Heartbeat): void {
    const before = this.before;
    this.before = now;
    if (!now["In Control"]) this.releasing = false;
    if (!before) return;
    const mine = now["In Control"];
    const done = mine ? doneByAnother(before, now) : null;
    if (done !== null) this.report("warning", done);
    const asker = now["Control Asked By"];
    if (mine && asker !== null && before["Control Asked By"] !== asker) {
      this.report("warning", say("asks-for-control", { name: asker }));
    }
    if (mine && !before["In Control"]) this.report("info", say("you-have-control-now"));
    if (!mine && before["In Control"] && now.Controller !== null && now["Control Taken By"] === null) {
      this.report("info", say("other-has-control", { name: now.Controller }));
    }
    if (now["Control Kept"] && !before["Control Kept"]) this.report("warning", keepsControl(now.Controller));
  }

  private async control(action: ControlCommand["Action"], what: string): Promise<void> {
    await this.parts.command({ Type: "Control", Action: action }, what);
  }

  private report(level: "warning" | "info", text: string): void {
    this.parts.showToast({ level, text });
    this.parts.note(level, text);
    this.parts.say(text);
  }
}

function keepsControl(name: string | null): string {
  return name === null ? say("operator-keeps-control") : say("other-keeps-control", { name });
}
