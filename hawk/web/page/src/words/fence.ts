import type { FenceSetup } from "../protocol.ts";
import type { FenceEditing } from "../state/fence-edit.ts";
import { cannot } from "./actions.ts";
import * as format from "./format.ts";
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
  const corners = `${format.count(draft.corners.length, "corner", "corners")}${zones(draft.zones.length)}`;
  if (linkOf(view) !== "live") {
    return { title: `Fence of ${corners}`, line: "No link: it cannot be checked or saved.", level: "bad", reason: "No link" };
  }
  if (verdict.about === "problem") {
    return { title: "This fence cannot be saved", line: verdict.text, level: "bad", reason: "Put right what is said" };
  }
  if (verdict.about !== "good") return { title: `Fence of ${corners}`, line: "Being checked.", level: "", reason: "Being checked" };
  const { check } = verdict;
  const title = `Fence ${extent(check["North South"], check["East West"], view.units)}, ${corners}`;
  const waits = editing.saving ? "Being saved" : draft.isChanged ? "" : "Nothing changed";
  const done = { title, reason: reason || waits };
  if (editing.removing) return { ...done, line: removal(draft.zones.length, touch), level: "" };
  const [note] = check.Notes;
  return { ...done, line: note ?? inside(setup, draft.ceilingMetres, view.units), level: note === undefined ? "" : "warning" };
}

/** Which fence the next Arm puts in force, in a title and a line. */
export function fenceSummary(setup: FenceSetup | null, units: Units): { title: string; line: string } {
  if (!setup) return { title: "Fence", line: "not known yet" };
  if (setup.Problem !== "") return { title: "The drawn fence cannot be used", line: setup.Problem };
  const ceiling = `up to ${format.height(setup.Ceiling, units)}`;
  if (setup.Source === "drawn") return { title: `Fence of ${outline(setup)}`, line: `drawn, ${ceiling}` };
  if (setup.Source === "file") return { title: `Fence of ${outline(setup)}`, line: `from the settings, ${ceiling}` };
  return { title: `Fence: circle of ${format.distance(setup.Radius ?? 0, units)}`, line: `around where it is armed, ${ceiling}` };
}

function drawing(begun: number, touch: boolean): FenceWords {
  const point = touch ? "Tap" : "Click";
  const common = { title: "Draw the fence", level: "" as const, reason: "Not closed yet" };
  if (begun === 0) return { ...common, line: `${point} its corners on the map, one after the other. Or import a file.` };
  const set = format.count(begun, "corner", "corners");
  if (begun < 3) return { ...common, line: `${set} set. A fence needs at least 3.` };
  return { ...common, line: `${set} set. ${point} the first one again, or Close.` };
}

function zoning(begun: number, touch: boolean): FenceWords {
  const point = touch ? "Tap" : "Click";
  const common = { title: "Draw a zone that the drone keeps out of", level: "" as const, reason: "Zone not closed yet" };
  if (begun === 0) return { ...common, line: `${point} its corners, inside the fence. Add zone again gives it up.` };
  const set = format.count(begun, "corner", "corners");
  if (begun < 3) return { ...common, line: `${set} set. A zone needs at least 3.` };
  return { ...common, line: `${set} set. ${point} the first one again, or Close.` };
}

function removal(zoneCount: number, touch: boolean): string {
  const point = touch ? "Tap" : "Click";
  return `${point} the corners that are to go${zoneCount === 0 ? "" : ", or into a zone to remove it"}.`;
}

function outline(setup: FenceSetup): string {
  return `${format.count(setup.Corners.length, "corner", "corners")}${zones(setup.Zones.length)}`;
}

function zones(count: number): string {
  return count === 0 ? "" : `, ${format.count(count, "zone", "zones")}`;
}

function extent(north: number | null, east: number | null, units: Units): string {
  return north === null || east === null ? "" : format.extent(east, north, units);
}

function inside(setup: FenceSetup | null, ceiling: number | null, units: Units): string {
  if (!setup || ceiling === null) return "";
  const top = format.height(ceiling - setup["Ceiling Margin"], units);
  return `The drone stays ${format.margin(setup.Margin, units)} inside it, at the dotted line, and below ${top}.`;
}
