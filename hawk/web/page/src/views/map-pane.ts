import { API } from "../link/api.ts";
import type { Arrived } from "../map/ground-tiles.ts";
import type { Scene } from "../map/flight-scene.ts";
import { LotMap, type LotMapEvents } from "../map/lot-map.ts";
import { SectionsLayer } from "../map/sections-layer.ts";
import { MapStore, type Stall } from "../state/map-store.ts";
import { ALL_LAYERS } from "../state/preferences.ts";
import type { SurveyOnMap } from "./survey-source.ts";

/** As the drone makes pictures of the ground. */
const GRID = { cells: 256, cellSize: 0.1 };

/** A map of one survey: of two beside or over each other both show the same place. */
export class MapPane {
  readonly map: LotMap;
  source: SurveyOnMap | null = null;
  /** How much of the survey's pictures is drawn, with its stalls. */
  drawn: Arrived | null = null;
  readonly sections = new SectionsLayer();
  private readonly store = new MapStore();

  constructor(holder: HTMLElement, events: LotMapEvents, beside: MapPane | null = null) {
    this.map = new LotMap(holder, GRID, events, false, beside?.map ?? null);
    this.map.showLayers(ALL_LAYERS, null);
    this.map.addLayer(this.sections);
    if (beside) this.map.stay();
  }

  /** Shows another survey. Returns whether it is of another lot: place and zoom stay while those of one lot follow each other. */
  show(source: SurveyOnMap | null): boolean {
    const before = this.source;
    if (source === before) return false;
    this.source = source;
    if (source?.survey !== before?.survey) this.drawn = null;
    const { map, store } = this;
    store.stalls.clear();
    for (const stall of source?.stalls ?? []) store.stalls.set(stall.id, stall);
    const address = `${API}/surveys/${source?.survey ?? ""}/ground`;
    const { place, tiles } = source?.ground ?? { place: { north: 0, east: 0, turn: 0 }, tiles: [] };
    const isShown = source?.ground && before?.ground && source.survey === before.survey; // a moment of a film follows another one
    if (!isShown) map.showGround({ address: ({ row, column }) => `${address}/${row}/${column}`, place, tiles: tiles.map(([row, column]) => ({ row, column })), whole: `${address}/whole` });
    const removed = (before?.stalls ?? []).map(({ id }) => id).filter((id) => !store.stalls.has(id));
    map.apply({ reset: false, stalls: [...store.stalls.keys()], removed, tiles: [], pictures: [] }, store);
    map.showLabels(source?.rows ?? []);
    const [one, other] = [before?.plane.origin, source?.plane.origin];
    return source !== null && (one?.Latitude !== other?.Latitude || one?.Longitude !== other?.Longitude);
  }

  stall(id: string): Stall | undefined {
    return this.source?.stalls[id === "" ? -1 : this.source.ids.indexOf(id)];
  }

  idOf(stall: number | null): string {
    return stall === null ? "" : (this.source?.ids[stall] ?? "");
  }

  /** Shows what lies over the ground, frames stalls, and one of them stronger. */
  mark(scene: Scene, ids: ReadonlySet<string>, chosen: Stall | undefined): void {
    const marked = ids.size === 0 ? [] : (this.source?.stalls ?? []).filter((_, index) => ids.has(this.source?.ids[index] ?? ""));
    this.map.setScene({ ...scene, marked, selected: chosen ?? null });
  }
}
