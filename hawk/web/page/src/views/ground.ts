import type { Feature } from "./survey-source.ts";

/** Metres east and south of the first corner: as a picture runs. */
export type Point = readonly [number, number];

export interface Stall {
  id: string;
  label: string;
  state: string;
  kind: string;
  corners: readonly Point[];
}

/** Stalls of a survey in metres, and the box around them and the lot. */
export interface Ground {
  stalls: readonly Stall[];
  outline: readonly (readonly Point[])[];
  box: { left: number; top: number; width: number; height: number };
}

/** Metres of a degree of latitude (WGS-84's mean meridian). */
const METRES = 111_132.95;
const MARGIN_M = 4;

/** Where one drawing begins: two surveys of a lot are drawn from the same place. */
export interface Origin {
  latitude: number;
  longitude: number;
}

/** The first corner of a survey's features; null without any. */
export function originOf(features: readonly Feature[]): Origin | null {
  for (const feature of features) {
    const first = rings(feature)[0]?.[0];
    if (first) return { longitude: first[0], latitude: first[1] };
  }
  return null;
}

/** The stalls of a survey in metres from an origin. Over a lot of a kilometre the plane is true to a centimetre. */
export function groundOf(features: readonly Feature[], origin: Origin): Ground {
  const scale = METRES * Math.cos((origin.latitude * Math.PI) / 180);
  // GeoJSON repeats the first corner as the last one
  const placed = (ring: [number, number][]): Point[] =>
    ring.slice(0, -1).map(([longitude, latitude]) => [(longitude - origin.longitude) * scale, (origin.latitude - latitude) * METRES]);
  const stalls: Stall[] = [];
  const outline: Point[][] = [];
  for (const feature of features) {
    const { amenity, label, ref = label ?? "", state = "unknown", parking_space: kind = "normal" } = feature.properties;
    if (amenity === "parking") outline.push(...rings(feature).map(placed));
    else stalls.push({ id: feature.id, label: ref, state, kind, corners: placed(rings(feature)[0] ?? []) });
  }
  return { stalls, outline, box: boxOf([...outline.flat(), ...stalls.flatMap(({ corners }) => corners)]) };
}

function rings({ geometry }: Feature): [number, number][][] {
  if (geometry.type === "Polygon") return geometry.coordinates as [number, number][][];
  return geometry.type === "MultiPolygon" ? (geometry.coordinates as [number, number][][][]).flat() : [];
}

function boxOf(points: readonly Point[]): Ground["box"] {
  let [left, top, right, bottom] = [Infinity, Infinity, -Infinity, -Infinity];
  for (const [x, y] of points) {
    left = Math.min(left, x);
    top = Math.min(top, y);
    right = Math.max(right, x);
    bottom = Math.max(bottom, y);
  }
  if (left > right) return { left: 0, top: 0, width: 10, height: 10 };
  return { left: left - MARGIN_M, top: top - MARGIN_M, width: right - left + 2 * MARGIN_M, height: bottom - top + 2 * MARGIN_M };
}

/** One path of many stalls: a drawing of 20,000 has a few elements. */
export function pathOf(stalls: readonly Stall[]): string {
  return stalls.map(({ corners }) => ringPath(corners)).join("");
}

export function ringPath(ring: readonly Point[]): string {
  return ring.length === 0 ? "" : `M${ring.map(([x, y]) => `${x.toFixed(2)} ${y.toFixed(2)}`).join("L")}Z`;
}

/** The stall at a point; the nearest within two metres for a finger; null where there is none. */
export function stallAt(stalls: readonly Stall[], at: Point): Stall | null {
  let nearest: Stall | null = null;
  let least = 2;
  for (const stall of stalls) {
    if (holds(stall.corners, at)) return stall;
    const [x, y] = middleOf(stall);
    const away = Math.hypot(x - at[0], y - at[1]);
    if (away < least) [nearest, least] = [stall, away];
  }
  return nearest;
}

export function middleOf({ corners }: Stall): Point {
  const count = Math.max(1, corners.length);
  return [corners.reduce((sum, [x]) => sum + x, 0) / count, corners.reduce((sum, [, y]) => sum + y, 0) / count];
}

function holds(ring: readonly Point[], [x, y]: Point): boolean {
  let inside = false;
  ring.forEach(([x1, y1], i) => {
    const [x2, y2] = ring[(i + 1) % ring.length] ?? [x1, y1];
    if (y1 > y !== y2 > y && x < ((x2 - x1) * (y - y1)) / (y2 - y1) + x1) inside = !inside;
  });
  return inside;
}
