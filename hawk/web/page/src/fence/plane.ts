import type { FenceCorner, Point } from "../protocol.ts";

const RADIANS = Math.PI / 180;
/** WGS-84: semi-major axis in metres, square of the eccentricity. */
const AXIS = 6378137;
const FLATTENING = 1 / 298.257223563;
const ECCENTRICITY2 = FLATTENING * (2 - FLATTENING);

type Vector = readonly [number, number, number];

/** The tangent plane at a place on Earth: north and east in metres, as the drone's map has it (height 0). */
export class LocalPlane {
  readonly origin: FenceCorner;
  private readonly centre: Vector;
  private readonly north: Vector;
  private readonly east: Vector;
  private readonly up: Vector;

  constructor(origin: FenceCorner) {
    this.origin = origin;
    const [latitude, longitude] = [origin.Latitude * RADIANS, origin.Longitude * RADIANS];
    const [sinLat, cosLat] = [Math.sin(latitude), Math.cos(latitude)];
    const [sinLon, cosLon] = [Math.sin(longitude), Math.cos(longitude)];
    this.centre = earthFixed(origin);
    this.north = [-sinLat * cosLon, -sinLat * sinLon, cosLat];
    this.east = [-sinLon, cosLon, 0];
    this.up = [cosLat * cosLon, cosLat * sinLon, sinLat];
  }

  toMap(corner: FenceCorner): Point {
    const place = earthFixed(corner);
    const offset: Vector = [place[0] - this.centre[0], place[1] - this.centre[1], place[2] - this.centre[2]];
    return { North: dot(this.north, offset), East: dot(this.east, offset) };
  }

  /** The place on the ellipsoid over or under a place of the plane: the height is found by going round three times. */
  toEarth(place: Point): FenceCorner {
    let down = 0;
    let corner = this.origin;
    for (let round = 0; round < 3; round += 1) {
      const found = geodetic(this.at(place, -down));
      corner = { Latitude: found.latitude, Longitude: found.longitude };
      down += found.height;
    }
    return corner;
  }

  private at(place: Point, up: number): Vector {
    const along = (axis: 0 | 1 | 2): number =>
      this.centre[axis] + place.North * this.north[axis] + place.East * this.east[axis] + up * this.up[axis];
    return [along(0), along(1), along(2)];
  }
}

function dot(a: Vector, b: Vector): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

function earthFixed({ Latitude, Longitude }: FenceCorner): Vector {
  const [latitude, longitude] = [Latitude * RADIANS, Longitude * RADIANS];
  const radius = AXIS / Math.sqrt(1 - ECCENTRICITY2 * Math.sin(latitude) ** 2);
  const out = radius * Math.cos(latitude);
  return [out * Math.cos(longitude), out * Math.sin(longitude), radius * (1 - ECCENTRICITY2) * Math.sin(latitude)];
}

/** Bowring's iteration, which converges to less than a millimetre in a few rounds near the ground. */
function geodetic([x, y, z]: Vector): { latitude: number; longitude: number; height: number } {
  const out = Math.hypot(x, y);
  let latitude = Math.atan2(z, out * (1 - ECCENTRICITY2));
  let radius = AXIS;
  for (let round = 0; round < 5; round += 1) {
    radius = AXIS / Math.sqrt(1 - ECCENTRICITY2 * Math.sin(latitude) ** 2);
    latitude = Math.atan2(z + ECCENTRICITY2 * radius * Math.sin(latitude), out);
  }
  const sine = Math.sin(latitude);
  const height = out * Math.cos(latitude) + z * sine - AXIS * Math.sqrt(1 - ECCENTRICITY2 * sine ** 2);
  return { latitude: latitude / RADIANS, longitude: Math.atan2(y, x) / RADIANS, height };
}
