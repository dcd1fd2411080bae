import type { FenceDraft } from "../fence/draft.ts";
import type { LocalPlane } from "../fence/plane.ts";
import type { FenceCorner, OutlineSetup } from "../protocol.ts";
import { areaOf } from "../state/measure.ts";
import type { OutlineEditing } from "../state/outline-edit.ts";
import { cannot } from "./actions.ts";
import type { FenceWords } from "./fence.ts";
import * as format from "./format.ts";
import { pointer, say } from "./say.ts";
import type { Units } from "./units.ts";
import { linkOf, type View } from "./view.ts";

/** States in which the bar is not needed to fly. */
const ON_GROUND = new Set(["Idle", "Configure"]);

/** Why the outline cannot be drawn now; empty when it can. */
export function cannotDraw(view: View, setup: OutlineSetup | null): string {
  if (!setup) return say("not-known-yet");
  const reason = cannot(view, "Set Outline");
  if (reason !== "") return reason;
  if (!ON_GROUND.has(view.heartbeat?.State ?? "")) return say("outline-on-ground-only");
  return setup.Polygons.length > 1 ? say("outline-several") : "";
}

/** The area that the next Explore surveys, in a title and a line. */
export function outlineSummary(setup: OutlineSetup | null, units: Units): { title: string; line: string } {
  if (!setup) return { title: say("area-to-explore"), line: say("limits-not-known") };
  if (setup.Source === "none") return { title: say("explores-found-lot"), line: say("no-outline") };
  const rings = { polygons: setup.Polygons.length, holes: setup.Holes.length };
  const line = setup.Source === "file" ? say("outline-from-file", rings) : say("outline-set", rings);
  return { title: say("explores-outline", { area: format.area(setup.Area, units) }), line };
}

/** The words of the bar while the outline is drawn. */
export function outlineWords(editing: OutlineEditing, plane: LocalPlane | null, view: View, touch: boolean): FenceWords {
  const { draft } = editing;
  if (!draft?.isDrawn) return ring("draw-area", editing.begun, touch);
  if (editing.zoning) return ring("draw-hole", editing.begun, touch);
  const size = plane ? sizeOf(draft, plane) : null;
  const counts = { corners: draft.corners.length, holes: draft.zones.length };
  const named = size === null ? say("outline-of", counts) : say("outline-sized", { area: format.area(size, view.units), ...counts });
  if (linkOf(view) !== "live") return { title: named, line: say("outline-no-link"), level: "bad", reason: say("no-link") };
  if (plane && size === null) {
    return { title: say("outline-cannot-set"), line: say("outline-crosses"), level: "bad", reason: say("put-right") };
  }
  const waits = editing.saving ? say("being-set") : draft.isChanged ? "" : say("nothing-changed");
  const reason = cannot(view, "Set Outline") || waits;
  return { title: named, line: say("outline-meaning"), level: "", reason };
}

/** Square metres of what is drawn less its holes; null where sides cross. */
export function sizeOf(draft: Pick<FenceDraft, "corners" | "zones">, plane: LocalPlane): number | null {
  const area = (corners: readonly FenceCorner[]): number | null =>
    areaOf({ points: corners.map((corner) => plane.toMap(corner)), closed: true });
  const [whole, ...cut] = [draft.corners, ...draft.zones].map(area);
  if (whole == null || cut.some((each) => each === null)) return null;
  return Math.max(0, whole - cut.reduce<number>((sum, each) => sum + (each ?? 0), 0));
}

function ring(what: "draw-area" | "draw-hole", begun: number, touch: boolean): FenceWords {
  const common = { title: say(what), level: "" as const, reason: say("not-closed-yet") };
  if (begun === 0) return { ...common, line: say(`${what}-begin`, { pointer: pointer(touch) }) };
  if (begun < 3) return { ...common, line: say("draw-ring-few", { corners: begun }) };
  return { ...common, line: say("draw-close", { corners: begun, pointer: pointer(touch) }) };
}
