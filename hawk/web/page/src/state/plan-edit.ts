import type { Closed, Opened } from "../api.ts";
import type { Editor } from "../link/api.ts";
import { type Done, fetchLot, fetchPlan, type PlannedLot, postPlan, type Refusal, UNANSWERED, WRONG_VALUE } from "../link/plan.ts";
import type { Timers } from "../link/socket.ts";
import { ShownPlan } from "../plan/shown-plan.ts";
import { inOrder, type Operation, partsOf, type PlanStall } from "../plan/values.ts";
import { say } from "../words/say.ts";
import { PlanQueue, type Step } from "./plan-queue.ts";
import { PlanDrawing } from "./plan-drawing.ts";
import { PlanImport } from "./plan-import.ts";

const POLL_MS = 2000;
/** Stalls that one operation may name. */
const MOST_NAMED = 1000;

export interface PlanHooks {
  /** The name under which this person edits. */
  who: () => string;
  changed: () => void;
  showToast: (text: string, level: "info" | "warning", quoted?: string) => void;
  timers: Timers;
}

/** Stalls that look otherwise now; null: all of the plan. */
export type Redrawn = ReadonlySet<string> | null;

/** The editor of a lot's plan: the edit of this person, what is chosen, what waits for the store, who else edits. */
export class PlanEditing {
  open = false;
  lot: PlannedLot | null = null;
  plan = new ShownPlan();
  readonly selection = new Set<string>();
  readonly drawing: PlanDrawing;
  /** A plan that comes from a file. */
  readonly incoming: PlanImport;
  /** This person's edit; null while the plan is looked at, while another one edits, and while it is being asked for. */
  own: Opened | null = null;
  /** Another person who edits. */
  other: Editor | null = null;
  /** What the store said last that prevented something; in its own words. */
  problem = "";
  /** The drone answers. */
  answers = true;
  closing = false;
  /** The name of a row is to be typed next. */
  naming = false;
  /** The plan is being read. */
  opening = false;
  private readonly hooks: PlanHooks;
  private readonly queue: PlanQueue;
  private readonly redraw = new Set<(redrawn: Redrawn) => void>();
  private opened = 0;
  private polling = false;
  /** This person has had an edit since the editor was opened: where it is lost, it is asked for by a press. */
  private hadEdit = false;
  private asking = false;

  constructor(hooks: PlanHooks) {
    this.hooks = hooks;
    this.drawing = new PlanDrawing(this);
    this.incoming = new PlanImport(this);
    this.queue = new PlanQueue({
      lot: () => this.lot?.id ?? "",
      edit: () => this.own?.edit ?? null,
      revision: () => this.plan.revision,
      done: (step, answer) => this.done(step, answer),
      refused: (step, refused) => this.refused(step, refused),
      mine: (edit) => ({ editor: edit && edit.who !== this.own?.who ? edit : null, left: this.own ?? { undo: 0, redo: 0 } }),
      heard: (answers) => this.heard(answers),
      timers: hooks.timers,
    });
  }

  /** Number of steps that the store has not answered. */
  get waiting(): number {
    return this.queue.length;
  }

  /** The plan is looked at, and nobody edits it: looking locks nothing, the first change asks for an edit. */
  get isLooking(): boolean {
    return this.open && this.own === null && this.other === null && !this.hadEdit;
  }

  /** Whether this person may change the plan now. */
  get mayEdit(): boolean {
    return (this.isLooking || (this.open && this.own !== null)) && !this.closing;
  }

  get chosen(): PlanStall[] {
    return inOrder([...this.selection].flatMap((id) => this.plan.get(id) ?? []));
  }

  /** Opens the editor of a lot; where another person edits it shows what that one does. */
  async begin(lotId: string): Promise<void> {
    this.opened += 1;
    const number = this.opened;
    this.opening = true;
    this.hooks.changed();
    const [lot, plan] = await Promise.all([fetchLot(lotId), fetchPlan(lotId, null)]);
    if (number !== this.opened) return;
    this.opening = false;
    if (!lot || !plan) {
      this.hooks.changed();
      this.hooks.showToast(say("plan-unanswered"), "warning");
      return;
    }
    this.queue.clear();
    Object.assign(this, { open: true, lot, plan: new ShownPlan(), own: null, other: null, hadEdit: false, problem: "", answers: true, closing: false });
    this.selection.clear();
    this.drawing.reset();
    this.incoming.drop();
    this.plan.take(plan, []);
    this.report(null);
    if (plan.edit !== null) await this.ask(false); // this person's, of before a reload, or another one's
    this.pollLater(number);
  }

