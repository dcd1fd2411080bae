import type MapBrowserEvent from "ol/MapBrowserEvent.js";
import type OlMap from "ol/Map.js";
import PointerInteraction from "ol/interaction/Pointer.js";
import type { Sketch } from "./draw-plan.ts";
import { type Coordinate, extentOf } from "./geometry.ts";
import type { Palette } from "./palette.ts";
import { PlanLayer } from "./plan-layer.ts";

/** What a click or a drag means. */
export interface Touching {
  /** Besides what is chosen. */
  add: boolean;
  double: boolean;
  finger: boolean;
  /** Nothing is snapped to. */
  free: boolean;
}

export interface PlanEditorEvents {
  clicked(place: Coordinate, id: string | null, how: Touching): void;
  pointed(place: Coordinate, free: boolean): void;
  boxed(ids: string[], add: boolean): void;
  /** Stalls that are chosen are dragged by so much from where they were. */
  dragged(from: Coordinate, to: Coordinate, how: { free: boolean; ended: boolean }): void;
  /** What a drag from a place does. */
  dragAt(id: string | null, shift: boolean): "box" | "move" | "pan";
}

/** A click so near to a stall is on it: mouse and finger, pixels. */
const HIT_PX = { mouse: 2, finger: 10 };
/** A shorter drag is a click, pixels. */
const DRAG_PX = 5;
/** Two clicks so near to each other are a double one: OpenLayers takes two quick ones anywhere for one. */
const DOUBLE = { pixels: 8, milliseconds: 350 };

/** Shows a plan on the map, and reports what mouse and finger do with it. */
export class PlanEditor {
  readonly layer: PlanLayer;
  private readonly map: OlMap;
  private readonly events: PlanEditorEvents;
  private readonly pointer: PlanPointer;
  private box: Coordinate[] = [];
  private sketched: Sketch | null = null;
  private last: { pixel: readonly number[]; at: number } | null = null;

  constructor(map: OlMap, palette: Palette, events: PlanEditorEvents) {
    this.map = map;
    this.events = events;
    this.layer = new PlanLayer(palette);
    this.pointer = new PlanPointer(this);
    map.addLayer(this.layer);
    map.addInteraction(this.pointer);
  }

  dispose(): void {
    this.map.removeInteraction(this.pointer);
    this.map.removeLayer(this.layer);
  }

  recolour(palette: Palette): void {
    this.layer.recolour(palette);
  }

  sketch(sketch: Sketch): void {
    this.sketched = sketch;
    this.layer.draw(this.box.length > 0 ? { ...sketch, box: this.box } : sketch);
  }

  /** A third click in one place is a single one again. */
  click(event: MapBrowserEvent): void {
    const { at, shift, finger, free } = readEvent(event);
    const now = { pixel: [...event.pixel], at: event.originalEvent.timeStamp };
    const double = this.last !== null && now.at - this.last.at < DOUBLE.milliseconds && apart(now.pixel, this.last.pixel) < DOUBLE.pixels;
    this.last = double ? null : now;
    this.map.getTargetElement()?.focus({ preventScroll: true });
    this.events.clicked(at, this.idAt(event), { add: shift, double, finger, free });
  }

  point(event: MapBrowserEvent): void {
    const { at, free } = readEvent(event);
    this.events.pointed(at, free);
  }

  dragAt(event: MapBrowserEvent): "box" | "move" | "pan" {
    return this.events.dragAt(this.idAt(event), readEvent(event).shift);
  }

  move(from: Coordinate, event: MapBrowserEvent, ended: boolean): void {
    const { at, free } = readEvent(event);
    this.events.dragged(from, at, { free, ended });
  }

  /** A box stands upright on the screen, however the map is turned. */
  stretch(from: readonly number[], event: MapBrowserEvent, ended: boolean): void {
    const [x, y] = [from[0] ?? 0, from[1] ?? 0];
    const [right, down] = [event.pixel[0] ?? 0, event.pixel[1] ?? 0];
    const ring = ([[x, y], [right, y], [right, down], [x, down]] as const).map((pixel) => toCoordinate(this.map.getCoordinateFromPixel([...pixel])));
    this.box = ended ? [] : ring;
    if (this.sketched) this.sketch(this.sketched);
    const extent = extentOf(ring);
    if (ended && extent) this.events.boxed(this.layer.inRing(ring, extent).map(({ id }) => id), readEvent(event).shift);
  }

  private idAt(event: MapBrowserEvent): string | null {
    const { at, finger } = readEvent(event);
    const resolution = this.map.getView().getResolution() ?? 1;
    return this.layer.at(at, HIT_PX[finger ? "finger" : "mouse"] * resolution)?.id ?? null;
  }
}

/** Mouse and finger on a plan: a drag of what is chosen moves it, one with Shift draws a box, any other moves the map. */
class PlanPointer extends PointerInteraction {
  private readonly editor: PlanEditor;
  private begun: { pixel: readonly number[]; at: Coordinate; what: "box" | "move"; far: boolean } | null = null;

  constructor(editor: PlanEditor) {
    super({ stopDown: (handled) => handled });
    this.editor = editor;
  }

  override handleEvent(event: MapBrowserEvent): boolean {
    if (event.type === "click") this.editor.click(event);
    return event.type === "dblclick" ? false : super.handleEvent(event);
  }

  override handleMoveEvent(event: MapBrowserEvent): void {
    if (!event.dragging) this.editor.point(event);
  }

  override handleDownEvent(event: MapBrowserEvent): boolean {
    const what = this.editor.dragAt(event);
    if (what === "pan") return false;
    this.begun = { pixel: [...event.pixel], at: readEvent(event).at, what, far: false };
    return true;
  }

  override handleDragEvent(event: MapBrowserEvent): void {
    const { begun } = this;
    if (!begun) return;
    begun.far ||= apart(event.pixel, begun.pixel) >= DRAG_PX;
    if (begun.far) this.report(event, false);
  }

  override handleUpEvent(event: MapBrowserEvent): boolean {
    if (this.begun?.far) this.report(event, true);
    else if (event.dragging) this.editor.click(event);
    this.begun = null;
    return false;
  }

  private report(event: MapBrowserEvent, ended: boolean): void {
    const { begun } = this;
    if (begun?.what === "move") this.editor.move(begun.at, event, ended);
    else if (begun) this.editor.stretch(begun.pixel, event, ended);
  }
}

function readEvent(event: MapBrowserEvent): { at: Coordinate; shift: boolean; finger: boolean; free: boolean } {
  const original = event.originalEvent as PointerEvent;
  return { at: toCoordinate(event.coordinate), shift: original.shiftKey, finger: original.pointerType === "touch", free: original.altKey };
}

function apart(one: readonly number[], other: readonly number[]): number {
  return Math.hypot((one[0] ?? 0) - (other[0] ?? 0), (one[1] ?? 0) - (other[1] ?? 0));
}

function toCoordinate(place: readonly number[]): Coordinate {
  return [place[0] ?? 0, place[1] ?? 0];
}
