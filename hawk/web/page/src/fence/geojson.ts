import type { FenceCorner } from "../protocol.ts";
import { say } from "../words/say.ts";

/** A fence as a file holds it; the ceiling is the autopilot's, metres above the arm place. */
export interface FenceFile {
  corners: FenceCorner[];
  /** Exclusion zones: the polygon's interior rings. */
  zones: FenceCorner[][];
  ceiling: number | null;
}

/** A file that holds no fence; the message says in words what is wrong and what to do. */
export class FenceFileError extends Error {}

/** Bytes that the drone's server reads; a fence is a few kilobytes, an area among other layers may have more. */
export const LARGEST_FILE = 4_000_000;

/** What a file holds, in words. */
type Kind = "fence" | "outline";

interface Polygon {
  rings: unknown[][];
  properties: Record<string, unknown>;
}

/**
 * Reads GeoJSON (RFC 7946) with one Polygon in it, whose interior rings are exclusion zones. Beside it there may be
 * Polygons with the property "exclusion": true, which are zones, too. Raises FenceFileError.
 */
export function readFence(text: string, kind: Kind = "fence"): FenceFile {
  const content = parse(text, kind);
  const features: unknown[] = isObject(content) && Array.isArray(content.features) ? content.features : [content];
  const polygons = features.map((feature) => polygon(feature, kind));
  const [fence, second] = polygons.filter((each) => each.properties.exclusion !== true);
  if (!fence || second) throw new FenceFileError(say("file-one-polygon", { kind }));
  const apart = polygons.filter((each) => each.properties.exclusion === true);
  if (apart.some((each) => each.rings.length !== 1)) throw new FenceFileError(say("file-zone-holes"));
  const [outer = [], ...inner] = fence.rings;
  const ceiling = fence.properties.ceiling_m;
  return {
    corners: corners(outer, null),
    zones: [...inner, ...apart.map((each) => each.rings[0] ?? [])].map((ring, index) => corners(ring, index + 1)),
    ceiling: typeof ceiling === "number" && ceiling > 0 ? ceiling : null,
  };
}

/** Writes a Feature; its rings are closed, the outer one runs counterclockwise, those of zones clockwise. */
export function writeFence(fence: FenceFile, kind: Kind = "fence"): string {
  const feature = {
    type: "Feature",
    properties: kind === "fence" ? { name: kind, ceiling_m: fence.ceiling } : { name: kind },
    geometry: { type: "Polygon", coordinates: [positions(fence.corners, false), ...fence.zones.map((zone) => positions(zone, true))] },
  };
  return `${JSON.stringify(feature, null, 1)}\n`;
}

function positions(ring: readonly FenceCorner[], clockwise: boolean): number[][] {
  const found = ring.map((corner) => [corner.Longitude, corner.Latitude]);
  if (turnsClockwise(ring) !== clockwise) found.reverse();
  return [...found, ...found.slice(0, 1)];
}

function polygon(feature: unknown, kind: Kind): Polygon {
  const geometry = isObject(feature) && isObject(feature.geometry) ? feature.geometry : feature;
  if (!isObject(feature) || !isObject(geometry) || geometry.type !== "Polygon") throw new FenceFileError(say("file-one-polygon", { kind }));
  const rings: unknown = geometry.coordinates;
  if (!Array.isArray(rings) || rings.length === 0 || !rings.every((ring) => Array.isArray(ring))) {
    throw new FenceFileError(say("file-no-ring"));
  }
  return { rings, properties: isObject(feature.properties) ? feature.properties : {} };
}

function parse(text: string, kind: Kind): unknown {
  try {
    return JSON.parse(text);
  } catch {
    throw new FenceFileError(say("file-not-geojson", { kind }));
  }
}

/** `zone`: its number; null for the polygon itself. */
function corners(ring: unknown[], zone: number | null): FenceCorner[] {
  const found = ring.map((position, index) => corner(position, index + 1, zone));
  const [first, last] = [found[0], found.at(-1)];
  const closed = first && last && found.length > 1 && first.Latitude === last.Latitude && first.Longitude === last.Longitude;
  const open = closed ? found.slice(0, -1) : found;
  const few = { corners: open.length };
  if (open.length < 3) throw new FenceFileError(zone === null ? say("file-polygon-few", few) : say("file-zone-few", { zone, ...few }));
  return open;
}

function corner(position: unknown, number: number, zone: number | null): FenceCorner {
  const [longitude, latitude] = Array.isArray(position) ? (position as unknown[]) : [];
  if (!isDegrees(longitude, 180) || !isDegrees(latitude, 90)) {
    const where = { corner: number };
    throw new FenceFileError(zone === null ? say("file-polygon-no-place", where) : say("file-zone-no-place", { zone, ...where }));
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
