import { LocalPlane } from "../fence/plane.ts";
import type { FenceCheck, FenceCorner, FenceSetup, Heartbeat, OutlineSetup, Point } from "../protocol.ts";
import type { ShownChanges } from "../state/operator.ts";
import type { ChangesMark } from "./draw-changes.ts";

/** The fence on the map: our line, inside which the drone stays, and the autopilot's around it. */
export interface ShownFence {
  inner: readonly Point[];
  limit: readonly Point[];
  /** Our lines around the exclusion zones. */
  zones: readonly (readonly Point[])[];
  /** The zones as drawn, which the autopilot keeps out of. */
  zoneLimits: readonly (readonly Point[])[];
}

const NONE: ShownFence = { inner: [], limit: [], zones: [], zoneLimits: [] };
const CIRCLE_CORNERS = 48;
/** States in which the next Arm decides which fence counts. */
const BEFORE_ARM = new Set(["Idle", "Configure"]);

/** While it is drawn, the editor shows the outer line itself; ours comes from what the drone said about it. */
export function draftFence(check: FenceCheck | null, plane: LocalPlane | null): ShownFence {
  if (!check || !plane) return NONE;
  return { ...NONE, inner: onMap(check.Inner, plane), zones: check["Inner Zones"].map((zone) => onMap(zone, plane)) };
}

/** On the ground the fence that the next Arm puts in force, else the one that is. */
export function shownFence(heartbeat: Heartbeat, setup: FenceSetup | null, plane: LocalPlane | null): ShownFence {
  const inForce = {
    inner: heartbeat.Fence,
    limit: heartbeat["Fence Limit"],
    zones: heartbeat["Fence Zones"],
    zoneLimits: heartbeat["Fence Zone Limits"],
  };
  if (!BEFORE_ARM.has(heartbeat.State) || !setup || !plane || setup.Problem !== "") return inForce;
  if (setup.Corners.length > 0) {
    return {
      inner: onMap(setup.Inner, plane),
      limit: onMap(setup.Corners, plane),
      zones: setup["Inner Zones"].map((zone) => onMap(zone, plane)),
      zoneLimits: setup.Zones.map((zone) => onMap(zone, plane)),
    };
  }
  const centre = dronePlace(heartbeat, plane);
  if (!centre || setup.Radius === null || inForce.inner.length > 0) return inForce;
  return { ...NONE, inner: circle(centre, setup.Radius - setup.Margin), limit: circle(centre, setup.Radius) };
}

/** Where the drone is on the map; before its first arm by its place on Earth. */
export function dronePlace(heartbeat: Heartbeat, plane: LocalPlane | null): Point | null {
  const { North, East, Latitude, Longitude } = heartbeat;
  if (North !== null && East !== null) return { North, East };
  if (!plane || Latitude === null || Longitude === null) return null;
  return plane.toMap({ Latitude, Longitude });
}

/** The area to explore: its polygons and what is cut out of them. */
export function shownOutline(setup: OutlineSetup | null, plane: LocalPlane | null): readonly (readonly Point[])[] {
  return setup && plane ? [...setup.Polygons, ...setup.Holes].map((ring) => onMap(ring, plane)) : [];
}

/** Stalls of a lot that begin and end, on the map. */
export function shownChanges(changes: ShownChanges | null, known: LocalPlane | null): ChangesMark | null {
  const first = changes && [...changes.begin, ...changes.end][0]?.[0];
  const plane = known ?? (first ? new LocalPlane(first) : null); // at a desk nothing else lies on the map
  if (!changes || !plane) return null;
  const placed = (rings: ShownChanges["begin"]): Point[][] => rings.map((ring) => onMap(ring, plane));
  return { begin: placed(changes.begin), end: placed(changes.end) };
}

function onMap(corners: readonly FenceCorner[], plane: LocalPlane): Point[] {
  return corners.map((corner) => plane.toMap(corner));
}

function circle(centre: Point, radius: number): Point[] {
  return Array.from({ length: CIRCLE_CORNERS }, (_, step) => {
    const angle = (2 * Math.PI * step) / CIRCLE_CORNERS;
    return { North: centre.North + radius * Math.cos(angle), East: centre.East + radius * Math.sin(angle) };
  });
}
