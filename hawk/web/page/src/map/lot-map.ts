import { defaults as defaultInteractions } from "ol/interaction/defaults.js";
import type Layer from "ol/layer/Layer.js";
import OlMap from "ol/Map.js";
import type MapBrowserEvent from "ol/MapBrowserEvent.js";
import Projection from "ol/proj/Projection.js";
import View from "ol/View.js";
import type { Point } from "../protocol.ts";
import type { MapChange, MapStore, Stall } from "../state/map-store.ts";
import type { Layers } from "../state/preferences.ts";
import type { LocalPlane } from "../fence/plane.ts";
import { Background } from "./background.ts";
import { drawScene } from "./draw-scene.ts";
import type { FenceEditor, FenceEditorEvents, Ring } from "./fence-editor.ts";
import { EMPTY_SCENE, type Scene } from "./flight-scene.ts";
import { corners, covers, type Extent, extentOf, onScreen, roomBeside, type Sight, toCoordinate, toPixel, turn } from "./geometry.ts";
import { Glide } from "./glide.ts";
import { GroundLayer } from "./ground-layer.ts";
import { type Arrived, type Ground, GroundTiles } from "./ground-tiles.ts";
import { readPalette } from "./palette.ts";
import { PlanEditor, type PlanEditorEvents } from "./plan-editor.ts";
import type { RowMark } from "./draw-labels.ts";
import { cropExtent, upright } from "./stall-crop.ts";
import { StallsLayer } from "./stalls-layer.ts";
import { resize } from "./wide-canvas.ts";

/** What is up on the screen: north, or the drone's nose. */
export type Up = "north" | "drone";
export type Looking = "follow" | "whole" | "free";

export interface LotMapEvents {
  /** A place was clicked, with the stall that is there. */
  clicked(place: Point, stall: number | null): void;
  /** The view or something on it moved: what lies over it in the page must move too. */
  moved(): void;
  looking(looking: Looking): void;
  /** The stalls are drawn, and the first or all pictures of the ground. */
  drawn?(pictures: Arrived): void;
}

const HALF_WORLD_M = 5000;
/** Ground redraws are gathered for so long. */
const REDRAW_MS = 400;
const FOLLOW_RESOLUTION = 0.14;
/** Metres a pixel at which single stalls are seen. */
const NEAR_RESOLUTION = 0.1;
const EASE_MS = 150;
/** A whole lot that takes up less of the view than this is brought nearer. */
const LEAST_FILLED = 0.7;
/** A click so near to a stall is on it. */
const HIT_PX = 2;
/** A hand shakes by so much while it clicks. */
const MOVE_TOLERANCE_PX = 3;
const LEAST_TURN_RAD = 0.005;
/** Keys that move or zoom the map. */
const MOVING = /^([+-]|Arrow.*)$/;
/** A finger or mouse button leaves. */
const ENDED = ["pointerup", "pointercancel"] as const;

/** The map: a metre grid of its own (east, north), drawn when something changes and not otherwise. */
export class LotMap {
  looking: Looking = "whole";
  /** Room for what lies over the map's upper edge while the whole is shown, pixels. */
  above = 28;
  /** Ground of sections, which is a part of the whole as stalls are. */
  sectionGround: Extent | null = null;

  private readonly map: OlMap;
  private readonly view: View;
  private readonly tiles: GroundTiles;
  private readonly ground: GroundLayer;
  private readonly background = new Background(() => this.redrawSoon());
  private readonly stalls: StallsLayer;
  private readonly overlay = document.createElement("canvas");
  private scene: Scene = EMPTY_SCENE;
  /** What is to come into view once the map has a size: on a phone it may be hidden behind a panel. */
  private wanted: Extent | null = null;
  private readonly glide = new Glide(() => this.glided());
  private up: Up = "north";
  /** Something is pointed at on the map: it does not turn under the finger. */
  private held = false;
  private readonly pointers = new Set<number>();
  private redrawTimer = 0;
  private isHolding = false;
  private lot: Extent | null = null;
  private editor: FenceEditor | null = null;
  private planEditor: PlanEditor | null = null;
  private readonly still = matchMedia("(prefers-reduced-motion: reduce)");
  private readonly sizeWatch: ResizeObserver;

