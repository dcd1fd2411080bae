import type { FenceCorner } from "../protocol.ts";

/** A fence as a file holds it; the ceiling is the autopilot's, metres above the arm place. */
export interface FenceFile {
  corners: FenceCorner[];
  ceiling: number | null;
}

/** A file that holds no fence; the message says in words what is wrong and what to do. */
export class FenceFileError extends Error {}

/** A fence is a few kilobytes; what is larger is something else. */
export const LARGEST_FILE = 1_000_000;

/** Reads GeoJSON (RFC 7946) with exactly one Polygon in it. Raises FenceFileError. */
export function readFence(text: string): FenceFile {
  const content = parse(text);
  const features: unknown = isObject(content) && Array.isArray(content.features) ? content.features : [content];
  const found = Array.isArray(features) && features.length === 1 ? (features[0] as unknown) : null;
  const geometry = isObject(found) && isObject(found.geometry) ? found.geometry : found;
  if (!isObject(found) || !isObject(geometry) || geometry.type !== "Polygon") {
    throw new FenceFileError("The file must hold exactly one polygon. Save the fence alone, as GeoJSON.");
  }
  const rings = geometry.coordinates;
  if (!Array.isArray(rings) || rings.length !== 1 || !Array.isArray(rings[0])) {
    throw new FenceFileError("The polygon must be one ring without holes.");
  }
  const ceiling = isObject(found.properties) ? found.properties.ceiling_m : undefined;
  return { corners: corners(rings[0]), ceiling: typeof ceiling === "number" && ceiling > 0 ? ceiling : null };
}

/** Writes a Feature; its ring is closed and runs counterclockwise. */
export function writeFence(fence: FenceFile): string {
  const positions = fence.corners.map((corner) => [corner.Longitude, corner.Latitude]);
  if (turnsClockwise(fence.corners)) positions.reverse();
  const feature = {
    type: "Feature",
    properties: { name: "fence", ceiling_m: fence.ceiling },
    geometry: { type: "Polygon", coordinates: [[...positions, positions[0]]] },
  };
  return `${JSON.stringify(feature, null, 1)}\n`;
}

function parse(text: string): unknown {
  try {
    return JSON.parse(text);
  } catch {
    throw new FenceFileError("The file is not GeoJSON. Save the fence as GeoJSON.");
  }
}

function corners(ring: unknown[]): FenceCorner[] {
  const found = ring.map((position, index) => corner(position, index + 1));
  const [first, last] = [found[0], found.at(-1)];
  const closed = first && last && found.length > 1 && first.Latitude === last.Latitude && first.Longitude === last.Longitude;
  const open = closed ? found.slice(0, -1) : found;
  if (open.length < 3) throw new FenceFileError(`The polygon has ${open.length} corners. A fence needs at least 3.`);
  return open;
}

function corner(position: unknown, number: number): FenceCorner {
  const [longitude, latitude] = Array.isArray(position) ? (position as unknown[]) : [];
  if (!isDegrees(longitude, 180) || !isDegrees(latitude, 90)) {
    throw new FenceFileError(`Corner ${number} is no place on Earth. Longitude comes before latitude, in degrees (WGS-84).`);
  }
  return { Latitude: latitude, Longitude: longitude };
}

function isDegrees(value: unknown, most: number): value is number {
  return typeof value === "number" && Number.isFinite(value) && Math.abs(value) <= most;
}

function isObject(value: unknown): value is Record<string, unknown> {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}

function turnsClockwise(ring: readonly FenceCorner[]): boolean {
  let sum = 0;
  ring.forEach((here, index) => {
    const there = ring[(index + 1) % ring.length] ?? here;
    sum += (there.Longitude - here.Longitude) * (there.Latitude + here.Latitude);
  });
  return sum > 0;
}
