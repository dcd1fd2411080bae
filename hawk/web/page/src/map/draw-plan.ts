import { FONT_FAMILY } from "../font.ts";
import { type Kind, MARKS } from "../plan/values.ts";
import { type Coordinate, corners, type Rectangle, type Sight, toPixel } from "./geometry.ts";
import type { Palette } from "./palette.ts";
import type { StallFrame } from "./square-pictures.ts";
import { inset } from "./stall-style.ts";
import { path } from "./surface.ts";

/** A stall of the plan on the map. */
export interface PlanShape extends Rectangle {
  id: string;
  label: string;
  kind: Kind;
  confirmed: boolean;
  /** A person gave or confirmed the label. */
  named: boolean;
  chosen: boolean;
}

/** What is drawn over the plan: stalls that are to be, a line or a ring of places, a box, stalls that vision saw. */
export interface Sketch {
  shapes: readonly Rectangle[];
  places: readonly Coordinate[];
  /** The places are corners of an area without stalls, or of a zone. */
  area: "" | "area" | "zone";
  box: readonly Coordinate[];
  /** Sections that are to be: the strip along the line of places, or those of a file. */
  sections?: readonly Area[];
  /** The shapes are those of a file that nobody has taken yet. */
  isPreview?: boolean;
}

export const NO_SKETCH: Sketch = { shapes: [], places: [], area: "", box: [] };

/** Metres a pixel up to which there is room for labels, marks, and for the casing of lines. */
const LABELLED = 0.06;
const MARKED = 0.16;
const CASED = 0.3;
const FOUND_DASH = [5, 3];
const SEEN_DASH = [1.5, 3];

/** Draws the plan's stalls, all of a look at once: found ones dashed, confirmed ones solid, chosen ones filled. */
export function drawPlan(context: CanvasRenderingContext2D, shapes: Iterable<PlanShape>, frame: StallFrame, palette: Palette): void {
  const found: PlanShape[] = [];
  const confirmed: PlanShape[] = [];
  const chosen: PlanShape[] = [];
  for (const each of shapes) (each.chosen ? chosen : each.confirmed ? confirmed : found).push(each);
  const { resolution } = frame;
  const place = ([east, north]: Coordinate): Coordinate => [(east - frame.west) / resolution, (frame.north - north) / resolution];
  drawLook(context, found, { place, resolution }, { colour: palette.plan, casing: palette.planCase, dash: FOUND_DASH, width: 1.5 });
  drawLook(context, confirmed, { place, resolution }, { colour: palette.confirmed, casing: palette.planCase, dash: [], width: 2, fill: `${palette.confirmed}38` });
  drawLook(context, chosen, { place, resolution }, { colour: palette.plan, casing: palette.planCase, dash: [], width: 3, fill: `${palette.plan}66` });
}

/** Draws marks of kinds, and labels where there is room for them; they stand upright, however the map is turned. */
export function drawPlanWords(context: CanvasRenderingContext2D, shapes: Iterable<PlanShape>, sight: Sight, palette: Palette): void {
  if (sight.resolution <= MARKED) for (const stall of shapes) drawWords(context, stall, sight, palette);
}

/** Draws what vision saw and the plan lacks: dotted. */
export function drawSeen(context: CanvasRenderingContext2D, found: readonly Rectangle[], sight: Sight, palette: Palette): void {
  drawLook(context, found, on(sight), { colour: palette.planCase, casing: palette.fence, dash: SEEN_DASH, width: 1.5 });
}

/** A ring on the map: an area without stalls, or a zone with its name. */
export interface Area {
  ring: readonly Coordinate[];
  name: string | null;
  isSection?: boolean;
}

/** Draws an area without stalls, or a zone. */
export function drawArea(context: CanvasRenderingContext2D, { ring, name, isSection = false }: Area, sight: Sight, palette: Palette): void {
  if (ring.length < 2) return;
  const pixels = ring.map((place) => toPixel(sight, place));
  const colour = name === null ? palette.zone : palette.plan;
  path(context, pixels, true);
  context.fillStyle = `${colour}${name === null ? "33" : "1f"}`;
  context.fill();
  strokeCased(context, colour, palette.planCase, 2, isSection ? [] : [8, 4]);
}

/** Writes the name of a zone into its middle. */
export function drawAreaName(context: CanvasRenderingContext2D, { ring, name }: Area, sight: Sight, palette: Palette): void {
  if (name === null) return;
  const middle = (axis: 0 | 1): number => ring.reduce((sum, place) => sum + place[axis], 0) / ring.length;
  drawText(context, name, ...toPixel(sight, [middle(0), middle(1)]), palette.plan, palette.planCase);
}