  /** Takes the plan over from another person, or goes on after the edit was closed. */
  async ask(takeOver: boolean): Promise<void> {
    const { lot } = this;
    if (!lot || this.asking) return;
    this.asking = true;
    const reply = await postPlan<Opened>(lot.id, "edit", { who: this.hooks.who(), take_over: takeOver });
    this.asking = false;
    if (this.lot !== lot) return;
    this.hadEdit ||= reply !== UNANSWERED;
    if (reply === UNANSWERED) this.askLater(lot);
    else if ("done" in reply) {
      Object.assign(this, { own: reply.done, other: null, problem: "", answers: true });
      this.queue.go();
    } else {
      this.other = reply.refused.editor;
      this.problem = reply.refused.editor ? "" : reply.refused.message;
    }
    this.hooks.changed();
  }

  /** What was changed meanwhile waits for the edit. */
  private askLater(lot: PlannedLot): void {
    this.heard(false);
    if (this.queue.length > 0) this.hooks.timers.after(POLL_MS, () => void (this.lot === lot && this.own === null && this.ask(false)));
  }

  /** Returns this person's edit, and asks for one where the plan was only looked at; null without one. */
  async edit(): Promise<Opened | null> {
    if (this.isLooking) await this.ask(false);
    return this.own;
  }

  do(operation: Operation): void {
    if (!this.mayEdit) return;
    this.problem = "";
    this.queue.add({ path: "plan", operation });
    if (this.isLooking) void this.ask(false);
    const changed = this.plan.foresee(this.queue.operations, operation);
    if (operation.do === "remove") this.forget(changed);
    this.report(changed);
  }

  /** Does something with the stalls that are chosen, in parts that the store takes. */
  doChosen(make: (stalls: string[]) => Operation): void {
    const ids = this.chosen.map(({ id }) => id);
    for (let from = 0; from < ids.length; from += MOST_NAMED) this.do(make(ids.slice(from, from + MOST_NAMED)));
  }

  undo(): void {
    this.step("plan/undo");
  }

  redo(): void {
    this.step("plan/redo");
  }

  /** Chooses these stalls; `add`: besides those that are. */
  choose(ids: Iterable<string>, add = false): void {
    if (!add) this.selection.clear();
    for (const id of ids) this.selection.add(id);
    this.hooks.changed();
  }

  /** Chooses a stall besides the others, or no more. */
  toggle(id: string): void {
    if (!this.selection.delete(id)) this.selection.add(id);
    this.hooks.changed();
  }

  /** Lets the name of the chosen row be typed. */
  name(): void {
    this.naming = this.mayEdit && this.selection.size > 0;
    if (this.naming) this.hooks.changed();
  }

  /** Chooses the whole row of a name. */
  chooseRow(row: string, add = false): void {
    const members = [...this.plan.stalls.values()].filter(({ label }) => partsOf(label)?.row === row);
    this.choose(members.map(({ id }) => id), add);
  }

  /** Closes the edit: its version of the layout is final. What waits is done before. */
  async close(why: string): Promise<void> {
    const { lot } = this;
    if (!lot || this.closing) return;
    await this.queue.settled();
    if (!this.own || this.queue.length > 0) return;
    this.closing = true;
    this.hooks.changed();
    const reply = await postPlan<Closed>(lot.id, "edit/close", { edit: this.own.edit, why });
    this.closing = false;
    if (reply === UNANSWERED) this.heard(false);
    else if ("refused" in reply) this.problem = reply.refused.message;
    else {
      const { layout } = reply.done;
      this.hooks.showToast(layout === null ? say("plan-as-before") : say("plan-closed", { version: layout }), "info");
      this.leave();
    }
    this.hooks.changed();
  }

