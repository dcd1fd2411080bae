import type { PlanPreview } from "../api.ts";
import { type Done, postPlan, previewPlan, type Reply, UNANSWERED } from "../link/plan.ts";
import { say } from "../words/say.ts";

/** The edit of a plan that a file is imported into. */
export interface ImportedInto {
  readonly lot: { readonly id: string } | null;
  /** The person's edit, which is asked for where there is none; null without one. */
  edit(): Promise<{ readonly edit: string } | null>;
  /** Resolves when no step waits for the store. */
  settled(): Promise<void>;
  imported(answer: Done): void;
  drawAgain(): void;
}

/** An owner's plan from a file: its preview, and the choices about it. */
export class PlanImport {
  file: File | null = null;
  preview: PlanPreview | null = null;
  /** Why the file cannot be used, or the plan not be taken; in the store's words, or those of the page. */
  problem = "";
  /** The drone reads the file, or takes the plan. */
  busy = false;
  private readonly into: ImportedInto;

  constructor(into: ImportedInto) {
    this.into = into;
  }

  /** Shows what a file would change. Changes that wait for the store are done before. */
  async read(file: File, choices = new URLSearchParams()): Promise<void> {
    const { lot } = this.into;
    if (!lot || this.busy) return;
    Object.assign(this, { file, preview: null });
    await this.work(async () => {
      const reply = await previewPlan(lot.id, file, choices);
      if (this.file === file && reply !== UNANSWERED && "done" in reply) this.preview = reply.done;
      return reply;
    });
  }

  /** Takes the plan that is shown: one step, which is undone as others are. */
  async take(): Promise<void> {
    const { preview, into } = this;
    const { lot } = into;
    if (!lot || !preview || this.busy) return;
    const own = await into.edit();
    if (!own) return;
    await this.work(async () => {
      const asked = { edit: own.edit, uncertain: !preview.placed.is_certain };
      const reply = await postPlan<Done>(lot.id, `plan/import/${preview.token}/take`, asked);
      if (reply !== UNANSWERED && "done" in reply) {
        this.drop();
        into.imported(reply.done);
      }
      return reply;
    });
  }

  /** Forgets the file. */
  drop(): void {
    Object.assign(this, { file: null, preview: null, problem: "" });
    this.into.drawAgain();
  }

  private async work(ask: () => Promise<Reply<unknown>>): Promise<void> {
    Object.assign(this, { busy: true, problem: "" });
    this.into.drawAgain();
    await this.into.settled();
    const reply = await ask();
    this.busy = false;
    if (reply === UNANSWERED) this.problem = say("file-unanswered");
    else if ("refused" in reply && this.file) this.problem = reply.refused.message;
    this.into.drawAgain();
  }
}
