import type { AboutSurvey, SurveyGround } from "../api.ts";
import { LocalPlane } from "../fence/plane.ts";
import { type RowMark, rowMarks } from "../map/draw-labels.ts";
import type { Rectangle } from "../map/geometry.ts";
import type { Point } from "../protocol.ts";
import type { CountedState, Stall } from "../state/map-store.ts";

/** A survey as the drone's GeoJSON has it. */
export interface Features {
  hawk: AboutSurvey;
  features: Feature[];
}

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
export function planeOf({ features }: Features, ground: SurveyGround | null): LocalPlane | null {
  const first = (shapesOf(features)[0]?.geometry.coordinates as Ring[] | undefined)?.[0]?.[0];
  if (ground) return new LocalPlane({ Latitude: ground.datum[0], Longitude: ground.datum[1] });
  return first ? new LocalPlane({ Latitude: first[1], Longitude: first[0] }) : null;
}

/** A survey with its ground in a plane. `ground`: null where none is shown. */
export function onMap(survey: string, { features }: Features, ground: SurveyGround | null, plane: LocalPlane): SurveyOnMap {
  const shapes = shapesOf(features);
  const stalls = stallsOf(features, plane);
  const off = ground ? plane.toMap({ Latitude: ground.datum[0], Longitude: ground.datum[1] }) : { North: 0, East: 0 };
  const placed = ground && { ...ground, place: { ...ground.place, north: ground.place.north + off.North, east: ground.place.east + off.East } };
  return { survey, plane, stalls, ids: shapes.map(({ id }) => id), rows: rowMarks(stalls), ground: placed };
}

/** The stalls among features, in metres about a plane's origin. */
export function stallsOf(features: readonly Feature[], plane: LocalPlane): Stall[] {
  return shapesOf(features).map((each, index) => stallOf(each, index, plane));
}

function shapesOf(features: readonly Feature[]): Feature[] {
  return features.filter((each) => each.properties.amenity !== "parking" && each.geometry.type === "Polygon");
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