export function drawSketch(context: CanvasRenderingContext2D, sketch: Sketch, sight: Sight, palette: Palette): void {
  const { shapes, places, area, box, isPreview, sections = [] } = sketch;
  drawLook(context, shapes, on(sight), { colour: palette.plan, casing: palette.planCase, dash: isPreview === true ? FOUND_DASH : [], width: 2, fill: `${palette.plan}40` });
  const pixels = places.map((place) => toPixel(sight, place));
  for (const each of sections) drawArea(context, isPreview === true ? { ...each, isSection: false } : each, sight, palette); // dashed, as stalls of a file
  for (const each of sections) drawAreaName(context, each, sight, palette);
  if (area !== "") drawArea(context, { ring: places, name: area === "zone" ? "" : null }, sight, palette);
  else if (pixels.length > 1) {
    path(context, sections.length > 0 ? pixels : pixels.slice(0, 2));
    strokeCased(context, palette.plan, palette.planCase, 3, []);
  }
  for (const [x, y] of pixels) drawDot(context, x, y, area === "area" ? palette.zone : palette.plan, palette.planCase);
  if (box.length === 0) return;
  path(context, box.map((place) => toPixel(sight, place)), true);
  context.fillStyle = `${palette.plan}1f`;
  context.fill();
  strokeCased(context, palette.plan, palette.planCase, 1.5, [6, 4]);
}

/** How places become pixels. */
interface Placing {
  place: (coordinate: Coordinate) => Coordinate;
  resolution: number;
}

function on(sight: Sight): Placing {
  return { place: (coordinate) => toPixel(sight, coordinate), resolution: sight.resolution };
}

interface Look {
  colour: string;
  casing: string;
  dash: number[];
  width: number;
  fill?: string;
}

function drawLook(context: CanvasRenderingContext2D, shapes: readonly Rectangle[], { place, resolution }: Placing, { colour, casing, dash, width, fill }: Look): void {
  if (shapes.length === 0) return;
  context.beginPath();
  for (const shape of shapes) {
    corners(inset(shape, width, resolution)).forEach((corner, index) => {
      const [x, y] = place(corner);
      if (index === 0) context.moveTo(x, y);
      else context.lineTo(x, y);
    });
    context.closePath();
  }
  if (fill !== undefined) {
    context.fillStyle = fill;
    context.fill();
  }
  if (resolution <= CASED) strokeCased(context, colour, casing, width, dash);
  else strokeOnce(context, colour, 1, []);
}

function strokeCased(context: CanvasRenderingContext2D, colour: string, casing: string, width: number, dash: number[]): void {
  strokeOnce(context, casing, width + 2, []);
  strokeOnce(context, colour, width, dash);
}

function strokeOnce(context: CanvasRenderingContext2D, colour: string, width: number, dash: number[]): void {
  context.setLineDash(dash);
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.stroke();
  context.setLineDash([]);
}

function drawDot(context: CanvasRenderingContext2D, x: number, y: number, colour: string, casing: string): void {
  context.beginPath();
  context.arc(x, y, 6, 0, 2 * Math.PI);
  context.fillStyle = casing;
  context.fill();
  strokeOnce(context, colour, 3, []);
}

/** The mark of a kind in a disc, and the label where there is room. */
function drawWords(context: CanvasRenderingContext2D, stall: PlanShape, sight: Sight, palette: Palette): void {
  const isLabelled = sight.resolution <= LABELLED;
  const mark = MARKS[stall.kind];
  if (!isLabelled && mark === "") return;
  const [x, y] = toPixel(sight, [stall.east, stall.north]);
  context.textAlign = "center";
  context.textBaseline = "middle";
  if (mark !== "") {
    const size = Math.min(11, Math.max(7, (stall.width * 0.3) / sight.resolution));
    context.beginPath();
    context.arc(x, y, size, 0, 2 * Math.PI);
    context.fillStyle = palette.plan;
    context.fill();
    strokeOnce(context, palette.planCase, 1.5, []);
    context.fillStyle = palette.planCase;
    context.font = `700 ${Math.round(size * 1.3)}px ${FONT_FAMILY}`;
    context.fillText(mark, x, y + 0.5);
  }
  if (!isLabelled) return;
  const colour = stall.named && !stall.chosen ? palette.confirmed : palette.plan;
  drawText(context, stall.label, x, mark === "" ? y : y + 20, colour, palette.planCase, stall.named ? PAINTED : GUESSED);
}

/** Looks of a label: as a person says that it is painted, and as a guess. */
const PAINTED = "600";
const GUESSED = "italic 400";

function drawText(context: CanvasRenderingContext2D, text: string, x: number, y: number, colour: string, casing: string, look = PAINTED): void {
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.font = `${look} 12px ${FONT_FAMILY}`;
  context.strokeStyle = casing;
  context.lineWidth = 3;
  context.lineJoin = "round";
  context.strokeText(text, x, y);
  context.fillStyle = colour;
  context.fillText(text, x, y);
}
