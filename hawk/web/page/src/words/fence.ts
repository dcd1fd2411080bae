import type { FenceSetup } from "../protocol.ts";
import type { FenceEditing } from "../state/fence-edit.ts";
import { cannot } from "./actions.ts";
import * as format from "./format.ts";
import { pointer, say } from "./say.ts";
import type { Units } from "./units.ts";
import { linkOf, type View } from "./view.ts";

export interface FenceWords {
  title: string;
  /** What is wrong, or what to do, or what it means. */
  line: string;
  /** Kind of the line: "bad" prevents saving, "warning" prevents flying. */
  level: "" | "warning" | "bad";
  /** Why it cannot be saved; empty when it can. */
  reason: string;
}

/** The words of the fence editor's bar. */
export function fenceWords(editing: FenceEditing, setup: FenceSetup | null, view: View, touch: boolean): FenceWords {
  const draft = editing.draft;
  if (!draft?.isDrawn) return drawing(editing.begun, touch);
  if (editing.zoning) return zoning(editing.begun, touch);
  const reason = cannot(view, "Set Fence");
  const verdict = editing.verdict;
  const counts = { corners: draft.corners.length, zones: draft.zones.length };
  const unsized = say("fence-of", counts);
  if (linkOf(view) !== "live") return { title: unsized, line: say("fence-no-link"), level: "bad", reason: say("no-link") };
  if (verdict.about === "problem") {
    return { title: say("fence-cannot-save"), line: verdict.text, level: "bad", reason: say("put-right") };
  }
  if (verdict.about !== "good") return { title: unsized, line: say("being-checked-line"), level: "", reason: say("being-checked") };
  const { check } = verdict;
  const extent = extentOf(check["North South"], check["East West"], view.units);
  const title = extent === null ? unsized : say("fence-sized", { extent, ...counts });
  const waits = editing.saving ? say("being-saved") : draft.isChanged ? "" : say("nothing-changed");
  const done = { title, reason: reason || waits };
  if (editing.removing) return { ...done, line: removal(draft.zones.length, touch), level: "" };
  const [note] = check.Notes;
  return { ...done, line: note ?? inside(setup, draft.ceilingMetres, view.units), level: note === undefined ? "" : "warning" };
}

/** Which fence the next Arm puts in force, in a title and a line. */
export function fenceSummary(setup: FenceSetup | null, units: Units): { title: string; line: string } {
  if (!setup) return { title: say("fence"), line: say("limits-not-known") };
  if (setup.Problem !== "") return { title: say("fence-unusable"), line: setup.Problem };
  const ceiling = format.height(setup.Ceiling, units);
  if (setup.Source === "circle") {
    const radius = format.distance(setup.Radius ?? 0, units);
    return { title: say("fence-circle", { radius }), line: say("fence-circle-up-to", { ceiling }) };
  }
  const title = say("fence-of", { corners: setup.Corners.length, zones: setup.Zones.length });
  return { title, line: setup.Source === "drawn" ? say("fence-drawn-up-to", { ceiling }) : say("fence-file-up-to", { ceiling }) };
}

function drawing(begun: number, touch: boolean): FenceWords {
  const common = { title: say("draw-fence"), level: "" as const, reason: say("not-closed-yet") };
  if (begun === 0) return { ...common, line: say("draw-fence-begin", { pointer: pointer(touch) }) };
  if (begun < 3) return { ...common, line: say("draw-fence-few", { corners: begun }) };
  return { ...common, line: say("draw-close", { corners: begun, pointer: pointer(touch) }) };
}

function zoning(begun: number, touch: boolean): FenceWords {
  const common = { title: say("draw-zone"), level: "" as const, reason: say("zone-not-closed-yet") };
  if (begun === 0) return { ...common, line: say("draw-zone-begin", { pointer: pointer(touch) }) };
  if (begun < 3) return { ...common, line: say("draw-zone-few", { corners: begun }) };
  return { ...common, line: say("draw-close", { corners: begun, pointer: pointer(touch) }) };
}

function removal(zoneCount: number, touch: boolean): string {
  return say(zoneCount === 0 ? "remove-corners-line" : "remove-zones-line", { pointer: pointer(touch) });
}

function extentOf(north: number | null, east: number | null, units: Units): string | null {
  return north === null || east === null ? null : format.extent(east, north, units);
}

function inside(setup: FenceSetup | null, ceiling: number | null, units: Units): string {
  if (!setup || ceiling === null) return "";
  const height = format.height(ceiling - setup["Ceiling Margin"], units);
  return say("stays-inside", { margin: format.margin(setup.Margin, units), height });
}
