import type { Coordinate } from "ol/coordinate.js";
import { click } from "ol/events/condition.js";
import type { EventsKey } from "ol/events.js";
import Feature, { type FeatureLike } from "ol/Feature.js";
import LineString from "ol/geom/LineString.js";
import MultiPoint from "ol/geom/MultiPoint.js";
import Point from "ol/geom/Point.js";
import Polygon from "ol/geom/Polygon.js";
import Draw from "ol/interaction/Draw.js";
import Modify from "ol/interaction/Modify.js";
import Snap from "ol/interaction/Snap.js";
import VectorLayer from "ol/layer/Vector.js";
import type OlMap from "ol/Map.js";
import { unByKey } from "ol/Observable.js";
import type { Pixel } from "ol/pixel.js";
import VectorSource from "ol/source/Vector.js";
import CircleStyle from "ol/style/Circle.js";
import Fill from "ol/style/Fill.js";
import Stroke from "ol/style/Stroke.js";
import Style from "ol/style/Style.js";
import Text from "ol/style/Text.js";
import { FONT_FAMILY } from "../font.ts";
import * as format from "../words/format.ts";
import type { Units } from "../words/units.ts";
import type { Palette } from "./palette.ts";

/** Corners in order, not closed: east, north in metres. */
export type Ring = readonly (readonly [number, number])[];

export interface FenceEditorEvents {
  /** A ring was closed, or a corner moved, added or removed, or a zone removed. */
  drawn(ring: Ring, zones: readonly Ring[]): void;
  /** Number of corners of a ring that is not closed yet. */
  drawing(corners: number): void;
}

/** As many as ArduCopter keeps, of a fence alone and of one with its zones. */
const MOST_CORNERS = 69;
const MOST_ZONED_CORNERS = 66;
/** The property of a feature that is an exclusion zone. */
const ZONE = "zone";
/** Between two lines of a zone's hatching, pixels. */
const HATCH_PX = 12;
/** So near a finger must come to a corner, pixels. */
const TOLERANCE_PX = 16;
/** Sides shorter than this on the screen carry no length, pixels. */
const LABELLED_PX = 56;

/** Draws and changes a polygon and exclusion zones in it on the map, by mouse, finger or, corner by corner, from outside. */
export class FenceEditor {
  removing = false;
  private units: Units = "metres";

  private readonly map: OlMap;
  private readonly events: FenceEditorEvents;
  /** Without a spatial index it keeps the order in which zones were drawn: the drone names them by their number. */
  private readonly source = new VectorSource<Feature<Polygon>>({ useSpatialIndex: false });
  private readonly layer: VectorLayer;
  private readonly draw: Draw;
  private readonly modify: Modify;
  private readonly snap: Snap;
  private readonly clicks: EventsKey;
  private palette: Palette;
  private begun = 0;
  private zoning = false;

  constructor(map: OlMap, palette: Palette, events: FenceEditorEvents) {
    this.map = map;
    this.events = events;
    this.palette = palette;
    const style = (feature: FeatureLike, resolution: number): Style[] =>
      this.style(feature.getGeometry(), resolution, feature.get(ZONE) === true);
    const sketched = (feature: FeatureLike, resolution: number): Style[] => this.style(feature.getGeometry(), resolution, this.zoning);
    this.layer = new VectorLayer({ source: this.source, style, updateWhileAnimating: true, updateWhileInteracting: true });
    this.draw = new Draw({
      source: this.source,
      type: "Polygon",
      style: sketched,
      maxPoints: MOST_CORNERS,
      snapTolerance: TOLERANCE_PX,
      stopClick: true,
    });
    this.modify = new Modify({
      source: this.source,
      pixelTolerance: TOLERANCE_PX,
      style: () => this.handle(),
      deleteCondition: (event) => this.removing && click(event),
      insertVertexCondition: () => !this.removing && this.hasRoom(),
    });
    this.snap = new Snap({ source: this.source, pixelTolerance: TOLERANCE_PX });
    map.addLayer(this.layer);
    for (const interaction of [this.modify, this.draw, this.snap]) map.addInteraction(interaction);
    this.clicks = map.on("click", (event) => this.removeZone(event.pixel));
    this.listen();
    this.switch();
  }