  private readonly element: HTMLElement;
  private readonly events: LotMapEvents;

  constructor(
    element: HTMLElement,
    grid: { cells: number; cellSize: number },
    events: LotMapEvents,
    hasBackground = true,
    /** Another map that shows the same place at the same scale, always. */
    beside: LotMap | null = null,
  ) {
    this.element = element;
    this.events = events;
    const extent: Extent = [-HALF_WORLD_M, -HALF_WORLD_M, HALF_WORLD_M, HALF_WORLD_M];
    const projection = new Projection({ code: "hawk:map", units: "m", extent });
    this.view = beside?.view ?? new View({
      projection,
      center: [0, 0],
      resolution: 0.3,
      minResolution: 0.02,
      maxResolution: 2,
      constrainResolution: false,
      constrainRotation: false,
    });
    this.tiles = new GroundTiles(grid, (isDone) => (isDone ? this.redraw() : this.redrawSoon()));
    this.ground = new GroundLayer(this.tiles, this.background);
    this.stalls = new StallsLayer();
    this.map = new OlMap({
      target: element,
      layers: [this.ground, this.stalls],
      view: this.view,
      controls: [],
      moveTolerance: MOVE_TOLERANCE_PX,
      interactions: defaultInteractions({ altShiftDragRotate: false, pinchRotate: false }),
    });
    this.overlay.className = "flight";
    element.querySelector(".ol-layers")?.after(this.overlay);
    this.listen();
    this.sizeWatch = new ResizeObserver(() => this.sized());
    this.sizeWatch.observe(element);
    this.recolour();
    if (hasBackground) void this.background.load();
  }

  dispose(): void {
    this.sizeWatch.disconnect();
    this.glide.stop();
    for (const ended of ENDED) window.removeEventListener(ended, this.released);
    clearTimeout(this.redrawTimer);
    this.map.setTarget(undefined);
  }

  recolour(): void {
    const palette = readPalette(this.element);
    this.ground.palette = palette;
    this.tiles.recolour(palette);
    this.ground.repaint();
    this.editor?.recolour(palette);
    this.planEditor?.recolour(palette);
    this.drawOverlay();
  }

  /** Shows or hides what lies under the flight. */
  showLayers({ stalls, picture, background }: Layers, plane: LocalPlane | null): void {
    this.stalls.setVisible(stalls && this.planEditor === null);
    this.tiles.showPictures(picture);
    if (background === this.background.visible && plane === this.background.plane) return;
    Object.assign(this.background, { visible: background, plane });
    this.redrawSoon();
  }

  /** Whether there is a picture of the ground besides the drone's. */
  get hasBackground(): boolean {
    return this.background.zooms.length > 0;
  }

  /** Chooses what is up, north or the drone's nose; while `held` the map does not turn. */
  turnWith(up: Up, held: boolean): void {
    const changed = up !== this.up;
    this.up = up;
    this.held = held;
    this.glide.turning = up === "drone";
    if (changed && up === "north") this.view.animate({ rotation: 0, duration: this.still.matches ? 0 : EASE_MS });
    else this.turn();
  }

  /** Opens the fence editor. The map keeps still under the corners: it follows nothing from then on. */
  editFence(Editor: typeof FenceEditor, events: FenceEditorEvents): FenceEditor {
    this.leave();
    this.editor?.dispose();
    this.editor = new Editor(this.map, readPalette(this.element), events);
    return this.editor;
  }

  /** Adds a layer over the stalls. */
  addLayer(layer: Layer): void {
    this.map.addLayer(layer);
  }

  leaveFence(): void {
    this.editor?.dispose();
    this.editor = null;
  }

  /** Brings an extent into view as large as it goes, clear of the tools at the edges. */
  fit([west, south, east, north]: Extent): void {
    this.leave();
    this.wanted = [west, south, east, north];
    this.showWanted(true);
  }

  /** Opens the editor of a plan; null closes it. */
  editPlan(events: PlanEditorEvents | null): PlanEditor | null {
    if (events) this.leave();
    this.planEditor?.dispose();
    this.planEditor = events ? new PlanEditor(this.map, readPalette(this.element), events) : null;
    return this.planEditor;
  }

