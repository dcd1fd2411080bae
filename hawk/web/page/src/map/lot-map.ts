import { defaults as defaultInteractions } from "ol/interaction/defaults.js";
import OlMap from "ol/Map.js";
import type MapBrowserEvent from "ol/MapBrowserEvent.js";
import Projection from "ol/proj/Projection.js";
import View from "ol/View.js";
import type { Point } from "../protocol.ts";
import type { MapChange, MapStore, Stall } from "../state/map-store.ts";
import type { Layers } from "../state/preferences.ts";
import { drawScene } from "./draw-scene.ts";
import { FenceEditor, type FenceEditorEvents, type Ring } from "./fence-editor.ts";
import { EMPTY_SCENE, type Scene } from "./flight-scene.ts";
import { corners, covers, type Extent, extentOf, toCoordinate, turn } from "./geometry.ts";
import { GroundLayer, resize } from "./ground-layer.ts";
import { GroundTiles } from "./ground-tiles.ts";
import { readPalette } from "./palette.ts";
import { StallsLayer } from "./stalls-layer.ts";

export type Looking = "follow" | "whole" | "free";

export interface LotMapEvents {
  /** A place was clicked, with the stall that is there. */
  clicked(place: Point, stall: number | null): void;
  /** The view or something on it moved: what lies over it in the page must move too. */
  moved(): void;
  looking(looking: Looking): void;
}

const HALF_WORLD_M = 5000;
/** Heartbeats come every 200 ms; the drone's mark glides from one place to the next in so long. */
const GLIDE_MS = 200;
const GLIDE_STEP_MS = 100;
/** Ground redraws are gathered for so long. */
const REDRAW_MS = 400;
const FOLLOW_RESOLUTION = 0.14;
const EASE_MS = 150;
/** A whole lot that takes up less of the view than this is brought nearer. */
const LEAST_FILLED = 0.7;

/** The map: a metre grid of its own (east, north), drawn when something changes and not otherwise. */
export class LotMap {
  looking: Looking = "whole";

  private readonly map: OlMap;
  private readonly view: View;
  private readonly tiles: GroundTiles;
  private readonly ground: GroundLayer;
  private readonly stalls: StallsLayer;
  private readonly overlay = document.createElement("canvas");
  private scene: Scene = EMPTY_SCENE;
  private shown: Scene["drone"] = null;
  /** What is to come into view once the map has a size: on a phone it may be hidden behind a panel. */
  private wanted: Extent | null = null;
  private glide: { from: Scene["drone"]; began: number } | null = null;
  private glideTimer = 0;
  private redrawTimer = 0;
  private lot: Extent | null = null;
  private editor: FenceEditor | null = null;
  private readonly still = matchMedia("(prefers-reduced-motion: reduce)");
  private readonly sizeWatch: ResizeObserver;

  private readonly element: HTMLElement;
  private readonly events: LotMapEvents;

  constructor(
    element: HTMLElement,
    grid: { cells: number; cellSize: number },
    events: LotMapEvents,
  ) {
    this.element = element;
    this.events = events;
    const extent: Extent = [-HALF_WORLD_M, -HALF_WORLD_M, HALF_WORLD_M, HALF_WORLD_M];
    const projection = new Projection({ code: "hawk:map", units: "m", extent });
    this.view = new View({
      projection,
      center: [0, 0],
      resolution: 0.3,
      minResolution: 0.02,
      maxResolution: 2,
      constrainResolution: false,
      enableRotation: false,
    });
    this.tiles = new GroundTiles(grid, () => this.redrawSoon());
    this.ground = new GroundLayer(this.tiles);
    this.stalls = new StallsLayer(window.devicePixelRatio);
    this.map = new OlMap({
      target: element,
      layers: [this.ground, this.stalls.layer],
      view: this.view,
      controls: [],
      interactions: defaultInteractions({ altShiftDragRotate: false, pinchRotate: false }),
    });
    this.overlay.className = "flight";
    element.querySelector(".ol-layers")?.after(this.overlay);
    this.listen();
    this.sizeWatch = new ResizeObserver(() => this.sized());
    this.sizeWatch.observe(element);
    this.recolour();
  }

  dispose(): void {
    this.sizeWatch.disconnect();
    clearTimeout(this.glideTimer);
    clearTimeout(this.redrawTimer);
    this.map.setTarget(undefined);
  }

  recolour(): void {
    const palette = readPalette(this.element);
    this.ground.palette = palette;
    this.tiles.recolour(palette);
    this.ground.changed();
    this.editor?.recolour(palette);
    this.drawOverlay();
  }

  /** Shows or hides what lies under the flight. */
  showLayers({ stalls, picture }: Layers): void {
    this.stalls.layer.setVisible(stalls);
    this.tiles.showPictures(picture);
  }

