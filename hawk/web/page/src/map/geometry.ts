import type { Point } from "../protocol.ts";

/** OpenLayers coordinates: east, north in metres. */
export type Coordinate = [number, number];
export type Extent = [number, number, number, number];

export function toCoordinate(place: Point): Coordinate {
  return [place.East, place.North];
}

export interface Rectangle {
  north: number;
  east: number;
  /** Radians clockwise from north of the long side. */
  angle: number;
  width: number;
  length: number;
}

/** Corners of an oriented rectangle, in order around it. */
export function corners(rectangle: Rectangle): Coordinate[] {
  const { north, east, angle, width, length } = rectangle;
  const along: Coordinate = [(Math.sin(angle) * length) / 2, (Math.cos(angle) * length) / 2];
  const across: Coordinate = [(Math.cos(angle) * width) / 2, (-Math.sin(angle) * width) / 2];
  const corner = (a: number, b: number): Coordinate => [
    east + a * along[0] + b * across[0],
    north + a * along[1] + b * across[1],
  ];
  return [corner(1, -1), corner(1, 1), corner(-1, 1), corner(-1, -1)];
}

/** Smallest extent around all places; null for none. */
export function extentOf(places: readonly Coordinate[]): Extent | null {
  if (places.length === 0) return null;
  const east = places.map((place) => place[0]);
  const north = places.map((place) => place[1]);
  return [Math.min(...east), Math.min(...north), Math.max(...east), Math.max(...north)];
}

export function covers(outer: Extent, inner: Extent): boolean {
  return outer[0] <= inner[0] && outer[1] <= inner[1] && outer[2] >= inner[2] && outer[3] >= inner[3];
}

/** Turn from one angle to another in the shorter direction, at share 0 to 1. */
export function turn(from: number, to: number, share: number): number {
  const whole = 2 * Math.PI;
  const difference = ((((to - from) % whole) + whole + Math.PI) % whole) - Math.PI;
  return from + difference * share;
}

/** A round length whose bar is at most `longest` pixels long; `resolution` is length a pixel. */
export function scaleBar(resolution: number, longest: number): { length: number; pixels: number } {
  const most = resolution * longest;
  const power = 10 ** Math.floor(Math.log10(most));
  const step = [5, 2, 1].find((each) => each * power <= most) ?? 1;
  return { length: step * power, pixels: (step * power) / resolution };
}
