import { type TileKey, tileName } from "../state/map-store.ts";
import { cellAt, inflateTile, maskOf } from "../state/tile-data.ts";
import { type Coordinate, type Extent, extentOf } from "./geometry.ts";
import type { Palette } from "./palette.ts";
import { changedSides, fade, seenWithRim, type Side, softened } from "./feather.ts";
import { classPixels, leaveOutUnseen, veilPixels } from "./tile-picture.ts";

export interface Grid {
  cells: number;
  cellSize: number;
}

/** Brings the ground of one survey onto the map: a turn about its origin, radians clockwise, then a shift, metres. */
export interface GroundPlace {
  north: number;
  east: number;
  turn: number;
}

/** Where the picture of a tile is asked for. */
export type TileAddress = (key: TileKey, version: number) => string;

export const LIVE_TILE: TileAddress = ({ row, column }, version) => `api/mosaic/${row}/${column}.jpg?v=${version}`;
/** Pictures of the ground that are drawn: the first ones, or all that were asked for. */
export type Arrived = "first" | "all";
const HERE: GroundPlace = { north: 0, east: 0, turn: 0 };

/** Ground that is shown: where the picture of each tile is asked for, where it lies, and its tiles. */
export interface Ground {
  address: TileAddress;
  place: GroundPlace;
  tiles: readonly TileKey[];
  /** Address of one picture of all tiles, coarser where they are many; null where there is none. */
  whole: string | null;
}

/** One picture of all tiles, in the frame of the ground. */
interface Whole {
  picture: ImageBitmap;
  extent: Extent;
  /** Metres a pixel. */
  resolution: number;
}

interface GroundTile {
  key: TileKey;
  classes: Uint8Array | null;
  classVersion: number;
  picture: ImageBitmap | null;
  /** Which cells the picture shows, 1 or 0; null: all. */
  mask: Uint8Array | null;
  pictureVersion: number;
  /** Composed from both. */
  canvas: HTMLCanvasElement | null;
  /** It must be composed again before it is drawn. */
  stale: boolean;
}

const FETCHES = 2;
/** HTTP's status of an answer with something in it. */
const OK = 200;
/** The picture of the whole may be stretched by so much before tiles are asked for. */
const STRETCHED = 1.25;

/** The ground's tiles: classes from heartbeats, pictures by HTTP, put together when they are drawn. */
export class GroundTiles {
  private readonly tiles = new Map<string, GroundTile>();
  private readonly wanted = new Map<string, { key: TileKey; version: number }>();
  private fetching = 0;
  private generation = 0;
  private palette: Palette | null = null;
  private scratch: HTMLCanvasElement | null = null;
  private pictured = true;
  private whole: Whole | null = null;
  private isWholeAsked = false;
  /** Tiles that are not asked for: the picture of the whole is fine enough. */
  private readonly spared = new Map<string, TileKey>();

  place: GroundPlace = HERE;
  address: TileAddress = LIVE_TILE;
  private readonly grid: Grid;
  private readonly changed: (isDone: boolean) => void;

  /** `changed` gets whether all that was asked for is here: then nothing is gathered before it is drawn. */
  constructor(
    grid: Grid,
    changed: (isDone: boolean) => void,
  ) {
    this.grid = grid;
    this.changed = changed;
  }

  /** Shows other ground: its tiles are asked for at another address, and lie elsewhere. */
  show({ address, place, tiles, whole }: Ground): void {
    this.clear();
    this.address = address;
    this.place = place;
    this.changed(false);
    if (whole !== null && tiles.length > 0) void this.fetchWhole(whole, tiles);
    else for (const key of tiles) this.takePicture(key, 1);
  }

  clear(): void {
    this.generation += 1;
    this.tiles.clear();
    this.wanted.clear();
    this.spared.clear();
    this.whole?.picture.close();
    this.whole = null;
    this.isWholeAsked = false;
  }

  recolour(palette: Palette): void {
    this.palette = palette;
    for (const tile of this.tiles.values()) tile.stale = true;
    this.changed(false);
  }

  /** Whether the pictures are drawn, or the classes of the cells alone. */
  showPictures(pictured: boolean): void {
    if (pictured === this.pictured) return;
    this.pictured = pictured;
    for (const tile of this.tiles.values()) tile.stale = true;
    this.changed(false);
  }

  /** Takes a changed tile of classes; one that cannot be read is left as it was. */
  async takeClasses(key: TileKey, version: number, data: string): Promise<void> {
    const generation = this.generation;
    const tile = this.tile(key);
    tile.classVersion = version;
    try {
      const classes = await inflateTile(data, this.grid.cells);
      if (generation !== this.generation || tile.classVersion !== version) return;
      const sides = changedSides(tile.classes, classes, this.grid.cells);
      tile.classes = classes;
      tile.stale = true;
      for (const side of sides) this.touch(key, side);
      this.changed(false);
    } catch (error) {
      console.warn("map tile", tileName(key), error);
    }
  }