  /** Brings a ring into view, at once or as soon as the map is shown; nothing happens when it is there already. */
  bringInView(ring: Ring): void {
    this.leave();
    this.wanted = extentOf(ring.map(([east, north]): [number, number] => [east, north]));
    this.showWanted();
  }

  /** Stays where it is, following nothing. */
  stay(): void {
    this.leave();
  }

  private showWanted(always = false): void {
    const size = this.map.getSize();
    if (!this.wanted || !size?.[0] || !size[1]) return;
    const inView = covers([0, 0, size[0], size[1]], onScreen(this.sight, this.wanted));
    const [right, left] = this.beside;
    if (always || !inView) this.view.fit(this.wanted, { padding: [76, right, 60, left], size });
    this.wanted = null;
  }

  /** Right and left room of what is brought into view: nothing of it lies under the tools. */
  private get beside(): [number, number] {
    return roomBeside(this.element.getBoundingClientRect(), this.element.parentElement?.querySelector(".tools")?.getBoundingClientRect());
  }

  /** Shows the ground of a stored survey in place of the live one; its stalls are drawn with it, not before it. */
  showGround(ground: Ground): void {
    this.hold(ground.whole !== null && ground.tiles.length > 0 && !document.hidden);
    this.tiles.show(ground);
  }

  /** What is shown stays until the ground is there, `REDRAW_MS` at most. */
  private hold(isHolding: boolean): void {
    if (isHolding === this.isHolding) return;
    this.isHolding = this.ground.held = this.stalls.held = isHolding;
  }

  /** Labels on the stalls, and letters at the begins of rows: as they are painted. */
  showLabels(rows: readonly RowMark[]): void {
    this.stalls.label(rows);
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
    this.stalls.remove(change.removed);
    this.stalls.put(change.stalls.flatMap((id) => store.stalls.get(id) ?? []));
    if (change.stalls.length > 0) this.lot = extentOf([...store.stalls.values()].flatMap(corners));
  }

  /** Takes what lies over the ground; the drone's mark glides to its new place. */
  setScene(scene: Scene): void {
    const before = this.scene;
    this.scene = scene;
    this.glide.to(scene.drone, this.resolution, this.still.matches || document.hidden);
    this.turn();
    this.keepInView();
    const same = before.planned === scene.planned && before.selected === scene.selected && before.lost === scene.lost;
    if (!this.glide.isGliding || !same) this.drawOverlay();
  }

  /** Draws what the drone saw of a stall, upright. Returns whether it has a picture of it. */
  drawStall(stall: Stall, canvas: HTMLCanvasElement): boolean {
    const context = canvas.getContext("2d");
    if (!context) return false;
    const { width, height } = canvas;
    context.resetTransform();
    context.clearRect(0, 0, width, height);
    context.setTransform(...upright(stall, width, height));
    return this.tiles.drawPictures(context, cropExtent(stall));
  }

  classAt(place: Point): number {
    return this.tiles.classAt(place.North, place.East);
  }

  /** Zooms about the middle. Who looked at the whole looks at a part of it from then on, or has it smaller. */
  zoom(factor: number): void {
    if (this.looking === "whole") this.leave();
    const resolution = this.view.getResolution() ?? 0.3;
    this.view.animate({ resolution: resolution / factor, duration: this.still.matches ? 0 : EASE_MS });
  }

  look(looking: Looking): void {
    this.looking = looking;
    if (looking === "whole") this.fitWhole();
    if (looking === "follow") this.centreOnDrone(true);
    this.events.looking(looking);
  }