  /** Shows a ring and its zones, in place of what is drawn; fewer than three corners: nothing, and drawing begins again. */
  show(ring: Ring, zones: readonly Ring[] = []): void {
    this.draw.abortDrawing();
    this.source.clear();
    if (ring.length >= 3) {
      this.source.addFeature(new Feature(new Polygon([closed(ring)])));
      this.source.addFeatures(zones.map((zone) => new Feature({ geometry: new Polygon([closed(zone)]), [ZONE]: true })));
    }
    this.switch();
  }

  /** Whether the ring that is drawn next is a zone; what was begun is given up when that changes. */
  zone(zoning: boolean): void {
    if (zoning === this.zoning) return;
    this.draw.abortDrawing();
    this.zoning = zoning;
    this.switch();
  }

  /** Adds a corner where the middle of the map is, for those who draw without pointing. */
  add(place: readonly [number, number]): void {
    if (this.draw.getActive()) this.draw.appendCoordinates([[...place]]);
    this.count();
  }

  /** Takes back the last corner of a ring that is not closed. */
  takeBack(): void {
    this.draw.removeLastPoint();
    this.count();
  }

  /** Closes the ring that is being drawn. */
  finish(): void {
    if (this.begun >= 3) this.draw.finishDrawing();
  }

  /** Units of the lengths at the sides. */
  measureIn(units: Units): void {
    if (units === this.units) return;
    this.units = units;
    this.recolour(this.palette);
  }

  recolour(palette: Palette): void {
    this.palette = palette;
    this.layer.changed();
    this.draw.getOverlay().changed();
    this.modify.getOverlay().changed();
  }

  dispose(): void {
    unByKey(this.clicks);
    for (const interaction of [this.snap, this.draw, this.modify]) this.map.removeInteraction(interaction);
    this.map.removeLayer(this.layer);
  }

  private listen(): void {
    this.draw.on("drawstart", ({ feature }) => {
      feature.getGeometry()?.on("change", () => this.count());
      queueMicrotask(() => this.count()); // the sketch is on the map after this event
    });
    this.draw.on("drawabort", () => this.count());
    this.draw.on("drawend", ({ feature }) => {
      const geometry = feature.getGeometry();
      this.begun = 0;
      if (this.zoning) feature.set(ZONE, true);
      // The source takes the feature after this event: a report now would be shown twice.
      if (geometry instanceof Polygon) queueMicrotask(() => this.reportDrawn());
    });
    this.modify.on("modifyend", () => this.reportDrawn());
  }

  private reportDrawn(): void {
    this.switch();
    const ring = this.ring();
    if (ring) this.events.drawn(ring, this.zones());
  }

  private ring(): Ring | null {
    const geometry = this.source.getFeatures().find((each) => each.get(ZONE) !== true)?.getGeometry();
    return geometry ? open(geometry) : null;
  }

  private zoneFeatures(): Feature<Polygon>[] {
    return this.source.getFeatures().filter((each) => each.get(ZONE) === true);
  }

  private zones(): Ring[] {
    return this.zoneFeatures().flatMap((each) => {
      const geometry = each.getGeometry();
      return geometry ? [open(geometry)] : [];
    });
  }

  private hasRoom(): boolean {
    const zones = this.zones();
    const corners = [this.ring() ?? [], ...zones].reduce((sum, ring) => sum + ring.length, 0);
    return corners < (zones.length > 0 ? MOST_ZONED_CORNERS : MOST_CORNERS);
  }

  /** Where corners are removed, a click into a zone, or on a corner of one that has only three, removes the zone. */
  private removeZone(pixel: Pixel): void {
    if (!this.removing) return;
    const zone = this.zoneFeatures().find((each) => {
      const geometry = each.getGeometry();
      if (!geometry) return false;
      const near = open(geometry).some((corner) => apart(this.map.getPixelFromCoordinate([...corner]), pixel) <= TOLERANCE_PX);
      return near ? open(geometry).length === 3 : geometry.intersectsCoordinate(this.map.getCoordinateFromPixel(pixel));
    });
    if (!zone) return;
    this.source.removeFeature(zone);
    this.reportDrawn();
  }

  /** Corners are either drawn or moved: never both at once. */
  private switch(): void {
    const drawing = this.zoning || this.ring() === null;
    this.draw.setActive(drawing);
    this.modify.setActive(!drawing);
    if (!drawing) this.begun = 0;
  }

