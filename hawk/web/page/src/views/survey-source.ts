import type { SurveyGround, SurveyMap } from "../api.ts";
import { LocalPlane } from "../fence/plane.ts";
import { type RowMark, rowMarks } from "../map/draw-labels.ts";
import type { Rectangle } from "../map/geometry.ts";
import type { Point } from "../protocol.ts";
import type { CountedState, Stall } from "../state/map-store.ts";

/** A stall as the drone's GeoJSON has it. */
export interface Feature {
  id: string;
  geometry: { type: string; coordinates: unknown };
  properties: { amenity?: string; ref?: string; label?: string | null; state?: string; parking_space?: string; taken_probability?: number | null };
}

/** A stored survey as the map shows it, in metres about `plane`'s origin. */
export interface SurveyOnMap {
  survey: string;
  plane: LocalPlane;
  stalls: readonly Stall[];
  /** Ids of the stalls, in their order. */
  ids: readonly string[];
  rows: readonly RowMark[];
  ground: SurveyGround | null;
}

type Ring = [number, number][];

/** The plane in which all surveys of a lot are shown: about the first one's datum, or stall; null where it has neither. */
export function planeOf({ origin, ids }: SurveyMap, ground: SurveyGround | null): LocalPlane | null {
  if (ground) return new LocalPlane({ Latitude: ground.datum[0], Longitude: ground.datum[1] });
  return ids.length > 0 ? new LocalPlane({ Latitude: origin[1], Longitude: origin[0] }) : null;
}

/** A survey with its ground in a plane. `ground`: null where none is shown. */
export function onMap(survey: string, map: SurveyMap, ground: SurveyGround | null, plane: LocalPlane): SurveyOnMap {
  const stalls = map.ids.map((_, index) => stallOn(map, index, plane));
  const off = ground ? plane.toMap({ Latitude: ground.datum[0], Longitude: ground.datum[1] }) : { North: 0, East: 0 };
  const placed = ground && { ...ground, place: { ...ground.place, north: ground.place.north + off.North, east: ground.place.east + off.East } };
  return { survey, plane, stalls, ids: map.ids, rows: rowMarks(stalls), ground: placed };
}

/** The stalls among features, in metres about a plane's origin. */
export function stallsOf(features: readonly Feature[], plane: LocalPlane): Stall[] {
  const shapes = features.filter((each) => each.properties.amenity !== "parking" && each.geometry.type === "Polygon");
  return shapes.map((each, index) => stallOf(each, index, plane));
}

/** Corners are sent in these, degrees. */
const UNIT = 1e-8;
const CORNERS = [0, 2, 4, 6];

function stallOn({ origin, corners, states, taken, labels }: SurveyMap, index: number, plane: LocalPlane): Stall {
  const degrees = (at: number, axis: 0 | 1): number => origin[axis] + UNIT * (corners[8 * index + at + axis] ?? 0);
  const places = CORNERS.map((at) => plane.toMap({ Latitude: degrees(at, 1), Longitude: degrees(at, 0) }));
  return { id: index, ...rectangleOf(places), state: states[index] ?? "unknown", taken: taken[index] ?? null, seen: null, lastSeen: null, label: labels[index] ?? "" };
}

function stallOf({ geometry, properties }: Feature, id: number, plane: LocalPlane): Stall {
  const ring = (geometry.coordinates as Ring[])[0] ?? [];
  const corners = ring.slice(0, 4).map(([longitude, latitude]) => plane.toMap({ Latitude: latitude, Longitude: longitude }));
  const taken = properties.taken_probability ?? null;
  const state = STATES.find((each) => each === properties.state) ?? "unknown";
  return { id, ...rectangleOf(corners), state, taken, seen: null, lastSeen: null, label: properties.ref ?? properties.label ?? "" };
}

const NOWHERE: Point = { North: 0, East: 0 };
const STATES: readonly CountedState[] = ["free", "taken", "unknown"];

/** The rectangle of four corners in order around it. */
function rectangleOf(corners: readonly Point[]): Rectangle {
  const [a = NOWHERE, b = a, c = a, d = a] = corners;
  const [north, east] = [(a.North + b.North + c.North + d.North) / 4, (a.East + b.East + c.East + d.East) / 4];
  const [up, right] = [(b.North - a.North + c.North - d.North) / 2, (b.East - a.East + c.East - d.East) / 2];
  const [otherUp, otherRight] = [(c.North - b.North + d.North - a.North) / 2, (c.East - b.East + d.East - a.East) / 2];
  const [side, other] = [Math.hypot(up, right), Math.hypot(otherUp, otherRight)];
  const angle = side >= other ? Math.atan2(right, up) : Math.atan2(otherRight, otherUp);
  return { north, east, angle, width: Math.min(side, other), length: Math.max(side, other) };
}
