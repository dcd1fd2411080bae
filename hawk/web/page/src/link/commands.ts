import type { Ack, Command, FenceCheck, KillToken, RouteAnswer } from "../protocol.ts";
import { say } from "../words/say.ts";
import type { Timers } from "./socket.ts";

/** A command without an answer for this time is reported as unanswered. */
export const ANSWER_MS = 5000;

/** A refusal of this page's own: the drone did not answer. */
export interface Unanswered extends Ack {
  ByPage: true;
}

export type Answer = Ack | Unanswered | FenceCheck | KillToken | RouteAnswer;

/** Reason of a refusal; empty where there is none. */
export function reasonOf(answer: Answer): string {
  return answer.Type === "Ack" ? answer.Reason : "";
}

/** Whether it is the drone that answered, in its own words. */
export function isByDrone(answer: Answer): boolean {
  return !("ByPage" in answer);
}

/** Sends commands and pairs each with its answer by Id. A command is never sent twice and never kept for later. */
export class Commands {
  private count = 0;
  private readonly waiting = new Map<string, { settle: (answer: Answer) => void; cancel: () => void }>();

  private readonly transmit: (text: string) => boolean;
  private readonly timers: Timers;

  constructor(
    transmit: (text: string) => boolean,
    timers: Timers,
  ) {
    this.transmit = transmit;
    this.timers = timers;
  }

  /** Sends one command. Always resolves: without a link or an answer with a refusal that says so. */
  send(command: Command): Promise<Answer> {
    this.count += 1;
    const id = `page-${this.count}`;
    if (!this.transmit(JSON.stringify({ ...command, Id: id }))) {
      return Promise.resolve(refusal(id, say("not-sent")));
    }
    return new Promise((resolve) => {
      const cancel = this.timers.after(ANSWER_MS, () =>
        this.answer(refusal(id, say("no-answer"))),
      );
      this.waiting.set(id, { settle: resolve, cancel });
    });
  }

  /** Hands an answer to its waiting command. */
  answer(answer: Answer): void {
    const waiting = this.waiting.get(String(answer.Id));
    if (!waiting) return;
    this.waiting.delete(String(answer.Id));
    waiting.cancel();
    waiting.settle(answer);
  }

  /** The link was lost: nobody will answer any more. */
  abandon(): void {
    for (const id of [...this.waiting.keys()]) {
      this.answer(refusal(id, say("link-lost-before-answer")));
    }
  }
}

function refusal(id: string, reason: string): Unanswered {
  return { Type: "Ack", Id: id, Accepted: false, Reason: reason, ByPage: true };
}