  /** The ring that is drawn ends in the pointer's place, which is no corner yet. */
  private count(): void {
    const sketch = this.draw.getOverlay().getSource() as VectorSource | null;
    const lines = (sketch?.getFeatures() ?? []).map((each) => each.getGeometry()).filter((each) => each instanceof Polygon);
    const begun = lines[0] ? Math.max(1, (lines[0].getCoordinates()[0]?.length ?? 0) - 2) : 0;
    if (begun === this.begun) return;
    this.begun = begun;
    this.events.drawing(begun);
  }

  private style(geometry: unknown, resolution: number, isZone: boolean): Style[] {
    const { planCase } = this.palette;
    const plan = isZone ? this.palette.zone : this.palette.plan;
    if (geometry instanceof Point) return [this.handle()];
    const ring = geometry instanceof Polygon ? (geometry.getCoordinates()[0] ?? []) : geometry instanceof LineString ? geometry.getCoordinates() : [];
    const line = new LineString(ring);
    const inside = isZone ? hatching(plan) : `${plan}14`;
    const fill = geometry instanceof Polygon ? [new Style({ fill: new Fill({ color: inside }) })] : [];
    return [
      ...fill,
      new Style({ geometry: line, stroke: new Stroke({ color: planCase, width: 6 }) }),
      new Style({ geometry: line, stroke: new Stroke({ color: plan, width: 3 }) }),
      new Style({ geometry: new MultiPoint(ring), image: dot(7, planCase, plan) }),
      ...this.lengths(ring, resolution, plan),
    ];
  }

  private handle(): Style {
    return new Style({ image: dot(10, this.removing ? this.palette.plan : this.palette.planCase, this.palette.plan), zIndex: 1 });
  }

  /** How long each side is, in its middle: there may be no picture of the ground to draw on. */
  private lengths(ring: Coordinate[], resolution: number, colour: string): Style[] {
    return ring.slice(1).flatMap((there, index) => {
      const here = ring[index] ?? there;
      const metres = Math.hypot((there[0] ?? 0) - (here[0] ?? 0), (there[1] ?? 0) - (here[1] ?? 0));
      if (metres / resolution < LABELLED_PX) return [];
      const middle = [((here[0] ?? 0) + (there[0] ?? 0)) / 2, ((here[1] ?? 0) + (there[1] ?? 0)) / 2];
      const text = new Text({
        text: format.length(metres, this.units),
        font: `600 13px ${FONT_FAMILY}`,
        fill: new Fill({ color: colour }),
        stroke: new Stroke({ color: this.palette.planCase, width: 4 }),
      });
      return [new Style({ geometry: new Point(middle), text })];
    });
  }
}

/** Slanted lines, as the flight's own map has them; the plain colour where there is no canvas. */
function hatching(colour: string): CanvasPattern | string {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = HATCH_PX;
  const context = canvas.getContext("2d");
  if (!context) return `${colour}33`;
  context.strokeStyle = colour;
  context.lineWidth = 1.5;
  context.beginPath();
  for (const sum of [0, HATCH_PX, 2 * HATCH_PX]) {
    context.moveTo(sum - HATCH_PX - 1, HATCH_PX + 1);
    context.lineTo(sum + 1, -1);
  }
  context.stroke();
  return context.createPattern(canvas, "repeat") ?? `${colour}33`;
}

function apart(one: Pixel | null, other: Pixel): number {
  return one ? Math.hypot((one[0] ?? 0) - (other[0] ?? 0), (one[1] ?? 0) - (other[1] ?? 0)) : Infinity;
}

function dot(radius: number, fill: string, line: string): CircleStyle {
  return new CircleStyle({ radius, fill: new Fill({ color: fill }), stroke: new Stroke({ color: line, width: 3 }) });
}

function open(polygon: Polygon): Ring {
  const ring = polygon.getCoordinates()[0] ?? [];
  return ring.slice(0, -1).map((place): [number, number] => [place[0] ?? 0, place[1] ?? 0]);
}

function closed(ring: Ring): Coordinate[] {
  const [first] = ring;
  return [...ring, ...(first ? [first] : [])].map((place) => [...place]);
}