  /** How many of the pictures that were asked for are here, or cannot be had: none yet, the first ones, or all. */
  get arrived(): "none" | Arrived {
    if (this.fetching === 0 && this.wanted.size === 0 && !this.isWholeAsked) return "all";
    return this.whole !== null || [...this.tiles.values()].some(({ picture }) => picture !== null) ? "first" : "none";
  }

  takePicture(key: TileKey, version: number): void {
    this.wanted.set(tileName(key), { key, version });
    this.fetchNext();
  }

  /** Class of the cell at a place, metres; 0 (unknown) where there is none. */
  classAt(north: number, east: number): number {
    const { row, column, index } = cellAt(north, east, this.grid.cells, this.grid.cellSize);
    return this.tiles.get(tileName({ row, column }))?.classes?.[index] ?? 0;
  }

  /**
   * Draws the ground in an extent of its own frame, at a resolution (metres a pixel), by a function that gets each picture, its
   * north-west corner, width and height, metres. Tiles that are finer than the picture of the whole are asked for then.
   */
  draw(extent: Extent, resolution: number, paint: (picture: CanvasImageSource, east: number, north: number, width: number, height: number) => void): void {
    const side = this.grid.cells * this.grid.cellSize;
    const inSight = (east: number, north: number): boolean => overlaps(extent, east, north, side);
    if (this.whole && this.pictured) {
      const [west, south, east, north] = this.whole.extent;
      paint(this.whole.picture, west, north, east - west, north - south);
      if (resolution * STRETCHED < this.whole.resolution) this.askWithin(extent);
    }
    for (const tile of this.tiles.values()) {
      const [east, north] = [tile.key.column * side, -tile.key.row * side];
      if (!inSight(east, north)) continue;
      if (tile.stale) this.compose(tile);
      if (tile.canvas) paint(tile.canvas, east, north, side, side);
    }
  }

  /** Draws the pictures in an extent, metres right (east) and down (south) of the origin. Returns whether there was one. */
  drawPictures(context: CanvasRenderingContext2D, [west, south, east, north]: Extent): boolean {
    const side = this.grid.cells * this.grid.cellSize;
    const extent = outOf(this.place, [west, south, east, north]);
    let drawn = false;
    context.translate(this.place.east, -this.place.north);
    context.rotate(this.place.turn);
    if (this.whole) {
      const [left, low, right, high] = this.whole.extent;
      context.drawImage(this.whole.picture, left, -high, right - left, high - low);
      drawn = true;
      this.askWithin(extent);
    }
    for (const { key, picture } of this.tiles.values()) {
      const [at, top] = [key.column * side, -key.row * side];
      if (!picture || !overlaps(extent, at, top, side)) continue;
      context.drawImage(picture, at, -top, side, side);
      drawn = true;
    }
    return drawn;
  }

  /** Asks for the tiles in an extent that were spared. */
  private askWithin(extent: Extent): void {
    const side = this.grid.cells * this.grid.cellSize;
    for (const [name, key] of this.spared) {
      if (!overlaps(extent, key.column * side, -key.row * side, side)) continue;
      this.spared.delete(name);
      this.takePicture(key, 1);
    }
  }

  /** Asks for one picture of all tiles; where it cannot be had, for each of them. */
  private async fetchWhole(address: string, tiles: readonly TileKey[]): Promise<void> {
    const generation = this.generation;
    this.isWholeAsked = true;
    const picture = await pictureAt(address);
    if (generation !== this.generation) {
      picture?.close();
      return;
    }
    this.isWholeAsked = false;
    const side = this.grid.cells * this.grid.cellSize;
    const extent = extentOf(tiles.flatMap(({ row, column }): Coordinate[] => [[column * side, -row * side], [(column + 1) * side, -(row + 1) * side]]));
    if (picture && extent) {
      this.whole = { picture, extent, resolution: (extent[2] - extent[0]) / picture.width };
      if (this.whole.resolution > this.grid.cellSize) for (const key of tiles) this.spared.set(tileName(key), key);
      this.changed(true);
    } else for (const key of tiles) this.takePicture(key, 1);
  }

  private tile(key: TileKey): GroundTile {
    const name = tileName(key);
    let tile = this.tiles.get(name);
    if (!tile) {
      const none = { classes: null, classVersion: -1, picture: null, mask: null, pictureVersion: -1, canvas: null };
      tile = { key, ...none, stale: false };
      this.tiles.set(name, tile);
    }
    return tile;
  }

