import { type TileKey, tileName } from "../state/map-store.ts";
import { cellAt, inflateTile } from "../state/tile-data.ts";
import type { Palette } from "./palette.ts";
import { classPixels, clearUnseen, veilPixels } from "./tile-picture.ts";

export interface Grid {
  cells: number;
  cellSize: number;
}

interface GroundTile {
  key: TileKey;
  classes: Uint8Array | null;
  classVersion: number;
  picture: ImageBitmap | null;
  pictureVersion: number;
  /** The picture without what was never seen, or null when there is another picture. */
  seen: HTMLCanvasElement | null;
  /** Composed from both. */
  canvas: HTMLCanvasElement | null;
  /** It must be composed again before it is drawn. */
  stale: boolean;
}

const FETCHES = 2;

/** The ground's tiles: classes from heartbeats, pictures by HTTP, put together when they are drawn. */
export class GroundTiles {
  private readonly tiles = new Map<string, GroundTile>();
  private readonly wanted = new Map<string, { key: TileKey; version: number }>();
  private fetching = 0;
  private generation = 0;
  private palette: Palette | null = null;
  private scratch: HTMLCanvasElement | null = null;
  private pictured = true;

  private readonly grid: Grid;
  private readonly changed: () => void;

  constructor(
    grid: Grid,
    changed: () => void,
  ) {
    this.grid = grid;
    this.changed = changed;
  }

  clear(): void {
    this.generation += 1;
    this.tiles.clear();
    this.wanted.clear();
  }

  recolour(palette: Palette): void {
    this.palette = palette;
    for (const tile of this.tiles.values()) tile.stale = true;
    this.changed();
  }

  /** Whether the pictures are drawn, or the classes of the cells alone. */
  showPictures(pictured: boolean): void {
    if (pictured === this.pictured) return;
    this.pictured = pictured;
    for (const tile of this.tiles.values()) tile.stale = true;
    this.changed();
  }

  /** Takes a changed tile of classes; one that cannot be read is left as it was. */
  async takeClasses(key: TileKey, version: number, data: string): Promise<void> {
    const generation = this.generation;
    const tile = this.tile(key);
    tile.classVersion = version;
    try {
      const classes = await inflateTile(data, this.grid.cells);
      if (generation !== this.generation || tile.classVersion !== version) return;
      tile.classes = classes;
      tile.stale = true;
      this.changed();
    } catch (error) {
      console.warn("map tile", tileName(key), error);
    }
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

  /** Draws the tiles that are in sight by a function that gets the picture, its north-west corner and its side, metres. */
  draw(
    inSight: (east: number, north: number, side: number) => boolean,
    paint: (picture: HTMLCanvasElement, east: number, north: number, side: number) => void,
  ): void {
    const side = this.grid.cells * this.grid.cellSize;
    for (const tile of this.tiles.values()) {
      const [east, north] = [tile.key.column * side, -tile.key.row * side];
      if (!inSight(east, north, side)) continue;
      if (tile.stale) this.compose(tile);
      if (tile.canvas) paint(tile.canvas, east, north, side);
    }
  }

  private tile(key: TileKey): GroundTile {
    const name = tileName(key);
    let tile = this.tiles.get(name);
    if (!tile) {
      const none = { classes: null, classVersion: -1, picture: null, pictureVersion: -1, seen: null, canvas: null };
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
    });
  }

  private async fetchPicture(key: TileKey, version: number): Promise<void> {
    const generation = this.generation;
    try {
      const response = await fetch(`api/mosaic/${key.row}/${key.column}.jpg?v=${version}`);
      if (!response.ok) return;
      const picture = await createImageBitmap(await response.blob());
      if (generation !== this.generation) return;
      const tile = this.tile(key);
      if (version < tile.pictureVersion) return;
      tile.picture?.close();
      Object.assign(tile, { picture, pictureVersion: version, seen: null, stale: true });
      this.changed();
    } catch (error) {
      console.warn("map picture", tileName(key), error);
    }
  }

  private compose(tile: GroundTile): void {
    const palette = this.palette;
    const size = this.grid.cells;
    tile.canvas ??= newCanvas(size);
    const context = tile.canvas.getContext("2d");
    if (!palette || !context) return;
    tile.stale = false;
    context.clearRect(0, 0, size, size);
    if (tile.classes) context.putImageData(new ImageData(classPixels(tile.classes, palette), size), 0, 0);
    if (tile.picture && this.pictured) context.drawImage((tile.seen ??= seenPart(tile.picture, size)), 0, 0);
    if (!tile.classes) return;
    this.scratch ??= newCanvas(size);
    this.scratch.getContext("2d")?.putImageData(new ImageData(veilPixels(tile.classes, palette), size), 0, 0);
    context.drawImage(this.scratch, 0, 0);
  }
}

function seenPart(picture: ImageBitmap, size: number): HTMLCanvasElement {
  const canvas = newCanvas(size);
  const context = canvas.getContext("2d", { willReadFrequently: true });
  if (!context) return canvas;
  context.drawImage(picture, 0, 0, size, size);
  const pixels = context.getImageData(0, 0, size, size);
  clearUnseen(pixels.data, size);
  context.putImageData(pixels, 0, 0);
  return canvas;
}

function newCanvas(size: number): HTMLCanvasElement {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = size;
  return canvas;
}