  /** Leaves the editor; the edit stays open. */
  leave(): void {
    this.opened += 1;
    const lost = this.queue.clear();
    if (lost > 0) this.hooks.showToast(say("plan-steps-lost", { steps: lost }), "warning");
    Object.assign(this, { open: false, opening: false, own: null, other: null, lot: null, plan: new ShownPlan() });
    this.selection.clear();
    this.drawing.reset();
    this.incoming.drop();
    this.report(null);
  }

  /** Leaves what is drawn, then what is chosen. Returns whether there was anything. */
  back(): boolean {
    if (!this.open) return false;
    if (this.incoming.file) {
      this.incoming.drop();
      return true;
    }
    if (this.drawing.back()) return true;
    if (this.selection.size === 0) return false;
    this.choose([]);
    return true;
  }

  /** Hears which stalls look otherwise; returns how to hear no more. */
  listen(redraw: (redrawn: Redrawn) => void): () => void {
    this.redraw.add(redraw);
    return () => void this.redraw.delete(redraw);
  }

  /** Resolves when no step waits, or those that wait cannot go on. */
  settled(): Promise<void> {
    return this.queue.settled();
  }

  /** The store did an operation, or took a plan from a file. */
  imported(answer: Done, operation: Operation | null = null): void {
    if (this.own) Object.assign(this.own, { undo: answer.undo, redo: answer.redo });
    const changed = this.plan.done(answer, this.queue.operations, operation);
    this.forget(answer.gone);
    this.report(changed);
  }

  /** What is drawn, or how, has changed. */
  drawAgain(): void {
    this.hooks.changed();
  }

  private step(path: "plan/undo" | "plan/redo"): void {
    if (!this.mayEdit || (this.own === null && this.queue.length === 0)) return;
    this.problem = "";
    this.queue.add({ path });
    this.hooks.changed();
  }

  private done(step: Step, answer: Done): void {
    this.imported(answer, step.path === "plan" ? step.operation : null);
  }

  /** A refusal of a value is said and the next step done; without an edit all steps wait until there is one again. */
  private refused(step: Step, { message, editor, status }: Refusal): boolean {
    const isOver = step.path !== "plan" && editor === null;
    if (status === WRONG_VALUE || isOver) {
      this.problem = message;
      const left = this.queue.operations.filter((each) => step.path !== "plan" || each !== step.operation);
      this.report(step.path === "plan" ? this.plan.foresee(left, step.operation) : new Set());
      return true;
    }
    this.own = null;
    this.other = editor;
    this.problem = editor ? "" : message;
    this.hooks.changed();
    return false;
  }

  private forget(ids: Iterable<string>): void {
    for (const id of ids) this.selection.delete(id);
  }

  private heard(answers: boolean): void {
    if (answers === this.answers) return;
    this.answers = answers;
    this.hooks.changed();
  }

  private report(redrawn: Redrawn): void {
    for (const each of this.redraw) each(redrawn);
    this.hooks.changed();
  }

  private pollLater(number: number): void {
    this.hooks.timers.after(POLL_MS, () => {
      if (number !== this.opened) return;
      void this.poll(number).then(() => this.pollLater(number));
    });
  }

  /** Sees what others changed, and who edits. The answers to own steps say the same: it is not asked while some wait. */
  private async poll(number: number): Promise<void> {
    if (!this.lot || this.polling || this.queue.length > 0) return;
    this.polling = true;
    const before = this.plan.revision;
    const change = await fetchPlan(this.lot.id, before);
    this.polling = false;
    if (number !== this.opened || this.queue.length > 0 || this.plan.revision !== before) return;
    this.heard(change !== null);
    if (!change) return;
    this.follow(change.edit);
    if (change.revision === before) return;
    const changed = this.plan.take(change, this.queue.operations);
    this.forget([...this.selection].filter((id) => !this.plan.get(id)));
    this.report(change.whole ? null : changed);
  }

  private follow(edit: Editor | null): void {
    const isOwn = this.own !== null && edit?.who === this.own.who;
    const other = isOwn ? null : edit;
    if (this.own && !isOwn) this.own = null;
    if (other?.who === this.other?.who && other?.since === this.other?.since) return;
    this.other = other;
    this.hooks.changed();
  }
}
