import { LocalPlane } from "../fence/plane.ts";
import type { Rectangle } from "../map/geometry.ts";
import type { Spot } from "./values.ts";

/** A rigid move: a turn about the origin, radians clockwise, then a shift, metres. */
export interface Shift {
  north: number;
  east: number;
  turn: number;
}

export const NO_SHIFT: Shift = { north: 0, east: 0, turn: 0 };

/** Latitude and longitude, degrees. */
export type Datum = readonly [number, number];

/** A survey of the lot that lies on the lot's stalls, by where they are. */
export interface PlacedSurvey {
  datum: Datum | null;
  place: Shift | null;
}

/** The map's frame is that of a survey where both have the same datum within this number of degrees: about a centimetre. */
const SAME_DATUM = 1e-7;
const ARM_M = 100;

/** Where the lot's frame lies on the map: "survey": by its stalls, "gnss": by receivers alone, "own": there is no map yet. */
export interface LotFrame {
  toMap: Shift;
  by: "survey" | "gnss" | "own";
}

/**
 * Where a lot's frame lies on the map. The map's own survey says it best: it was placed by where the stalls are; else the
 * lot's place on Earth does, which is off by what receivers err.
 */
export function lotFrame(datum: Datum, surveys: readonly PlacedSurvey[], map: LocalPlane | null): LotFrame {
  if (!map) return { toMap: NO_SHIFT, by: "own" };
  const { Latitude, Longitude } = map.origin;
  const isMap = (other: Datum): boolean => Math.abs(other[0] - Latitude) < SAME_DATUM && Math.abs(other[1] - Longitude) < SAME_DATUM;
  const placed = surveys.findLast((each) => each.datum !== null && each.place !== null && isMap(each.datum));
  if (placed?.place) return { toMap: inverse(placed.place), by: "survey" };
  const lot = new LocalPlane({ Latitude: datum[0], Longitude: datum[1] });
  const origin = map.toMap(lot.origin);
  const north = map.toMap(lot.toEarth({ North: ARM_M, East: 0 }));
  const turn = Math.atan2(north.East - origin.East, north.North - origin.North);
  return { toMap: { north: origin.North, east: origin.East, turn }, by: "gnss" };
}

export function shifted({ north, east, turn }: Shift, [up, right]: Spot): [number, number] {
  const [sine, cosine] = [Math.sin(turn), Math.cos(turn)];
  return [north + up * cosine - right * sine, east + up * sine + right * cosine];
}

export function inverse(shift: Shift): Shift {
  const [north, east] = shifted({ north: 0, east: 0, turn: -shift.turn }, [-shift.north, -shift.east]);
  return { north, east, turn: -shift.turn };
}

/** A rectangle after the move; the rest of it stays as it is. */
export function shiftedShape<Shape extends Rectangle>(shift: Shift, shape: Shape): Shape {
  const [north, east] = shifted(shift, [shape.north, shape.east]);
  return { ...shape, north, east, angle: shape.angle + shift.turn };
}
