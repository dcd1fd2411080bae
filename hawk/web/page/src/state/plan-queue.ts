import type { Editor } from "../link/api.ts";
import { type Done, fetchPlan, postPlan, type Refusal, UNANSWERED } from "../link/plan.ts";
import type { Timers } from "../link/socket.ts";
import type { Operation } from "../plan/values.ts";

/** What a person asked for: an operation, or to undo or do again. */
export type Step = { path: "plan"; operation: Operation } | { path: "plan/undo" | "plan/redo" };

interface Left {
  undo: number;
  redo: number;
}

export interface QueueHooks {
  lot: () => string;
  /** Id of the edit; null while this person has none: steps wait. */
  edit: () => string | null;
  revision: () => number;
  done: (step: Step, answer: Done) => void;
  /** Returns whether the step is given up; one that is kept waits for `go`. */
  refused: (step: Step, refused: Refusal) => boolean;
  /** Whether an open edit is another person's, and how many steps of this one's are left. */
  mine: (edit: Editor | null) => { editor: Editor | null; left: Left };
  /** The drone does not answer, or does again. */
  heard: (answers: boolean) => void;
  timers: Timers;
}

/** After a step without an answer the store is asked again so much later. */
const AGAIN_MS = 1000;

/** Steps that wait for the store, in the order in which they were asked for: one after the other, none lost, none done twice. */
export class PlanQueue {
  private steps: Step[] = [];
  private running = false;
  private isSent = false;
  private readonly hooks: QueueHooks;
  private readonly idle: (() => void)[] = [];

  constructor(hooks: QueueHooks) {
    this.hooks = hooks;
  }

  get length(): number {
    return this.steps.length;
  }

  /** Operations that the store has not answered. */
  get operations(): Operation[] {
    return this.steps.flatMap((step) => (step.path === "plan" ? [step.operation] : []));
  }

  /** Moves of the same stalls that follow each other are one, until the first is sent. */
  add(step: Step): void {
    const last = this.steps.at(-1);
    const isSent = this.isSent && this.steps.length === 1;
    const joined = last && !isSent ? together(last, step) : null;
    if (joined) this.steps[this.steps.length - 1] = joined;
    else this.steps.push(step);
    void this.run();
  }

  /** Goes on with what waits. */
  go(): void {
    void this.run();
  }

  /** Gives up what waits; returns how many steps. */
  clear(): number {
    const given = this.steps.length;
    this.steps = [];
    return given;
  }

  /** Resolves when nothing waits, or what waits cannot go on. */
  settled(): Promise<void> {
    if (!this.running) return Promise.resolve();
    return new Promise((resolve) => this.idle.push(resolve));
  }

  private async run(): Promise<void> {
    if (this.running) return;
    this.running = true;
    for (let step = this.steps[0]; step !== undefined; step = this.steps[0]) if (!(await this.take(step))) break;
    this.running = false;
    for (const resolve of this.idle.splice(0)) resolve();
  }

  /** Does the first step. Returns whether the next one may follow. */
  private async take(step: Step): Promise<boolean> {
    const edit = this.hooks.edit();
    if (edit === null) return false;
    this.isSent = true;
    const { path, ...asked } = step;
    const reply = await postPlan<Done>(this.hooks.lot(), path, { edit, ...asked });
    if (reply === UNANSWERED) return this.wait(step);
    this.isSent = false;
    this.hooks.heard(true);
    if ("done" in reply) return this.finish(step, reply.done);
    return this.giveUp(step, reply.refused);
  }

  private finish(step: Step, answer: Done): true {
    if (this.steps[0] === step) this.steps.shift();
    this.hooks.done(step, answer);
    return true;
  }

  /** Without an answer nobody knows whether it was done: the plan's revision shows it, as soon as the drone answers again. */
  private async wait(step: Step): Promise<boolean> {
    this.hooks.heard(false);
    const before = this.hooks.revision();
    for (;;) {
      await new Promise<void>((resolve) => void this.hooks.timers.after(AGAIN_MS, resolve));
      if (this.steps[0] !== step) return true;
      const plan = await fetchPlan(this.hooks.lot(), before);
      if (!plan) continue;
      this.hooks.heard(true);
      this.isSent = false;
      const { editor, left } = this.hooks.mine(plan.edit);
      if (editor) return this.giveUp(step, { message: "", editor, status: 0 });
      return plan.revision === before ? true : this.finish(step, { ...plan, ...after(step, left) });
    }
  }

  private giveUp(step: Step, refused: Refusal): boolean {
    const givenUp = this.hooks.refused(step, refused);
    if (givenUp && this.steps[0] === step) this.steps.shift();
    return givenUp;
  }
}

/** Steps that are left to undo and to do again after one. */
function after({ path }: Step, { undo, redo }: Left): Left {
  if (path === "plan") return { undo: undo + 1, redo: 0 };
  return path === "plan/undo" ? { undo: undo - 1, redo: redo + 1 } : { undo: undo + 1, redo: redo - 1 };
}

/** Two steps as one; null where they are two. */
function together(first: Step, second: Step): Step | null {
  if (first.path !== "plan" || second.path !== "plan") return null;
  const [one, other] = [first.operation, second.operation];
  if (one.do !== "move" || other.do !== "move" || !("stalls" in one) || !("stalls" in other)) return null;
  const same = one.stalls.length === other.stalls.length && one.stalls.every((id, index) => other.stalls[index] === id);
  if (!same) return null;
  return { path: "plan", operation: { ...one, north: one.north + other.north, east: one.east + other.east } };
}
