import { type Answer, isByDrone, reasonOf } from "../link/commands.ts";
import type { Timers } from "../link/socket.ts";
import type { Command } from "../protocol.ts";
import { say } from "../words/say.ts";

/** Cutting the motors: first a token is asked for, then it can be done. */
export interface Cutting {
  step: "asking" | "ready";
  token: string | null;
  problem: string;
  /** The drone's own words in it. */
  quoted?: string;
}

export interface MotorCutHooks {
  /** Sends a command; a refusal is shown. */
  command: (command: Command, what: string) => Promise<boolean>;
  send: (command: Command) => Promise<Answer>;
  /** Seconds of the daemon's clock in one of this page's. */
  rate: () => number;
  timers: Timers;
  changed: () => void;
}

/** The two steps by which the operator cuts the motors. */
export class MotorCut {
  /** The step that is open; null while there is none. */
  current: Cutting | null = null;
  private cancelTimer: (() => void) | null = null;
  private readonly hooks: MotorCutHooks;

  constructor(hooks: MotorCutHooks) {
    this.hooks = hooks;
  }

  /** First step: asks for the token. */
  async begin(): Promise<void> {
    const begun: Cutting = { step: "asking", token: null, problem: "" };
    this.current = begun;
    this.hooks.changed();
    const answer = await this.hooks.send({ Type: "Kill Request" });
    if (this.current !== begun) return;
    if (answer.Type === "Kill Token") {
      this.current = { step: "ready", token: answer.Token, problem: "" };
      // the drone sends seconds of its own clock, which a simulation lets run faster
      const validMs = (answer["Valid For"] / this.hooks.rate()) * 1000;
      this.cancelTimer = this.hooks.timers.after(validMs, () => this.expire());
    } else {
      const problem = reasonOf(answer) || say("cut-not-allowed");
      this.current = { step: "asking", token: null, problem, quoted: isByDrone(answer) ? problem : "" };
    }
    this.hooks.changed();
  }

  /** Second step, after the button was kept pressed: the token is used up whatever the answer. */
  async finish(): Promise<void> {
    const token = this.current?.token;
    this.end();
    if (token) await this.hooks.command({ Type: "Kill", Token: token }, say("cut-motors"));
  }

  end(): void {
    this.cancelTimer?.();
    this.cancelTimer = null;
    this.current = null;
    this.hooks.changed();
  }

  private expire(): void {
    this.current = { step: "asking", token: null, problem: say("cut-too-long") };
    this.hooks.changed();
  }
}