  /** Opens the fence editor; null closes it. The map keeps still under the corners: it follows nothing from then on. */
  editFence(events: FenceEditorEvents | null): FenceEditor | null {
    if (events) this.leave();
    this.editor?.dispose();
    this.editor = events ? new FenceEditor(this.map, readPalette(this.element), events) : null;
    return this.editor;
  }

  /** Brings a ring into view, at once or as soon as the map is shown; nothing happens when it is there already. */
  bringInView(ring: Ring): void {
    this.leave();
    this.wanted = extentOf(ring.map(([east, north]): [number, number] => [east, north]));
    this.showWanted();
  }

  private showWanted(): void {
    const size = this.map.getSize();
    if (!this.wanted || !size?.[0] || !size[1]) return;
    const inView = covers(this.view.calculateExtent(size) as Extent, this.wanted);
    if (!inView) this.view.fit(this.wanted, { padding: [76, 68, 60, 68], size });
    this.wanted = null;
  }

  /** Takes what a heartbeat changed of the map. */
  apply(change: MapChange, store: MapStore): void {
    if (change.reset) {
      this.tiles.clear();
      this.stalls.clear();
      this.lot = null;
      this.redrawSoon();
    }
    for (const { key, version, data } of change.tiles) void this.tiles.takeClasses(key, version, data);
    for (const { key, version } of change.pictures) this.tiles.takePicture(key, version);
    for (const id of change.removed) this.stalls.remove(id);
    for (const id of change.stalls) {
      const stall = store.stalls.get(id);
      if (stall) this.stalls.put(stall);
    }
    if (change.stalls.length > 0) this.lot = extentOf([...store.stalls.values()].flatMap(corners));
  }

  /** Takes what lies over the ground; the drone's mark glides to its new place. */
  setScene(scene: Scene): void {
    const before = this.scene;
    this.scene = scene;
    this.startGlide(before);
    this.keepInView();
    const same = before.planned === scene.planned && before.selected === scene.selected && before.lost === scene.lost;
    if (!this.glide || !same) this.drawOverlay();
  }

  classAt(place: Point): number {
    return this.tiles.classAt(place.North, place.East);
  }

  zoom(factor: number): void {
    const resolution = this.view.getResolution() ?? 0.3;
    this.view.animate({ resolution: resolution / factor, duration: this.still.matches ? 0 : EASE_MS });
  }

  look(looking: Looking): void {
    this.looking = looking;
    if (looking === "whole") this.fitWhole();
    if (looking === "follow") this.centreOnDrone(true);
    this.events.looking(looking);
  }

  /** Place on the screen, in pixels of the map's element; null while there is nothing to say. */
  pixelOf(place: Point): [number, number] | null {
    const pixel = this.map.getPixelFromCoordinate(toCoordinate(place)) as number[] | null;
    return pixel ? [pixel[0] ?? 0, pixel[1] ?? 0] : null;
  }

  /** Place in the middle of what is shown. */
  get centre(): Point {
    const [east, north] = this.view.getCenter() ?? [];
    return { North: north ?? 0, East: east ?? 0 };
  }

  get resolution(): number {
    return this.view.getResolution() ?? 0.3;
  }

  private listen(): void {
    this.map.on("postrender", () => {
      this.drawOverlay();
      this.events.moved();
    });
    this.map.on("pointerdrag", () => this.leave());
    this.element.addEventListener("wheel", () => this.leave(), { passive: true });
    this.map.on("click", (event: MapBrowserEvent) => {
      const [east, north] = event.coordinate;
      if (east === undefined || north === undefined || this.editor) return;
      this.events.clicked({ North: north, East: east }, this.stallAt(event.pixel));
    });
  }

  private stallAt(pixel: number[]): number | null {
    const options = { layerFilter: (layer: unknown) => layer === this.stalls.layer, hitTolerance: 2 };
    const id = this.map.forEachFeatureAtPixel(pixel, (feature) => feature.getId(), options);
    return typeof id === "number" ? id : null;
  }

  /** The operator moved the map: it stays where it was put. */
  private leave(): void {
    if (this.looking === "free") return;
    this.looking = "free";
    this.events.looking("free");
  }

  private sized(): void {
    this.map.updateSize();
    this.showWanted();
    if (this.looking === "whole") this.fitWhole();
  }

  private redrawSoon(): void {
    if (this.redrawTimer !== 0 || document.hidden) return;
    this.redrawTimer = window.setTimeout(() => {
      this.redrawTimer = 0;
      this.ground.repaint();
    }, REDRAW_MS);
  }

