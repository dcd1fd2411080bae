import type { MapUpdate, StallUpdate } from "../protocol.ts";

export type CountedState = "free" | "taken" | "unknown";
export type StallState = CountedState | "suggested";

export interface Stall {
  id: number;
  north: number;
  east: number;
  angle: number;
  width: number;
  length: number;
  state: StallState;
  /** Probability that it is taken, if known. */
  taken: number | null;
  seen: number | null;
  lastSeen: number | null;
  /** In the plan of a known lot; else its number. */
  label: string;
  /** Fifth of the surveys that found it taken, 0 to 4: it is coloured by that instead of its state. */
  heat?: number;
}

export interface TileKey {
  row: number;
  column: number;
}

/** What an update changed. `reset`: everything that was there before is void. */
export interface MapChange {
  reset: boolean;
  stalls: number[];
  removed: number[];
  tiles: { key: TileKey; version: number; data: string }[];
  pictures: { key: TileKey; version: number }[];
}

export function tileName(key: TileKey): string {
  return `${key.row}/${key.column}`;
}

/** The map as this page knows it, built up from the changes that heartbeats carry. */
export class MapStore {
  readonly stalls = new Map<number, Stall>();
  backlog = 0;

  private mapId: string | null = null;
  private fresh = false;
  private readonly tiles = new Map<string, number>();
  private readonly pictures = new Map<string, number>();

  /** The server will send everything again: what is here is void with the next update. */
  expectAll(): void {
    this.fresh = true;
  }

  apply(update: MapUpdate): MapChange {
    const reset = this.fresh || (this.mapId !== null && this.mapId !== update["Map Id"]);
    if (reset) this.clear();
    this.fresh = false;
    this.mapId = update["Map Id"];
    this.backlog = update.Backlog;
    const change: MapChange = { reset, stalls: [], removed: [], tiles: [], pictures: [] };
    for (const stall of update.Stalls) this.applyStall(stall, change);
    for (const tile of update.Tiles) {
      const key = { row: tile.Row, column: tile.Column };
      if (!this.newer(this.tiles, key, tile.Version)) continue;
      change.tiles.push({ key, version: tile.Version, data: tile.Data });
    }
    for (const picture of update.Mosaic) {
      const key = { row: picture.Row, column: picture.Column };
      if (this.newer(this.pictures, key, picture.Version)) change.pictures.push({ key, version: picture.Version });
    }
    return change;
  }

  private applyStall(update: StallUpdate, change: MapChange): void {
    if (update.Removed) {
      if (this.stalls.delete(update.Id)) change.removed.push(update.Id);
      return;
    }
    const stall = complete(update);
    if (!stall) return;
    this.stalls.set(stall.id, stall);
    change.stalls.push(stall.id);
  }

  private newer(versions: Map<string, number>, key: TileKey, version: number): boolean {
    const name = tileName(key);
    if (versions.get(name) === version) return false;
    versions.set(name, version);
    return true;
  }

  private clear(): void {
    this.stalls.clear();
    this.tiles.clear();
    this.pictures.clear();
  }
}

function complete(update: StallUpdate): Stall | null {
  const { North: north, East: east, Angle: angle, Width: width, Length: length, State: state } = update;
  if (north === null || east === null || angle === null || width === null || length === null) return null;
  return {
    id: update.Id,
    north,
    east,
    angle,
    width,
    length,
    state: state ?? "unknown",
    taken: update.Taken,
    seen: update.Seen,
    lastSeen: update["Last Seen"],
    label: update.Label ?? String(update.Id),
  };
}
