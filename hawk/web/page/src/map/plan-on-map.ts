import type { LocalPlane } from "../fence/plane.ts";
import { inverse, type LotFrame, lotFrame, NO_SHIFT, shifted, shiftedShape } from "../plan/frame.ts";
import { snapEnd, snapFar, snapMove, snapPlace, snapStall } from "../plan/snap.ts";
import { partsOf, type PlanStall, type Spot } from "../plan/values.ts";
import type { Operator } from "../state/operator.ts";
import type { PlanEditing, Redrawn } from "../state/plan-edit.ts";
import { labelByKey } from "../state/plan-labels.ts";
import { type Area, NO_SKETCH, type PlanShape, type Sketch } from "./draw-plan.ts";
import { type Coordinate, corners, extentOf, type Rectangle, toCoordinate } from "./geometry.ts";
import type { LotMap } from "./lot-map.ts";
import type { PlanEditor, Touching } from "./plan-editor.ts";

/** Stalls so near to a place are snapped to, metres. */
const AROUND_M = 25;
/** An arrow key moves stalls by so much, and with Shift, metres. */
const STEP_M = 0.1;
const LONG_STEP_M = 1;
/** R turns by so much, radians. */
const TURN_RAD = (5 * Math.PI) / 180;
const ARROWS: Record<string, Spot> = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] };

/** Keeps the plan on the map and that of the model the same: the lot's frame there, the map's here. */
export class PlanOnMap {
  frame: LotFrame = { toMap: NO_SHIFT, by: "own" };
  private readonly lot: LotMap;
  private readonly model: Operator;
  /** Where the map lies on Earth. */
  private readonly planeOf: () => LocalPlane | null;
  /** The map is of a flight, whose survey was placed by the stalls; else it is of a stored survey, which lies where the lot's datum says. */
  private readonly isFlown: boolean;
  private editor: PlanEditor | null = null;
  private forget: (() => void) | null = null;
  private plane: LocalPlane | null = null;
  private shownLot: unknown = null;
  private chosen = new Set<string>();
  private sketched = "";

  constructor(lot: LotMap, model: Operator, planeOf: () => LocalPlane | null, isFlown: boolean) {
    this.lot = lot;
    this.model = model;
    this.planeOf = planeOf;
    this.isFlown = isFlown;
  }

  private get editing(): PlanEditing {
    return this.model.plan;
  }

  /** Opens, closes and fills the editor as the model says, on the map that is seen. */
  update(isSeen: boolean): void {
    const { lot } = this.editing;
    const open = this.editing.open && isSeen;
    if (open !== (this.editor !== null)) this.toggle(open);
    if (!this.editor || !lot) return;
    const plane = this.planeOf();
    if (lot !== this.shownLot || plane !== this.plane) {
      const isOther = lot !== this.shownLot;
      this.shownLot = lot;
      this.plane = plane;
      this.frame = lotFrame(lot.datum, this.isFlown ? lot.surveys : [], plane);
      this.redraw(null);
      if (isOther) this.bringInView();
    }
    this.choose();
    this.sketch();
  }

  /** By keyboard the middle of the map is pointed at. Returns whether the key was one of the editor's. */
  key(event: KeyboardEvent): boolean {
    const { editing } = this;
    const { drawing } = editing;
    const arrow = ARROWS[event.key];
    const isPlain = !event.ctrlKey && !event.metaKey && !event.altKey;
    if (!isPlain || !editing.open) return false;
    if (event.key === "Enter") this.enter(event.shiftKey);
    else if (event.key === "Backspace" && drawing.places.length > 0) drawing.back();
    else if (!editing.mayEdit || editing.selection.size === 0) return false;
    else if (event.key === "Delete" || event.key === "Backspace") editing.doChosen((stalls) => ({ do: "remove", stalls }));
    else if (event.key.toLowerCase() === "r") editing.doChosen((stalls) => ({ do: "turn", stalls, by: event.shiftKey ? -TURN_RAD : TURN_RAD, about: "middle" }));
    else if (labelByKey(event.key, editing)) return true;
    else if (arrow) this.nudge(arrow, event.shiftKey ? LONG_STEP_M : STEP_M);
    else return false;
    return true;
  }

  private enter(add: boolean): void {
    if (this.editing.drawing.isWhole && this.editing.drawing.tool === "row") {
      this.editing.drawing.finish();
      return;
    }
    const place = toCoordinate(this.lot.centre);
    this.clicked(place, this.editor?.layer.at(place, 0)?.id ?? null, { add, double: false, finger: false, free: false });
  }

  /** Up on the screen is up there, however the map is turned. */
  private nudge([up, right]: Spot, step: number): void {
    const turn = -this.lot.rotation - this.frame.toMap.turn;
    const [north, east] = shifted({ north: 0, east: 0, turn }, [up * step, right * step]);
    this.editing.doChosen((stalls) => ({ do: "move", stalls, north, east }));
  }

