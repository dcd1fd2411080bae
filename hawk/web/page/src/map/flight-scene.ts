import type { Point } from "../protocol.ts";
import type { Layers } from "../state/preferences.ts";
import type { ChangesMark } from "./draw-changes.ts";
import type { MeasureMark } from "./draw-measure.ts";
import type { Rectangle } from "./geometry.ts";

/** Where the drone is drawn. */
export interface DroneMark {
  north: number;
  east: number;
  yaw: number;
}

/** What is drawn over the ground and the stalls. */
export interface Scene {
  /** Our line, inside which the drone stays. */
  fence: readonly Point[];
  /** The autopilot's, around ours. */
  limit: readonly Point[];
  /** Our lines around the exclusion zones, and the zones themselves. */
  zones: readonly (readonly Point[])[];
  zoneLimits: readonly (readonly Point[])[];
  /** The area that Explore surveys, and what is cut out of it. */
  outline: readonly (readonly Point[])[];
  trail: readonly Point[];
  route: readonly Point[];
  target: Point | null;
  home: Point | null;
  footprint: readonly Point[];
  drone: DroneMark | null;
  /** A place that is being asked about. */
  planned: Point | null;
  /** The route to it, where the drone plans one; else it would fly straight. */
  plannedRoute: readonly Point[];
  /** The drone was last seen so: drawn hollow, with a ring as far as it can be by now (metres). */
  lost: { reach: number } | null;
  selected: Rectangle | null;
  /** Stalls that are framed: those that changed. */
  marked: readonly Rectangle[];
  measured: MeasureMark | null;
  /** Stalls of the lot that begin and end if a survey is taken over. */
  changes: ChangesMark | null;
}

export const EMPTY_SCENE: Scene = {
  fence: [],
  limit: [],
  zones: [],
  zoneLimits: [],
  outline: [],
  trail: [],
  route: [],
  target: null,
  home: null,
  footprint: [],
  drone: null,
  planned: null,
  plannedRoute: [],
  lost: null,
  selected: null,
  marked: [],
  measured: null,
  changes: null,
};

/**
 * Leaves out what is switched off. While a place to fly to is chosen or a fence is drawn, the fence is there whatever is
 * switched off: it says where the drone may be.
 */
export function withLayers(scene: Scene, layers: Layers, choosing: boolean): Scene {
  const fence = layers.fence || choosing ? {} : { fence: [], limit: [], zones: [], zoneLimits: [] };
  return {
    ...scene,
    ...fence,
    outline: layers.outline ? scene.outline : [],
    trail: layers.trail ? scene.trail : [],
    selected: layers.stalls ? scene.selected : null,
  };
}