  /** Brings a place to the middle, near enough to see a stall there; the map stays there. */
  lookAt(place: Point): void {
    this.leave();
    const resolution = Math.min(this.resolution, NEAR_RESOLUTION);
    this.view.animate({ center: toCoordinate(place), resolution, duration: this.still.matches ? 0 : EASE_MS });
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

  /** Radians clockwise by which north is turned on the screen. */
  get rotation(): number {
    return this.view.getRotation();
  }

  private get sight(): Sight {
    const [width, height] = this.map.getSize() ?? [];
    const [east, north] = this.view.getCenter() ?? [];
    const center: [number, number] = [east ?? 0, north ?? 0];
    return { width: width ?? 0, height: height ?? 0, center, resolution: this.resolution, rotation: this.rotation };
  }

  private listen(): void {
    this.map.on("postrender", () => {
      this.drawOverlay();
      this.events.moved();
    });
    this.map.on("pointerdrag", () => this.leave());
    this.element.addEventListener("wheel", () => this.leave(), { passive: true });
    this.element.addEventListener("keydown", ({ key }) => MOVING.test(key) && this.leave());
    this.element.addEventListener("pointerdown", ({ pointerId }) => this.pointers.add(pointerId));
    for (const ended of ENDED) window.addEventListener(ended, this.released);
    this.map.on("click", (event: MapBrowserEvent) => {
      const [east, north] = event.coordinate;
      if (east === undefined || north === undefined || this.editor || this.planEditor) return;
      const shown = this.stalls.getVisible();
      this.events.clicked({ North: north, East: east }, shown ? this.stalls.stallAt(north, east, HIT_PX * this.resolution) : null);
    });
  }

  private readonly released = ({ pointerId }: PointerEvent): void => void this.pointers.delete(pointerId);

  /** Turns the map after the drone's nose, unless someone's finger is on it. */
  private turn(): void {
    const drone = this.glide.shown;
    if (this.up === "north" || this.held || this.pointers.size > 0 || !drone) return;
    const wanted = turn(0, -drone.yaw, 1);
    if (Math.abs(turn(0, wanted - this.rotation, 1)) > LEAST_TURN_RAD) this.view.setRotation(wanted);
  }

  private glided(): void {
    this.turn();
    this.drawOverlay();
    this.events.moved();
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
    this.redrawTimer = window.setTimeout(() => this.redraw(), REDRAW_MS);
  }

  private redraw(): void {
    clearTimeout(this.redrawTimer);
    this.redrawTimer = 0;
    this.hold(false);
    if (document.hidden) return;
    this.ground.repaint();
    this.reportDrawn();
  }

  private reportDrawn(): void {
    const { address, arrived } = this.tiles;
    if (arrived === "none" || !this.events.drawn) return;
    const report = (): void => {
      if (address === this.tiles.address) this.events.drawn?.(arrived);
    };
    if (this.map.getSize()?.every((side) => side > 0)) {
      this.map.renderSync();
      report();
      return;
    }
    this.map.once("rendercomplete", report); // it is not shown yet
    this.map.render();
  }

  private drawOverlay(): void {
    const context = this.overlay.getContext("2d");
    const [width, height] = this.map.getSize() ?? [0, 0];
    const palette = this.ground.palette;
    if (!context || !palette || width === undefined || height === undefined || document.hidden || this.isHolding) return;
    const ratio = window.devicePixelRatio;
    resize(this.overlay, width, height, ratio);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    const { sight } = this;
    const pixel = (place: readonly [number, number]): [number, number] => toPixel(sight, place);
    const { resolution, rotation } = sight;
    drawScene({ context, palette, resolution, rotation, pixel }, { ...this.scene, drone: this.glide.shown });
  }

  private keepInView(): void {
    if (this.looking === "follow") this.centreOnDrone(false);
    if (this.looking !== "whole") return;
    const wanted = this.whole();
    const size = this.map.getSize();
    if (wanted && size && !fills(this.sight, wanted)) this.fitWhole();
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
    const [right, left] = this.beside;
    const padding = size[1] < 300 ? [12, 60, 12, 60] : [this.above, right, 52, left];
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
    const grounds = [this.lot, this.sectionGround].filter((each) => each !== null);
    if (grounds.length === 0) return extentOf(fence.length > 2 ? fence.map(toCoordinate) : around(places));
    return extentOf([...places, ...grounds.flatMap(([west, south, east, north]): [number, number][] => [[west, south], [east, north]])]);
  }
}

/** Whether all of an extent is shown, and not much else. */
function fills(sight: Sight, wanted: Extent): boolean {
  const { width, height } = sight;
  const shown = onScreen(sight, wanted);
  const share = Math.max((shown[2] - shown[0]) / width, (shown[3] - shown[1]) / height);
  return covers([0, 0, width, height], shown) && share > LEAST_FILLED;
}

/** Room around places when there is nothing else to show. */
function around(places: [number, number][]): [number, number][] {
  return places.flatMap(([east, north]): [number, number][] => [
    [east - 40, north - 40],
    [east + 40, north + 40],
  ]);
}

export type { Stall };
