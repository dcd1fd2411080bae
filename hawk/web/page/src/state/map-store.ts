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
  private readonly tiles = new Map<string, MapChange["tiles"][number]>();
  private readonly pictures = new Map<string, MapChange["pictures"][number]>();

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
      const found = { key: { row: tile.Row, column: tile.Column }, version: tile.Version, data: tile.Data };
      if (isNewer(this.tiles, found)) change.tiles.push(found);
    }
    for (const picture of update.Mosaic) {
      const found = { key: { row: picture.Row, column: picture.Column }, version: picture.Version };
      if (isNewer(this.pictures, found)) change.pictures.push(found);
    }
    return change;
  }

  /** All that is here as one change, for a map that begins later. */
  whole(): MapChange {
    return { reset: true, stalls: [...this.stalls.keys()], removed: [], tiles: [...this.tiles.values()], pictures: [...this.pictures.values()] };
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

  private clear(): void {
    this.stalls.clear();
    this.tiles.clear();
    this.pictures.clear();
  }
}

/** Keeps what is another version than the one that is there; returns whether it is. */
function isNewer<T extends { key: TileKey; version: number }>(all: Map<string, T>, found: T): boolean {
  const name = tileName(found.key);
  if (all.get(name)?.version === found.version) return false;
  all.set(name, found);
  return true;
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
