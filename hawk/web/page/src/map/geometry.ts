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

/** A scale is at most so long, pixels. */
const LONGEST_BAR_PX = 120;

/** A round length whose bar is at most `longest` pixels long; `resolution` is length a pixel. */
export function scaleBar(resolution: number, longest: number): { length: number; pixels: number } {
  const most = resolution * longest;
  const power = 10 ** Math.floor(Math.log10(most));
  const step = [5, 2, 1].find((each) => each * power <= most) ?? 1;
  return { length: step * power, pixels: (step * power) / resolution };
}

/** Draws the scale of a map at a resolution, units a pixel, and returns its length. */
export function showScale(host: HTMLElement, resolution: number): number {
  const { length, pixels } = scaleBar(resolution, LONGEST_BAR_PX);
  host.querySelector<HTMLElement>(".scale")?.style.setProperty("width", `${Math.round(pixels)}px`);
  return length;
}

/** What part of the map is shown: pixels of the page, metres a pixel, radians clockwise by which north is turned. */
export interface Sight {
  width: number;
  height: number;
  center: Coordinate;
  resolution: number;
  rotation: number;
}

/** Where a place is shown, pixels right and down. */
export function toPixel({ width, height, center, resolution, rotation }: Sight, [east, north]: readonly [number, number]): Coordinate {
  const [right, down] = [(east - center[0]) / resolution, (center[1] - north) / resolution];
  const [sine, cosine] = [Math.sin(rotation), Math.cos(rotation)];
  return [width / 2 + right * cosine - down * sine, height / 2 + right * sine + down * cosine];
}

/** The place that is shown at a pixel. */
export function toPlace({ width, height, center, resolution, rotation }: Sight, [x, y]: readonly [number, number]): Coordinate {
  const [across, below] = [(x - width / 2) * resolution, (y - height / 2) * resolution];
  const [sine, cosine] = [Math.sin(rotation), Math.cos(rotation)];
  return [center[0] + across * cosine + below * sine, center[1] + across * sine - below * cosine];
}

/** The smallest extent that holds everything that is shown. */
export function sightExtent(sight: Sight): Extent {
  const { width, height } = sight;
  const shown = [[0, 0], [width, 0], [width, height], [0, height]] as const;
  return extentOf(shown.map((corner) => toPlace(sight, corner))) ?? [0, 0, 0, 0];
}

/** Which part of the screen an extent takes up, pixels. */
export function onScreen(sight: Sight, [west, south, east, north]: Extent): Extent {
  const shown = [[west, south], [east, south], [east, north], [west, north]] as const;
  return extentOf(shown.map((corner) => toPixel(sight, corner))) ?? [0, 0, 0, 0];
}

/** Room beside what is shown as a whole, where the letters of rows stand, pixels. */
const BESIDE_PX = 28;

/** Room right and left of what is shown as a whole, clear of the tools at one of the map's edges. Pixels. */
export function roomBeside(map: Sides, tools: Sides = map): [number, number] {
  const [left, right] = [Math.max(0, tools.right - map.left), Math.max(0, map.right - tools.left)];
  return left === right ? [BESIDE_PX, BESIDE_PX] : [BESIDE_PX + (right < left ? right : 0), BESIDE_PX + (left < right ? left : 0)];
}

/** Edges of an element on the page, pixels. */
type Sides = Pick<DOMRect, "left" | "right">;

/** Where a card stands for a place on the screen: beside it, or `below`, and wholly within the map's element. Pixels. */
export function cardPlace(pixel: readonly [number, number], card: HTMLElement, within: HTMLElement, below = false): Coordinate {
  const { offsetWidth: width, offsetHeight: height } = card;
  const { clientWidth, clientHeight } = within;
  const hasRoom = pixel[0] + 32 + width < clientWidth - 8;
  const left = below ? pixel[0] - width / 2 : hasRoom ? pixel[0] + 32 : pixel[0] - 32 - width;
  const top = below ? pixel[1] + 24 : pixel[1] - height / 2;
  const limit = (value: number, most: number): number => Math.max(8, Math.min(value, Math.max(8, most - 8)));
  return [limit(left, clientWidth - width), limit(top, clientHeight - height)];
}
