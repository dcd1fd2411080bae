import { countFor, frontLength, MOST_IN_ROW, rowShapes, STEEPEST_DEG } from "../plan/rows.ts";
import { stripOf } from "../plan/strip.ts";
import { type Kind, type Operation, type RowSketch, type SaidOfSection, type Side, type Spot } from "../plan/values.ts";
import type { Rectangle } from "../map/geometry.ts";

/** What a click on the map means. */
export type PlanTool = "choose" | "box" | "stall" | "row" | "area" | "zone" | "section";

export type RowStyle = "square" | "angled" | "parallel";
const USUAL_LEAN = 45;
const LEAST_AREA = 3;
const LEAST_LINE = 2;
/** Usual width of a strip along a kerb, metres. */
const STRIP_M = 2.5;

/** The edit of a plan that is drawn on. */
export interface DrawnOn {
  /** What was refused last; another tool forgets it. */
  problem: string;
  readonly plan: { readonly summary: { readonly usual: { readonly width: number; readonly length: number } }; readonly named: readonly { readonly name: string }[]; readonly sections: readonly { readonly name: string }[] };
  readonly selection: { clear(): void };
  do(operation: Operation): void;
  drawAgain(): void;
}

/** What is being drawn on a plan: a row by three places, a section by the line of its kerb, or the corners of an area. Lengths in metres. */
export class PlanDrawing {
  tool: PlanTool = "choose";
  style: RowStyle = "square";
  /** As typed; the count follows the lot's pitch while it is empty. */
  count = "";
  /** Degrees, as typed; for angled rows. */
  lean = String(USUAL_LEAN);
  double = false;
  kind: Kind = "";
  /** A section is a strip on a side of the line that is drawn; else the line is its outline. */
  isStrip = true;
  side: Side = "right";
  width = STRIP_M;
  /** Places of a row or a line, or corners of a ring. */
  places: readonly Spot[] = [];
  /** Where the pointer is. */
  pointer: Spot | null = null;
  private readonly editing: DrawnOn;

  constructor(editing: DrawnOn) {
    this.editing = editing;
  }

  reset(): void {
    this.tool = "choose";
    this.places = [];
    this.pointer = null;
  }

  use(tool: PlanTool): void {
    this.reset();
    this.editing.problem = "";
    this.tool = tool;
    if (tool !== "choose" && tool !== "box") this.editing.selection.clear();
    this.editing.drawAgain();
  }

  /** Changes how the row is drawn. */
  set(changes: Partial<Pick<PlanDrawing, "style" | "count" | "lean" | "double" | "kind" | "isStrip" | "side" | "width">>): void {
    Object.assign(this, changes);
    this.editing.drawAgain();
  }

  /** A place of the row or the ring; a fourth one of a row begins another row. */
  add(place: Spot): void {
    this.places = this.tool === "row" && this.places.length >= 3 ? [place] : [...this.places, place];
    this.editing.drawAgain();
  }

  /** Takes back the last place, or the tool. Returns whether there was anything. */
  back(): boolean {
    if (this.places.length > 0) this.places = this.places.slice(0, -1);
    else if (this.tool !== "choose") this.reset();
    else return false;
    this.editing.drawAgain();
    return true;
  }

  /** Radians. */
  get leanAngle(): number {
    const degrees = Number(this.lean.replace(",", "."));
    const isRight = this.style === "angled" && Number.isFinite(degrees);
    return isRight ? (Math.max(-STEEPEST_DEG, Math.min(STEEPEST_DEG, degrees)) * Math.PI) / 180 : 0;
  }

  /** Number that was typed, null for none. */
  get typedCount(): number | null {
    const count = Number(this.count);
    return this.count.trim() !== "" && Number.isInteger(count) && count >= 1 && count <= MOST_IN_ROW ? count : null;
  }

  /** The row as it is drawn, its last places where the pointer is; null while it has no front. */
  get row(): RowSketch | null {
    const [start, end = this.pointer, far = this.pointer] = this.places;
    if (this.tool !== "row" || !start || !end) return null;
    const front = [start, end] as const;
    const { usual } = this.editing.plan.summary;
    const depth = this.style === "parallel" ? usual.width : usual.length;
    const count = this.typedCount ?? countFor(frontLength(front), usual, this.leanAngle, this.style === "parallel");
    const hasEnd = this.places.length >= 2;
    return { front, far: hasEnd && far ? far : beside(front, depth), count, lean: this.leanAngle, double: this.double };
  }

  get rowStalls(): Rectangle[] {
    return this.row ? rowShapes(this.row) : [];
  }

  /** Whether a ring is drawn: an area without stalls, or a zone. */
  get isRing(): boolean {
    return this.tool === "area" || this.tool === "zone";
  }

  /** Whether places are taken as they are: nothing is snapped to. */
  get isFree(): boolean {
    return this.isRing || this.tool === "section";
  }

  /** Places with that of the pointer as the next one. */
  get course(): readonly Spot[] {
    return this.isFree && this.pointer && this.places.length > 0 ? [...this.places, this.pointer] : this.places;
  }

  /** The strip of a section as it is drawn; empty while there is none. */
  get strip(): readonly Spot[] {
    return this.tool === "section" && this.isStrip ? stripOf(this.course, this.width, this.side) : [];
  }

  /** Whether what is drawn can be added. */
  get isWhole(): boolean {
    if (this.isFree) return this.places.length >= (this.tool === "section" && this.isStrip ? LEAST_LINE : LEAST_AREA);
    return this.tool === "row" && this.places.length === 3 && this.rowStalls.length > 0;
  }

  /** Adds the row, or the ring with a name, to the plan; pictures leave private ground out. A zone whose name another one has keeps its corners: it is refused. */
  finish(name = "", isPrivate = false): void {
    const { row } = this;
    const isTaken = this.tool === "zone" && this.editing.plan.named.some((zone) => zone.name === name);
    if (!this.isWhole) return;
    if (this.tool === "zone") this.editing.do({ do: "draw_zone", outline: this.places, name, kind: this.kind });
    else if (this.tool === "area") this.editing.do({ do: "forbid", outline: this.places, name, ...(isPrivate ? { private: true } : {}) });
    else if (row) {
      const { front, far, count, lean } = row;
      const how = { ...(lean === 0 ? {} : { lean }), ...(this.style === "parallel" ? { parallel: true } : {}), ...(this.double ? { double: true } : {}) };
      this.editing.do({ do: "add_row", front, far, count, ...how, kind: this.kind });
    }
    if (!isTaken) this.beginAgain();
  }

  /** Adds a section to the plan. One whose name another one has keeps its places: it is refused. */
  finishSection(said: SaidOfSection): void {
    const { places, side, width } = this;
    if (!this.isWhole) return;
    this.editing.do({ do: "draw_section", ...said, ...(this.isStrip ? { line: places, side, width } : { outline: places }) });
    if (!this.editing.plan.sections.some(({ name }) => name === said.name)) this.beginAgain();
  }

  private beginAgain(): void {
    this.places = [];
    this.pointer = null;
    this.count = "";
    this.editing.drawAgain();
  }
}

/** A place so far to the right of the middle of a front. */
function beside([start, end]: RowSketch["front"], depth: number): Spot {
  const length = Math.max(0.01, Math.hypot(end[0] - start[0], end[1] - start[1]));
  const [up, right] = [(end[0] - start[0]) / length, (end[1] - start[1]) / length];
  return [(start[0] + end[0]) / 2 - right * depth, (start[1] + end[1]) / 2 + up * depth];
}