  private toggle(open: boolean): void {
    this.forget?.();
    this.forget = open ? this.editing.listen((redrawn) => this.redraw(redrawn)) : null;
    this.editor = this.lot.editPlan(
      open
        ? {
            clicked: (place, id, how) => this.clicked(place, id, how),
            pointed: (place, free) => this.pointed(place, free),
            boxed: (ids, add) => this.editing.choose(ids, add),
            dragged: (from, to, how) => this.dragged(from, to, how),
            dragAt: (id, shift) => this.dragAt(id, shift),
          }
        : null,
    );
    this.shownLot = null;
    this.chosen.clear();
    this.sketched = "";
  }

  private bringInView(): void {
    const { stalls, sections } = this.editing.plan;
    const rings = sections.flatMap(({ outline }) => outline.map((corner) => this.toMap(corner)));
    const places = [...stalls.values()].flatMap((stall) => corners(this.onMap(stall))).concat(rings);
    const extent = extentOf(places);
    if (extent) this.lot.fit(extent);
  }

  private redraw(redrawn: Redrawn): void {
    const { plan, lot } = this.editing;
    if (!this.editor || !lot) return;
    const { layer } = this.editor;
    if (redrawn === null) {
      layer.clear();
      layer.put([...plan.stalls.values()].map((stall) => this.onMap(stall)));
    } else {
      layer.remove([...redrawn].filter((id) => !plan.get(id)));
      layer.put([...redrawn].flatMap((id) => plan.get(id) ?? []).map((stall) => this.onMap(stall)));
    }
    const areas = [...plan.zones, ...plan.named].map(({ outline, name, kind }) => ({ ring: outline.map((corner) => this.toMap(corner)), name: kind === "no_stalls" || kind === "private_ground" ? null : name }));
    const sections = plan.sections.map((each) => this.sectionOnMap(each));
    layer.showAreas([...areas, ...sections], lot.found.map((each) => shiftedShape(this.frame.toMap, each)));
    this.sketched = "";
  }

  /** Draws those stalls again that are chosen now, or no more. */
  private choose(): void {
    const { selection, plan } = this.editing;
    const changed = [...selection].filter((id) => !this.chosen.has(id)).concat([...this.chosen].filter((id) => !selection.has(id)));
    if (changed.length === 0) return;
    this.chosen = new Set(selection);
    this.editor?.layer.put(changed.flatMap((id) => plan.get(id) ?? []).map((stall) => this.onMap(stall)));
  }

  private sketch(): void {
    const { drawing, incoming } = this.editing;
    const wanted = JSON.stringify([incoming.preview?.token, drawing.tool, drawing.places, drawing.pointer, drawing.style, drawing.count, drawing.lean, drawing.double, drawing.isStrip, drawing.side, drawing.width]);
    if (wanted === this.sketched) return;
    this.sketched = wanted;
    this.editor?.sketch(this.sketchOf());
  }

  private sketchOf(): Sketch {
    const { drawing, incoming } = this.editing;
    if (incoming.preview) {
      const { begin, stay, sections } = incoming.preview;
      const shown = sections.filter(({ change }) => change !== "end").map((each) => this.sectionOnMap(each));
      return { ...NO_SKETCH, shapes: [...begin, ...stay].map((each) => shiftedShape(this.frame.toMap, each)), sections: shown, isPreview: true };
    }
    const { course, strip } = drawing;
    const shapes = drawing.tool === "row" ? drawing.rowStalls : drawing.tool === "stall" && drawing.pointer ? [this.newStall(drawing.pointer, false)] : [];
    if (drawing.tool === "choose" || drawing.tool === "box") return NO_SKETCH;
    const row = drawing.row;
    const ends = drawing.tool === "row" && row && drawing.places.length > 0 ? [...row.front, ...drawing.places.slice(2)] : course;
    const area = drawing.tool === "area" ? "area" : drawing.isRing || (drawing.tool === "section" && !drawing.isStrip) ? "zone" : "";
    return { shapes: shapes.map((each) => shiftedShape(this.frame.toMap, each)), places: ends.map((each) => this.toMap(each)), area, box: [], sections: strip.length === 0 ? [] : [this.sectionOnMap({ outline: strip, name: "" })] };
  }

  private clicked(place: Coordinate, id: string | null, how: Touching): void {
    const { editing, model } = this;
    const { drawing } = editing;
    const isMove = model.picking || model.question?.about === "move";
    if (isMove) model.pointAt({ North: place[1], East: place[0] }, false);
    else if (drawing.tool === "choose" || drawing.tool === "box") this.select(id, how);
    else if (!editing.mayEdit) return;
    else if (drawing.tool === "stall") {
      if (!how.double) this.addStall(this.toLot(place), how.free);
    } else if (how.double && drawing.tool === "area") drawing.finish();
    else if (!how.double) drawing.add(this.snapped(place, how.free));
  }

  private select(id: string | null, { add, double, finger }: Touching): void {
    const { editing } = this;
    const row = id === null ? null : rowOf(editing.plan.get(id));
    if (id === null) {
      if (!add && !double) editing.choose([]);
    } else if (double && row !== null) editing.chooseRow(row, add);
    else if (double) return;
    else if (add || finger) editing.toggle(id);
    else editing.choose([id]);
  }

