import type { LotFrame } from "../plan/frame.ts";
import type { Kind, PlanStall } from "../plan/values.ts";
import type { PlanDrawing } from "../state/plan-drawing.ts";
import type { PlanEditing } from "../state/plan-edit.ts";
import * as format from "./format.ts";
import { pointer, say, sentences } from "./say.ts";

export interface PlanWords {
  title: string;
  counts: string;
  /** Who edits, and what waits. */
  state: string;
  /** What to do on the map. */
  hint: string;
}

/** The words of the plan's panel. */
export function planWords(editing: PlanEditing, frame: LotFrame["by"], touch: boolean): PlanWords {
  const { stalls, summary } = editing.plan;
  return {
    title: say("plan-of", { name: editing.lot?.name ?? "" }),
    counts: say("plan-counts", { stalls: stalls.size, confirmed: summary.confirmed, guessed: summary.guessed }),
    state: sentences(whoEdits(editing), waits(editing), placed(frame)),
    hint: editing.mayEdit ? hintOf(editing.drawing, touch) : "",
  };
}

/** Whose the labels of some stalls are. */
export function labelWords(stalls: readonly PlanStall[]): string {
  return say("plan-labels-are", { stalls: stalls.length, guessed: stalls.filter((each) => !each.is_named).length });
}

export function kindWords(kind: Kind): string {
  return say(kind === "" ? "plan-kind-normal" : `plan-kind-${kind}`);
}

function whoEdits({ own, other, problem, isLooking }: PlanEditing): string {
  if (isLooking) return say("plan-nobody-edits");
  if (other) return say("plan-other-edits", { who: other.who, time: format.clock(other.since) });
  if (own) return say("plan-you-edit", { time: format.clock(own.since) });
  return problem === "" ? say("plan-opening") : say("plan-no-edit");
}

function waits({ answers, waiting, own, isLooking }: PlanEditing): string {
  const stuck = !answers || (own === null && !isLooking);
  return sentences(answers ? "" : say("plan-no-answer"), stuck && waiting > 0 ? say("plan-waits", { steps: waiting }) : "");
}

function placed(frame: LotFrame["by"]): string {
  return frame === "survey" ? "" : say(frame === "gnss" ? "plan-by-gnss" : "plan-by-itself");
}

function hintOf(drawing: PlanDrawing, touch: boolean): string {
  const by = { pointer: pointer(touch) };
  switch (drawing.tool) {
    case "choose":
      return say("plan-choose-line", by);
    case "box":
      return say("plan-box-line");
    case "stall":
      return say("plan-stall-line", by);
    case "area":
      return say("plan-area-line", by);
    case "zone":
      return say("plan-zone-line", by);
    case "section":
      return say("plan-section-line", by);
    case "row":
      return rowHint(drawing, by);
  }
}

function rowHint({ places, isWhole }: PlanDrawing, by: { pointer: "finger" | "mouse" }): string {
  if (places.length === 0) return say("plan-row-begin", by);
  if (places.length === 1) return say("plan-row-end", by);
  if (places.length === 2) return say("plan-row-far", by);
  return say(isWhole ? "plan-row-whole" : "plan-row-no-room");
}
