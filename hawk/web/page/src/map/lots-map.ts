import { containsCoordinate } from "ol/extent.js";
import { defaults as defaultInteractions } from "ol/interaction/defaults.js";
import Layer from "ol/layer/Layer.js";
import OlMap, { type FrameState } from "ol/Map.js";
import Projection from "ol/proj/Projection.js";
import View from "ol/View.js";
import { FONT_FAMILY } from "../font.ts";
import { type Coordinate, type Extent, extentOf, type Sight, toPixel } from "./geometry.ts";
import { APART_PX, groupsOf, type LotGroup, type LotMark } from "./lot-groups.ts";
import { WideCanvas } from "./wide-canvas.ts";

/** Half of the Earth: lots of one store may lie anywhere. */
const HALF_WORLD_M = 2e7;
const NEAREST_M = 0.2;
const FURTHEST_M = 40_000;
/** One lot alone is shown so near, metres a pixel. */
const ALONE_M = 1;
const RADIUS_PX = 9;
const HIT_PX = 16;
/** Room above, right (for names), below and left of all lots. */
const PADDING_PX = [50, 150, 50, 70];
const EASE_MS = 150;
const CASE = "rgba(16,22,28,.85)";
const UNKNOWN = "#9aa5b0";
const FREE = "#70b6ff";
const TAKEN = "#ff6a14";
const FONT = `600 13px ${FONT_FAMILY}`;
const SMALL_FONT = `600 10px ${FONT_FAMILY}`;
/** Lots of a pin from which on their thousands are written. */
const MOST_WRITTEN = 1000;
const LINE_PX = 18;

/** Lots as marks that fill with what is taken, named where there is room; those whose marks would touch are one pin with their number. It is drawn when something changes and not otherwise. */
export class LotsMap {
  private readonly map: OlMap;
  private readonly view: View;
  private readonly layer = new MarksLayer();

  /** `chosen` gets the lot that was clicked; `moved` is called when the view has come to rest. */
  constructor(element: HTMLElement, chosen: (lot: string) => void, moved: () => void) {
    const extent: Extent = [-HALF_WORLD_M, -HALF_WORLD_M, HALF_WORLD_M, HALF_WORLD_M];
    this.view = new View({ projection: new Projection({ code: "hawk:lots", units: "m", extent }), center: [0, 0], resolution: ALONE_M, minResolution: NEAREST_M, maxResolution: FURTHEST_M, constrainRotation: false });
    const interactions = defaultInteractions({ altShiftDragRotate: false, pinchRotate: false });
    this.map = new OlMap({ target: element, layers: [this.layer], view: this.view, controls: [], interactions });
    this.map.on("singleclick", ({ coordinate: [east = 0, north = 0] }) => {
      const group = this.layer.at([east, north], this.resolution);
      if (!group) return;
      // Lots on one place stay one pin however near the map is: the table names the others.
      if (groupsOf(group, NEAREST_M).length === 1) chosen(group[0].id);
      else this.open(group);
    });
    this.map.on("moveend", moved);
    this.layer.words = wordsOn(element);
  }

  /** Metres a pixel. */
  get resolution(): number {
    return this.view.getResolution() ?? ALONE_M;
  }

  /** Takes the colours of the theme. */
  recolour(element: HTMLElement): void {
    this.layer.words = wordsOn(element);
    this.layer.show(this.layer.marks);
  }

  /** Shows these lots. The view stays where it is when the same lots are shown again. */
  show(marks: readonly LotMark[]): void {
    const before = new Set(this.layer.marks.map(({ id }) => id));
    this.layer.show(marks);
    if (marks.some(({ id }) => !before.has(id))) this.showAll();
  }

  /** The lots whose places the map shows now. */
  inSight(): Set<string> {
    const extent = this.view.calculateExtent(this.map.getSize());
    return new Set(this.layer.marks.filter(({ place }) => containsCoordinate(extent, place)).map(({ id }) => id));
  }

  showAll(): void {
    this.fit(this.layer.marks, { minResolution: ALONE_M });
  }

  /** Zooms in until the lots of a pin have pins of their own. */
  private open(group: LotGroup): void {
    this.fit(group, { minResolution: NEAREST_M, duration: EASE_MS });
  }

  private fit(marks: readonly LotMark[], options: { minResolution: number; duration?: number }): void {
    const extent = extentOf(marks.map(({ place }) => place));
    const size = this.map.getSize();
    if (extent && size) this.view.fit(extent, { size, padding: PADDING_PX, ...options });
  }

  zoom(factor: number): void {
    this.view.animate({ resolution: this.resolution / factor, duration: EASE_MS });
  }

  dispose(): void {
    this.map.setTarget(undefined);
  }
}

/** Colours of names, and of the seam about them. */
interface WordColours {
  text: string;
  seam: string;
}

