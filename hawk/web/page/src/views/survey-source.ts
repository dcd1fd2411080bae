import type { AboutSurvey, SurveyGround } from "../api.ts";
import { LocalPlane } from "../fence/plane.ts";
import { type RowMark, rowMarks } from "../map/draw-labels.ts";
import type { Rectangle } from "../map/geometry.ts";
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
  const first = (features.find(isStall)?.geometry.coordinates as Ring[] | undefined)?.[0]?.[0];
  if (ground) return new LocalPlane({ Latitude: ground.datum[0], Longitude: ground.datum[1] });
  return first ? new LocalPlane({ Latitude: first[1], Longitude: first[0] }) : null;
}

/** A survey with its ground in a plane. `ground`: null where none is shown. */
export function onMap(survey: string, { features }: Features, ground: SurveyGround | null, plane: LocalPlane): SurveyOnMap {
  const shapes = features.filter(isStall);
  const stalls = shapes.map((each, index) => stallOf(each, index, plane));
  const off = ground ? plane.toMap({ Latitude: ground.datum[0], Longitude: ground.datum[1] }) : { North: 0, East: 0 };
  const placed = ground && { ...ground, place: { ...ground.place, north: ground.place.north + off.North, east: ground.place.east + off.East } };
  return { survey, plane, stalls, ids: shapes.map(({ id }) => id), rows: rowMarks(stalls), ground: placed };
}

function isStall({ properties, geometry }: Feature): boolean {
  return properties.amenity !== "parking" && geometry.type === "Polygon";
}

function stallOf({ geometry, properties }: Feature, id: number, plane: LocalPlane): Stall {
  const ring = (geometry.coordinates as Ring[])[0] ?? [];
  const corners = ring.slice(0, 4).map(([longitude, latitude]) => plane.toMap({ Latitude: latitude, Longitude: longitude }));
  const taken = properties.taken_probability ?? null;
  const state = STATES.find((each) => each === properties.state) ?? "unknown";
  return { id, ...rectangleOf(corners.map(({ North, East }) => [North, East])), state, taken, seen: null, lastSeen: null, label: properties.ref ?? properties.label ?? "" };
}

const STATES: readonly CountedState[] = ["free", "taken", "unknown"];

/** The rectangle of four corners (north, east) in order around it. */
function rectangleOf(corners: readonly (readonly [number, number])[]): Rectangle {
  const at = (index: number): readonly [number, number] => corners[index % 4] ?? [0, 0];
  const mean = (axis: 0 | 1): number => corners.reduce((sum, corner) => sum + corner[axis], 0) / Math.max(1, corners.length);
  const side = (index: number): [number, number] => {
    const [one, other, third, fourth] = [at(index), at(index + 1), at(index + 2), at(index + 3)];
    return [(other[0] - one[0] + third[0] - fourth[0]) / 2, (other[1] - one[1] + third[1] - fourth[1]) / 2];
  };
  const [first, second] = [side(0), side(1)];
  const [long, short] = Math.hypot(...first) >= Math.hypot(...second) ? [first, second] : [second, first];
  return { north: mean(0), east: mean(1), angle: Math.atan2(long[1], long[0]), width: Math.hypot(...short), length: Math.hypot(...long) };
}