  private drawOverlay(): void {
    const context = this.overlay.getContext("2d");
    const [width, height] = this.map.getSize() ?? [0, 0];
    const palette = this.ground.palette;
    if (!context || !palette || width === undefined || height === undefined || document.hidden) return;
    const ratio = window.devicePixelRatio;
    resize(this.overlay, width, height, ratio);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    const resolution = this.resolution;
    const [centreEast, centreNorth] = this.view.getCenter() ?? [0, 0];
    const pixel = ([east, north]: readonly [number, number]): [number, number] => [
      width / 2 + (east - (centreEast ?? 0)) / resolution,
      height / 2 - (north - (centreNorth ?? 0)) / resolution,
    ];
    drawScene({ context, palette, resolution, pixel }, { ...this.scene, drone: this.shown });
  }

  private startGlide(before: Scene): void {
    const target = this.scene.drone;
    if (this.still.matches || document.hidden || !this.shown || !target || !before.drone) {
      this.shown = target;
      this.glide = null;
      return;
    }
    const pixels = Math.hypot(target.north - this.shown.north, target.east - this.shown.east) / this.resolution;
    const turned = Math.abs(turn(0, target.yaw - this.shown.yaw, 1));
    if (pixels < 0.5 && turned < 0.02) return;
    this.glide = { from: this.shown, began: performance.now() };
    if (this.glideTimer === 0) this.glideTimer = window.setTimeout(this.glideStep, GLIDE_STEP_MS);
  }

  private readonly glideStep = (): void => {
    this.glideTimer = 0;
    const target = this.scene.drone;
    if (!this.glide?.from || !target) return;
    const { from, began } = this.glide;
    const share = Math.min(1, (performance.now() - began) / GLIDE_MS);
    this.shown = {
      north: from.north + (target.north - from.north) * share,
      east: from.east + (target.east - from.east) * share,
      yaw: turn(from.yaw, target.yaw, share),
    };
    this.drawOverlay();
    this.events.moved();
    if (share < 1) this.glideTimer = window.setTimeout(this.glideStep, GLIDE_STEP_MS);
    else this.glide = null;
  };

  private keepInView(): void {
    if (this.looking === "follow") this.centreOnDrone(false);
    if (this.looking !== "whole") return;
    const wanted = this.whole();
    const size = this.map.getSize();
    if (wanted && size && !fills(this.view.calculateExtent(size) as Extent, wanted)) this.fitWhole();
  }

  /** Brings the drone to the middle; unless asked to, only when it has come near the edge. */
  private centreOnDrone(atOnce: boolean): void {
    const drone = this.scene.drone;
    const [width, height] = this.map.getSize() ?? [0, 0];
    if (!drone || !width || !height || this.view.getAnimating()) return;
    const pixel = this.pixelOf({ North: drone.north, East: drone.east });
    const inside =
      pixel !== null && Math.abs(pixel[0] / width - 0.5) < 0.25 && Math.abs(pixel[1] / height - 0.5) < 0.25;
    if (inside && !atOnce) return;
    const resolution = atOnce && this.resolution > 2 * FOLLOW_RESOLUTION ? FOLLOW_RESOLUTION : this.resolution;
    this.view.animate({ center: [drone.east, drone.north], resolution, duration: this.still.matches ? 0 : EASE_MS });
  }

  private fitWhole(): void {
    const whole = this.whole();
    const size = this.map.getSize();
    if (!whole || !size?.[0] || !size[1]) return;
    const padding = size[1] < 300 ? [12, 60, 12, 60] : [28, 68, 52, 68];
    this.view.fit(whole, { padding, minResolution: 0.05, size });
  }

  /** The lot as far as it was seen with drone and home, else the fence. */
  private whole(): Extent | null {
    const marks: Point[] = [];
    const { drone, home } = this.scene;
    const fence = this.scene.limit.length > 2 ? this.scene.limit : this.scene.fence;
    if (drone) marks.push({ North: drone.north, East: drone.east });
    if (home) marks.push(home);
    const places = marks.map(toCoordinate);
    if (!this.lot) return extentOf(fence.length > 2 ? fence.map(toCoordinate) : around(places));
    const [west, south, east, north] = this.lot;
    return extentOf([...places, [west, south], [east, north]]);
  }
}

/** Whether a view shows all of an extent, and not much else. */
function fills(view: Extent, wanted: Extent): boolean {
  const share = Math.max((wanted[2] - wanted[0]) / (view[2] - view[0]), (wanted[3] - wanted[1]) / (view[3] - view[1]));
  return covers(view, wanted) && share > LEAST_FILLED;
}

/** Room around places when there is nothing else to show. */
function around(places: [number, number][]): [number, number][] {
  return places.flatMap(([east, north]): [number, number][] => [
    [east - 40, north - 40],
    [east + 40, north + 40],
  ]);
}

export type { Stall };