/** As the rest of the page writes. */
function wordsOn(element: HTMLElement): WordColours {
  const style = getComputedStyle(element);
  return { text: style.getPropertyValue("--text").trim() || "#000", seam: style.getPropertyValue("--surface").trim() || "#fff" };
}

class MarksLayer extends Layer {
  marks: readonly LotMark[] = [];
  words: WordColours = { text: "#000", seam: "#fff" };
  private readonly wide = new WideCanvas("lots", (context, sight) => paint(context, sight, this.groups(sight.resolution), this.words));
  private grouped: { resolution: number; groups: readonly LotGroup[] } | null = null;

  constructor() {
    super({});
  }

  show(marks: readonly LotMark[]): void {
    this.marks = marks;
    this.grouped = null;
    this.wide.touch();
    this.changed();
  }

  /** The pins at a resolution, metres a pixel. */
  private groups(resolution: number): readonly LotGroup[] {
    if (this.grouped?.resolution !== resolution) this.grouped = { resolution, groups: groupsOf(this.marks, resolution) };
    return this.grouped.groups;
  }

  /** The nearest pin under a finger at a place; null for none. */
  at([east, north]: Coordinate, resolution: number): LotGroup | null {
    let found: LotGroup | null = null;
    let nearest = HIT_PX * resolution;
    for (const group of this.groups(resolution)) {
      const [{ place }] = group;
      const distance = Math.hypot(place[0] - east, place[1] - north);
      if (distance < nearest) [found, nearest] = [group, distance];
    }
    return found;
  }

  override render(frame: FrameState | null): HTMLElement {
    if (frame) this.wide.show(frame);
    return this.wide.holder;
  }
}

function paint(context: CanvasRenderingContext2D, sight: Sight, groups: readonly LotGroup[], { text: ink, seam }: WordColours): void {
  const shown = groups.map((group) => ({ group, pixel: toPixel(sight, group[0].place) })).filter(({ pixel: [x, y] }) => x > -HIT_PX && y > -HIT_PX && x < sight.width + HIT_PX && y < sight.height + HIT_PX);
  for (const { group, pixel } of shown) {
    if (group.length === 1) drawMark(context, group[0], pixel);
    else drawNumber(context, group.length, pixel, { text: ink, seam });
  }
  context.font = FONT;
  context.textBaseline = "middle";
  context.lineJoin = "round";
  context.lineWidth = 4;
  const used = new Set<string>();
  for (const { group: [mark, ...others], pixel: [x, y] } of shown) {
    if (others.length > 0) continue;
    const text = `${mark.name} · ${mark.words()}`;
    const cells = cellsOf(x, y, context.measureText(text).width);
    if (cells.some((cell) => used.has(cell))) continue; // the table names it
    for (const cell of cells) used.add(cell);
    context.strokeStyle = seam;
    context.fillStyle = ink;
    context.strokeText(text, x + HIT_PX, y);
    context.fillText(text, x + HIT_PX, y);
  }
}

/** A full circle of what is free, in which what is taken stands from the bottom up. */
function drawMark(context: CanvasRenderingContext2D, { taken }: LotMark, [x, y]: Coordinate): void {
  context.beginPath();
  context.arc(x, y, RADIUS_PX, 0, 2 * Math.PI);
  context.fillStyle = taken === null ? UNKNOWN : FREE;
  context.fill();
  if (taken !== null && taken > 0) {
    const half = Math.acos(1 - 2 * Math.min(1, taken));
    context.beginPath();
    context.arc(x, y, RADIUS_PX, Math.PI / 2 - half, Math.PI / 2 + half);
    context.closePath();
    context.fillStyle = TAKEN;
    context.fill();
  }
  context.beginPath();
  context.arc(x, y, RADIUS_PX, 0, 2 * Math.PI);
  context.strokeStyle = CASE;
  context.lineWidth = 2;
  context.stroke();
}

/** A circle with the number of lots that it stands for. */
function drawNumber(context: CanvasRenderingContext2D, lots: number, [x, y]: Coordinate, { text, seam }: WordColours): void {
  context.beginPath();
  context.arc(x, y, APART_PX / 2, 0, 2 * Math.PI);
  context.fillStyle = seam;
  context.fill();
  context.strokeStyle = text;
  context.lineWidth = 2;
  context.stroke();
  context.font = lots < 100 ? FONT : SMALL_FONT;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillStyle = text;
  context.fillText(lots < MOST_WRITTEN ? `${lots}` : `${Math.floor(lots / MOST_WRITTEN)}k`, x, y);
  context.textAlign = "start";
}

/** Squares of the map that a name takes. */
function cellsOf(x: number, y: number, width: number): string[] {
  const row = Math.floor(y / LINE_PX);
  const [first, last] = [Math.floor((x - RADIUS_PX) / LINE_PX), Math.floor((x + HIT_PX + width) / LINE_PX)];
  return Array.from({ length: last - first + 1 }, (_, k) => [`${first + k} ${row}`, `${first + k} ${row + 1}`]).flat();
}