  private fetchNext(): void {
    if (this.fetching >= FETCHES) return;
    const next = this.wanted.entries().next().value;
    if (!next) return;
    const [name, { key, version }] = next;
    this.wanted.delete(name);
    this.fetching += 1;
    void this.fetchPicture(key, version).finally(() => {
      this.fetching -= 1;
      this.fetchNext();
      if (this.fetching === 0) this.changed(true);
    });
  }

  private async fetchPicture(key: TileKey, version: number): Promise<void> {
    const generation = this.generation;
    try {
      const response = await fetch(this.address(key, version));
      if (!response.ok) return;
      const jpeg = await response.blob();
      const mask = await maskOf(new Uint8Array(await jpeg.arrayBuffer()), this.grid.cells);
      const picture = await createImageBitmap(jpeg);
      if (generation !== this.generation) return;
      const tile = this.tile(key);
      if (version < tile.pictureVersion) return;
      tile.picture?.close();
      Object.assign(tile, { picture, mask, pictureVersion: version, stale: true });
      this.changed(false);
    } catch (error) {
      console.warn("map picture", tileName(key), error);
    }
  }

  /** The edge of what was seen lies at the border of a tile: the tile beside it is softened again. */
  private touch(key: TileKey, side: Side): void {
    const tile = this.beside(key, side);
    if (tile) tile.stale = true;
  }

  private beside({ row, column }: TileKey, [down, right]: Side): GroundTile | undefined {
    return this.tiles.get(tileName({ row: row + down, column: column + right }));
  }

  private compose(tile: GroundTile): void {
    const palette = this.palette;
    const { cells: size } = this.grid;
    tile.canvas ??= newCanvas(size);
    const context = tile.canvas.getContext("2d");
    if (!palette || !context) return;
    tile.stale = false;
    context.clearRect(0, 0, size, size);
    const seen = seenWithRim(size, (side) => (side[0] === 0 && side[1] === 0 ? tile.classes : (this.beside(tile.key, side)?.classes ?? null)));
    const shown = softened(seen, size);
    const add = (pixels: Uint8ClampedArray<ArrayBuffer>): void => {
      fade(pixels, shown);
      this.paint(context, new ImageData(pixels, size));
    };
    if (tile.classes) add(classPixels(tile.classes, palette));
    if (tile.picture && this.pictured) this.paint(context, seenPart(tile.picture, tile.mask, size, seen, tile.classes !== null));
    if (tile.classes) add(veilPixels(tile.classes, palette));
  }

  /** Draws pixels over what is there: a canvas takes them only in place of it. */
  private paint(context: CanvasRenderingContext2D, pixels: ImageData): void {
    this.scratch ??= newCanvas(this.grid.cells);
    this.scratch.getContext("2d")?.putImageData(pixels, 0, 0);
    context.drawImage(this.scratch, 0, 0);
  }
}

/** The picture as far as it shows what was seen, softened at its edge. Changes `seen`. */
function seenPart(picture: ImageBitmap, mask: Uint8Array | null, size: number, seen: Uint8Array, known: boolean): ImageData {
  const context = newCanvas(size).getContext("2d", { willReadFrequently: true });
  if (!context) return new ImageData(size, size);
  context.drawImage(picture, 0, 0, size, size);
  const pixels = context.getImageData(0, 0, size, size);
  if (!known) seen.fill(1);
  if (mask) leaveOutUnseen(mask, size, seen);
  fade(pixels.data, softened(seen, size));
  return pixels;
}

/** An extent of the map, in the frame of the ground: the smallest one there that holds it. */
export function outOf({ north, east, turn }: GroundPlace, [west, south, right, top]: Extent): Extent {
  const [sine, cosine] = [Math.sin(turn), Math.cos(turn)];
  const places = [[west, south], [right, south], [right, top], [west, top]].map(([x = 0, y = 0]): Coordinate => {
    const [across, up] = [x - east, y - north];
    return [across * cosine - up * sine, across * sine + up * cosine];
  });
  return extentOf(places) ?? [west, south, right, top];
}

/** Whether a square, by its north-west corner and its side, has a part of an extent. */
function overlaps([west, south, right, top]: Extent, east: number, north: number, side: number): boolean {
  return east + side > west && north > south && east < right && north - side < top;
}

async function pictureAt(address: string): Promise<ImageBitmap | null> {
  try {
    const response = await fetch(address);
    return response.status === OK ? await createImageBitmap(await response.blob()) : null;
  } catch (error) {
    console.warn("map picture", address, error);
    return null;
  }
}

function newCanvas(size: number): HTMLCanvasElement {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = size;
  return canvas;
}