  private pointed(place: Coordinate, free: boolean): void {
    const { drawing } = this.editing;
    if (drawing.tool === "choose" || drawing.tool === "box" || (drawing.tool === "row" && drawing.places.length >= 3)) return;
    drawing.pointer = drawing.tool === "stall" ? this.toLot(place) : this.snapped(place, free);
    this.sketch();
  }

  private addStall(place: Spot, free: boolean): void {
    const { north, east, angle, width, length } = this.newStall(place, free);
    const { kind } = this.editing.drawing;
    this.editing.do({ do: "add_stall", north, east, angle, width, length, kind });
  }

  private newStall(place: Spot, free: boolean): Rectangle {
    const { lot, plan } = this.editing;
    return snapStall(place, this.around([place]), lot?.found ?? [], plan.summary.usual, free);
  }

  /** A place of what is drawn, where snapping puts it. */
  private snapped(coordinate: Coordinate, free: boolean): Spot {
    const { drawing, plan } = this.editing;
    const place = this.toLot(coordinate);
    if (free) return place;
    const near = this.around([place]);
    const [start, end] = drawing.places;
    if (drawing.isFree || !start) return drawing.isFree ? place : snapPlace(place, near);
    const { usual } = plan.summary;
    const isParallel = drawing.style === "parallel";
    const pitch = isParallel ? usual.length : usual.width / Math.cos(drawing.leanAngle);
    if (!end || drawing.places.length >= 3) return snapEnd(start, place, this.around([start, place]), pitch);
    const depth = (isParallel ? usual.width : usual.length * Math.cos(drawing.leanAngle) + usual.width * Math.abs(Math.sin(drawing.leanAngle))) * (drawing.double ? 2 : 1);
    return snapFar([start, end], place, near, depth);
  }

  private dragAt(id: string | null, shift: boolean): "box" | "move" | "pan" {
    const { drawing, selection, mayEdit } = this.editing;
    if (this.model.picking) return "pan";
    if (drawing.tool === "box" || (drawing.tool === "choose" && shift)) return "box";
    return drawing.tool === "choose" && mayEdit && id !== null && selection.has(id) ? "move" : "pan";
  }

  private dragged(from: Coordinate, to: Coordinate, { free, ended }: { free: boolean; ended: boolean }): void {
    const { chosen } = this.editing;
    const [start, end] = [this.toLot(from), this.toLot(to)];
    const by: Spot = [end[0] - start[0], end[1] - start[1]];
    const moved = chosen.map((stall) => ({ ...stall, north: stall.north + by[0], east: stall.east + by[1] }));
    const [up, right] = free ? [0, 0] : this.snapMoved(moved, end);
    const shapes = moved.map((stall) => shiftedShape(this.frame.toMap, { ...stall, north: stall.north + up, east: stall.east + right }));
    this.editor?.sketch(ended ? NO_SKETCH : { ...NO_SKETCH, shapes });
    if (!ended) return;
    this.sketched = "";
    this.editing.doChosen((stalls) => ({ do: "move", stalls, north: by[0] + up, east: by[1] + right }));
  }

  private snapMoved(moved: readonly PlanStall[], at: Spot): Spot {
    const own = new Set(moved.map(({ id }) => id));
    const near = this.around([at]).filter(({ id }) => !own.has(id));
    const close = moved.filter(({ north, east }) => Math.hypot(north - at[0], east - at[1]) < AROUND_M);
    return snapMove(close, near, this.editing.lot?.found ?? []);
  }

  private around(places: readonly Spot[]): PlanStall[] {
    const { plan } = this.editing;
    const found = places.flatMap((place) => {
      const [east, north] = this.toMap(place);
      return this.editor?.layer.within([east - AROUND_M, north - AROUND_M, east + AROUND_M, north + AROUND_M]) ?? [];
    });
    const isNear = (stall: PlanStall): boolean => places.some(([north, east]) => Math.hypot(stall.north - north, stall.east - east) < AROUND_M);
    return [...new Set(found.map(({ id }) => id))].flatMap((id) => plan.get(id) ?? []).filter(isNear);
  }

  private onMap(stall: PlanStall): PlanShape {
    const { id, label, kind, north, east, angle, width, length } = shiftedShape(this.frame.toMap, stall);
    return { id, label, kind, north, east, angle, width, length, confirmed: stall.is_confirmed, named: stall.is_named, chosen: this.editing.selection.has(id) };
  }

  private sectionOnMap({ outline, name }: { outline: readonly Spot[]; name: string }): Area {
    return { ring: outline.map((corner) => this.toMap(corner)), name, isSection: true };
  }

  private toMap(spot: Spot): Coordinate {
    const [north, east] = shifted(this.frame.toMap, spot);
    return [east, north];
  }

  private toLot([east, north]: Coordinate): Spot {
    return shifted(inverse(this.frame.toMap), [north, east]);
  }
}

function rowOf(stall: PlanStall | undefined): string | null {
  return partsOf(stall?.label ?? "")?.row ?? null;
}
