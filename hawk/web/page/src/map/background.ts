import type { LocalPlane } from "../fence/plane.ts";
import type { FenceCorner } from "../protocol.ts";
import { type Extent, toCoordinate } from "./geometry.ts";

/** A tile of the web's usual grid (XYZ, Web Mercator), y from the north. */
export interface WebTile {
  zoom: number;
  x: number;
  y: number;
}

/** Pixels a side of most tiles, by which their zoom is chosen. */
const TILE_PX = 256;
const EQUATOR_M = 40_075_016.7;
/** Tiles may be stretched by so much before finer ones are taken. */
const STRETCHED = 1.5;
/** More tiles are not drawn at once: so far away the background is of no use. */
const MOST_TILES = 120;
const KEPT = 240;
const FETCHES = 4;
const RADIANS = Math.PI / 180;

/** The north-west corner of a tile; x and y may lie within one. */
export function cornerOf({ zoom, x, y }: WebTile): FenceCorner {
  const count = 2 ** zoom;
  return { Latitude: Math.atan(Math.sinh(Math.PI * (1 - (2 * y) / count))) / RADIANS, Longitude: (x / count) * 360 - 180 };
}

/** Where a place lies in the grid of a zoom, in tiles. */
export function inGrid({ Latitude, Longitude }: FenceCorner, zoom: number): { x: number; y: number } {
  const count = 2 ** zoom;
  return { x: ((Longitude + 180) / 360) * count, y: ((1 - Math.asinh(Math.tan(Latitude * RADIANS)) / Math.PI) / 2) * count };
}

/** The lowest zoom that is fine enough for a resolution (metres a pixel), else the highest there is; null without any. */
export function zoomFor(zooms: readonly number[], resolution: number, latitude: number): number | null {
  const metres = (zoom: number): number => (EQUATOR_M * Math.cos(latitude * RADIANS)) / (TILE_PX * 2 ** zoom);
  return zooms.find((zoom) => metres(zoom) <= resolution * STRETCHED) ?? zooms.at(-1) ?? null;
}

/** The tiles of a zoom that hold a part of an extent; none where they would be too many. */
export function tilesIn([west, south, east, north]: Extent, zoom: number, plane: LocalPlane): WebTile[] {
  const ends = [[west, south], [east, south], [east, north], [west, north]].map(([e, n]) =>
    inGrid(plane.toEarth({ North: n ?? 0, East: e ?? 0 }), zoom),
  );
  const range = (values: number[]): number[] => {
    const first = Math.floor(Math.min(...values));
    return Array.from({ length: Math.floor(Math.max(...values)) - first + 1 }, (_, index) => first + index);
  };
  const [columns, rows] = [range(ends.map(({ x }) => x)), range(ends.map(({ y }) => y))];
  if (columns.length * rows.length > MOST_TILES) return [];
  return rows.flatMap((y) => columns.map((x) => ({ zoom, x, y })));
}

/** How a tile is drawn: a transformation of a square of one by one into pixels right (east) and down (south) of the origin. */
export function placement(tile: WebTile, plane: LocalPlane, resolution: number): readonly [number, number, number, number, number, number] {
  const at = (right: number, down: number): [number, number] => {
    const [east, north] = toCoordinate(plane.toMap(cornerOf({ ...tile, x: tile.x + right, y: tile.y + down })));
    return [east / resolution, -north / resolution];
  };
  const [origin, right, down] = [at(0, 0), at(1, 0), at(0, 1)];
  return [right[0] - origin[0], right[1] - origin[1], down[0] - origin[0], down[1] - origin[1], origin[0], origin[1]];
}

/** The picture of the ground that the drone's computer has of its own: tiles, fetched from it alone as they are needed. */
export class Background {
  /** Zooms of which there are tiles, lowest first. */
  zooms: readonly number[] = [];
  plane: LocalPlane | null = null;
  visible = true;

  /** A tile that is not there is null. */
  private readonly pictures = new Map<string, ImageBitmap | null>();
  private readonly wanted = new Map<string, WebTile>();
  private fetching = 0;
  private readonly changed: () => void;

  constructor(changed: () => void) {
    this.changed = changed;
  }

  /** Asks once which tiles there are. */
  async load(): Promise<void> {
    try {
      const response = await fetch("api/background.json");
      const found: unknown = response.ok ? await response.json() : null;
      const zooms = typeof found === "object" && found !== null ? (found as { Zooms?: unknown }).Zooms : null;
      if (Array.isArray(zooms)) this.zooms = zooms.filter((zoom): zoom is number => Number.isInteger(zoom));
      this.changed();
    } catch (error) {
      console.warn("background", error);
    }
  }

  /** Draws what there is of an extent, and fetches the rest. The context counts pixels right and down of the origin. */
  draw(context: CanvasRenderingContext2D, extent: Extent, resolution: number): void {
    const { plane } = this;
    const zoom = plane && this.visible ? zoomFor(this.zooms, resolution, plane.origin.Latitude) : null;
    this.wanted.clear();
    if (!plane || zoom === null) return;
    for (const tile of tilesIn(extent, zoom, plane)) {
      const name = `${tile.zoom}/${tile.x}/${tile.y}`;
      const picture = this.pictures.get(name);
      if (picture === undefined) this.wanted.set(name, tile);
      if (!picture) continue;
      context.save();
      context.transform(...placement(tile, plane, resolution));
      context.drawImage(picture, 0, 0, 1, 1);
      context.restore();
    }
    this.fetchNext();
  }

  private fetchNext(): void {
    const next = this.fetching < FETCHES ? this.wanted.keys().next().value : undefined;
    if (next === undefined) return;
    this.wanted.delete(next);
    this.fetching += 1;
    void this.fetchPicture(next).finally(() => {
      this.fetching -= 1;
      this.fetchNext();
    });
    this.fetchNext();
  }

  private async fetchPicture(name: string): Promise<void> {
    this.pictures.set(name, null);
    try {
      const response = await fetch(`api/background/${name}`);
      if (!response.ok || response.status === 204) return; // no picture of this ground
      this.pictures.set(name, await createImageBitmap(await response.blob()));
      this.forget();
      this.changed();
    } catch (error) {
      console.warn("background tile", name, error);
    }
  }

  /** The oldest go first; what is still in sight is fetched again. */
  private forget(): void {
    for (const [name, picture] of this.pictures) {
      if (this.pictures.size <= KEPT) return;
      this.pictures.delete(name);
      picture?.close();
    }
  }
}
