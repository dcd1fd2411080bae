import { FenceDraft } from "../fence/draft.ts";
import { type FenceFile, FenceFileError, readFence, writeFence } from "../fence/geojson.ts";
import { type Answer, isByDrone, reasonOf } from "../link/commands.ts";
import type { Timers } from "../link/socket.ts";
import { say } from "../words/say.ts";
import { Drawing } from "./drawing.ts";
import type { Command, FenceCheck, FenceCorner, FenceSetup, Heartbeat } from "../protocol.ts";

/** After a change the drone is asked so much later: a corner that is dragged changes with every frame. */
const ASK_MS = 150;

/** Heartbeats after an answer until one is sure to have been made after the command was acted on. */
const SETTLED = 2;

/** What the drone says about the fence as it is drawn. */
export type Verdict =
  | { about: "nothing" }
  | { about: "asking" }
  | { about: "problem"; text: string }
  | { about: "good"; check: FenceCheck };

export interface FenceHooks {
  send: (command: Command) => Promise<Answer>;
  changed: () => void;
  /** `quoted`: what the drone said, in its own words. */
  showToast: (text: string, level: "info" | "warning", quoted?: string) => void;
  timers: Timers;
}

/** The fence editor: what is drawn, what the drone says about it, and keeping it. */
export class FenceEditing extends Drawing {
  saving = false;
  verdict: Verdict = { about: "nothing" };

  private readonly hooks: FenceHooks;
  /** Whether a problem stands in the drone's own words. */
  private isDroneProblem = false;
  private asked = 0;
  private cancelAsk: (() => void) | null = null;
  /** Heartbeats since the drone began to save; null while it does not. */
  private beats: number | null = null;

  constructor(hooks: FenceHooks) {
    super();
    this.hooks = hooks;
  }

  /** What the drone says of the drawing, in its own words. */
  get quoted(): string[] {
    if (this.verdict.about === "good") return this.verdict.check.Notes;
    return this.verdict.about === "problem" && this.isDroneProblem ? [this.verdict.text] : [];
  }

  /** Opens the editor with what was left unsaved, else with the fence that the drone keeps (a circle is not edited). */
  begin(setup: FenceSetup): void {
    this.start(new FenceDraft(setup.Corners, setup.Ceiling, setup.Zones));
    this.ask();
  }

  typeCeiling(ceiling: string): void {
    this.draft?.typeCeiling(ceiling);
    this.ask();
  }

  /** Takes a file's fence over; a file without one is reported and changes nothing. */
  override import(text: string): boolean {
    try {
      const file = readFence(text);
      this.draw(file.corners, file.ceiling === null ? undefined : String(file.ceiling), file.zones);
      return true;
    } catch (error) {
      if (!(error instanceof FenceFileError)) throw error;
      this.hooks.showToast(error.message, "warning");
      return false;
    }
  }

  /** GeoJSON of what is drawn; null while there is nothing. */
  override export(): string | null {
    const draft = this.draft;
    if (!draft?.isDrawn) return null;
    const zones = draft.zones.map((zone) => [...zone]);
    const file: FenceFile = { corners: [...draft.corners], zones, ceiling: draft.ceilingMetres };
    return writeFence(file);
  }

  /** Asks the drone to keep the fence; `hear` learns whether it did. A refusal is shown and the editor stays open. */
  async save(): Promise<void> {
    const [draft, ceiling] = [this.draft, this.draft?.ceilingMetres];
    if (!draft?.isDrawn || ceiling == null || this.saving) return;
    this.saving = true;
    this.hooks.changed();
    const answer = await this.hooks.send({ Type: "Set Fence", ...drawn(draft), Ceiling: ceiling });
    if (answer.Type === "Ack" && answer.Accepted) this.beats = 0;
    else this.notSaved(reasonOf(answer), isByDrone(answer));
  }

  /** The drone says that it plans with another fence once that is on its disk; until then the draft is kept. */
  hear(heartbeat: Heartbeat): void {
    if (this.beats === null) return;
    this.beats += 1;
    if (heartbeat["Fence Setup"] !== null) {
      this.beats = null;
      this.saving = false;
      this.cancel();
      this.hooks.showToast(say("fence-saved"), "info");
    } else if (heartbeat.State === "Idle" && this.beats > SETTLED) this.notSaved(heartbeat.Detail, true);
  }

  private notSaved(reason: string, byDrone: boolean): void {
    this.beats = null;
    this.saving = false;
    this.hooks.showToast(reason === "" ? say("fence-not-saved") : reason, "warning", byDrone ? reason : "");
    this.hooks.changed();
  }

  protected override close(): void {
    super.close();
    this.asked += 1;
    this.cancelAsk?.();
    this.verdict = { about: "nothing" };
  }

  protected override redrawn(): void {
    this.ask();
  }

  protected override changed(): void {
    this.hooks.changed();
  }

  protected override showToast(text: string, level: "info" | "warning"): void {
    this.hooks.showToast(text, level);
  }

  private ask(): void {
    this.cancelAsk?.();
    this.asked += 1;
    const number = this.asked;
    const [draft, ceiling] = [this.draft, this.draft?.ceilingMetres];
    this.isDroneProblem = false;
    if (!draft?.isDrawn) this.verdict = { about: "nothing" };
    else if (ceiling == null) this.verdict = { about: "problem", text: say("ceiling-no-number") };
    else {
      this.verdict = { about: "asking" };
      const command: Command = { Type: "Check Fence", ...drawn(draft), Ceiling: ceiling };
      this.cancelAsk = this.hooks.timers.after(ASK_MS, () => void this.check(command, number));
    }
    this.hooks.changed();
  }

  /** An answer about a drawing that has changed since is dropped. */
  private async check(command: Command, number: number): Promise<void> {
    const answer = await this.hooks.send(command);
    if (number !== this.asked) return;
    this.isDroneProblem = isByDrone(answer);
    if (answer.Type === "Fence Check") {
      this.verdict = answer.Problem === "" ? { about: "good", check: answer } : { about: "problem", text: answer.Problem };
    } else this.verdict = { about: "problem", text: reasonOf(answer) || say("fence-not-checked") };
    this.hooks.changed();
  }
}

function drawn(draft: FenceDraft): { Corners: FenceCorner[]; Zones: FenceCorner[][] } {
  return { Corners: [...draft.corners], Zones: draft.zones.map((zone) => [...zone]) };
}
