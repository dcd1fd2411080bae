import type { FenceDraft } from "../fence/draft.ts";
import type { LocalPlane } from "../fence/plane.ts";
import type { FenceCorner, OutlineSetup } from "../protocol.ts";
import { areaOf } from "../state/measure.ts";
import type { OutlineEditing } from "../state/outline-edit.ts";
import { cannot } from "./actions.ts";
import type { FenceWords } from "./fence.ts";
import * as format from "./format.ts";
import type { Units } from "./units.ts";
import { linkOf, type View } from "./view.ts";

/** States in which the bar is not needed to fly. */
const ON_GROUND = new Set(["Idle", "Configure"]);

/** Why the outline cannot be drawn now; empty when it can. */
export function cannotDraw(view: View, setup: OutlineSetup | null): string {
  if (!setup) return "Not known yet";
  const reason = cannot(view, "Set Outline");
  if (reason !== "") return reason;
  if (!ON_GROUND.has(view.heartbeat?.State ?? "")) return "On the ground only, with the motors off";
  return setup.Polygons.length > 1 ? "It has several polygons: remove it first" : "";
}

/** The area that the next Explore surveys, in a title and a line. */
export function outlineSummary(setup: OutlineSetup | null, units: Units): { title: string; line: string } {
  if (!setup) return { title: "Area to explore", line: "not known yet" };
  if (setup.Source === "none") return { title: "Explores the lot that it finds", line: "no outline is set" };
  const rings = `${format.count(setup.Polygons.length, "polygon", "polygons")}${holes(setup.Holes.length)}`;
  const from = setup.Source === "file" ? "from the settings" : "set for this survey";
  return { title: `Explores an outline of ${format.area(setup.Area, units)}`, line: `${rings}, ${from}` };
}

/** The words of the bar while the outline is drawn. */
export function outlineWords(editing: OutlineEditing, plane: LocalPlane | null, view: View, touch: boolean): FenceWords {
  const { draft } = editing;
  if (!draft?.isDrawn) return ring("Draw the area to explore", editing.begun, touch, "Or import a file.");
  if (editing.zoning) return ring("Draw a part that is not explored", editing.begun, touch, "Add hole again gives it up.");
  const size = plane ? sizeOf(draft, plane) : null;
  const named = `Outline${size === null ? "" : ` of ${format.area(size, view.units)}`}, ${format.count(draft.corners.length, "corner", "corners")}${holes(draft.zones.length)}`;
  if (linkOf(view) !== "live") return { title: named, line: "No link: it cannot be set.", level: "bad", reason: "No link" };
  if (plane && size === null) {
    return { title: "This outline cannot be set", line: "Two of its sides cross: move a corner.", level: "bad", reason: "Put right what is said" };
  }
  const waits = editing.saving ? "Being set" : draft.isChanged ? "" : "Nothing changed";
  const reason = cannot(view, "Set Outline") || waits;
  return { title: named, line: "The next Explore sees all of it inside the fence, and nothing else.", level: "", reason };
}

/** Square metres of what is drawn less its holes; null where sides cross. */
export function sizeOf(draft: Pick<FenceDraft, "corners" | "zones">, plane: LocalPlane): number | null {
  const area = (corners: readonly FenceCorner[]): number | null =>
    areaOf({ points: corners.map((corner) => plane.toMap(corner)), closed: true });
  const [whole, ...cut] = [draft.corners, ...draft.zones].map(area);
  if (whole == null || cut.some((each) => each === null)) return null;
  return Math.max(0, whole - cut.reduce<number>((sum, each) => sum + (each ?? 0), 0));
}

function ring(title: string, begun: number, touch: boolean, otherwise: string): FenceWords {
  const point = touch ? "Tap" : "Click";
  const common = { title, level: "" as const, reason: "Not closed yet" };
  if (begun === 0) return { ...common, line: `${point} its corners on the map, one after the other. ${otherwise}` };
  const set = format.count(begun, "corner", "corners");
  return { ...common, line: begun < 3 ? `${set} set. It needs at least 3.` : `${set} set. ${point} the first one again, or Close.` };
}

function holes(count: number): string {
  return count === 0 ? "" : `, ${format.count(count, "hole", "holes")}`;
}
