import type { Zones } from "../fence/draft.ts";
import type { LocalPlane } from "../fence/plane.ts";
import type { FenceCorner } from "../protocol.ts";
import { LatePart, READING } from "../shell/late-part.ts";
import type { Drawing } from "../state/drawing.ts";
import type { Operator } from "../state/operator.ts";
import type { FenceEditor, Ring } from "./fence-editor.ts";
import { draftFence, dronePlace, type ShownFence } from "./fence-shown.ts";
import { toCoordinate } from "./geometry.ts";
import type { LotMap } from "./lot-map.ts";

/** Side of the square that one can begin with, metres. */
const SQUARE_M = 100;
const ZONE_SQUARE_M = 20;

/** Keeps the editor on the map and the drawing of the model the same: degrees there, metres here. */
export class FenceOnMap {
  private readonly lot: LotMap;
  private readonly model: Operator;
  private editor: FenceEditor | null = null;
  private Editor: typeof FenceEditor | null = null;
  /** The editor, most of the map's code, is read when somebody draws: who flies does not wait for it. */
  private readonly part: LatePart;
  private corners: readonly FenceCorner[] | null = null;
  private zones: Zones | null = null;
  private plane: LocalPlane | null = null;
  /** What the open editor draws. */
  private edited: Drawing | null = null;

  constructor(lot: LotMap, model: Operator, read: () => Promise<{ FenceEditor: typeof FenceEditor }> = READING.fence) {
    this.lot = lot;
    this.model = model;
    const keep = (found: { FenceEditor: typeof FenceEditor }): void => void (this.Editor = found.FenceEditor);
    this.part = new LatePart(() => read().then(keep), () => this.update());
  }

  /** What is to be drawn beside the editor's own line; null while nothing is drawn: the fence that counts stays. */
  shown(): ShownFence | null {
    const { open, draft, verdict } = this.model.fence;
    if (!this.editor || !open || draft?.isDrawn !== true) return null;
    return draftFence(verdict.about === "good" ? verdict.check : null, this.plane);
  }

  /** Reads the editor, so that it is there when somebody draws. */
  read(): void {
    this.part.want();
  }

  /** Opens, closes and fills the editor as the model says. */
  update(): void {
    if (this.model.drawing !== this.edited) this.toggle(this.model.drawing);
    if (this.edited && !this.editor && this.part.want() && this.Editor) this.open(this.Editor, this.edited);
    const { draft = null, removing = false, zoning = false } = this.edited ?? {};
    if (!this.editor || !draft) return;
    this.editor.removing = removing;
    this.editor.zone(zoning);
    this.editor.measureIn(this.model.preferences.units);
    const plane = this.model.flight.plane;
    if (draft.corners === this.corners && draft.zones === this.zones && plane === this.plane) return;
    this.corners = draft.corners;
    this.zones = draft.zones;
    this.plane = plane;
    this.editor.show(this.ring(), this.zoneRings());
  }

  bringInView(): void {
    this.update();
    this.lot.bringInView(this.ring());
  }

  /** A tool that needs the map. */
  use(what: "back" | "close" | "square"): void {
    if (what === "back") this.editor?.takeBack();
    else if (what === "close") this.editor?.finish();
    else this.square();
  }

  /** By keyboard: Enter sets a corner in the middle of the map, Backspace takes the last one back. */
  key(event: KeyboardEvent): void {
    if (event.key === "Enter") this.editor?.add(toCoordinate(this.lot.centre));
    else if (event.key === "Backspace" && (this.edited?.begun ?? 0) > 0) this.editor?.takeBack();
    else if (event.key === "z" && (event.ctrlKey || event.metaKey)) this.edited?.undo();
  }

  private open(Editor: typeof FenceEditor, edited: Drawing): void {
    const drawn = (ring: Ring, zones: readonly Ring[]): void => this.drawn(ring, zones);
    this.editor = this.lot.editFence(Editor, { drawn, drawing: (corners) => edited.drawing(corners) });
    this.corners = this.zones = null;
  }

  private toggle(edited: Drawing | null): void {
    this.edited = edited;
    this.lot.leaveFence();
    this.editor = null;
    this.corners = this.zones = null;
    if (!edited) return;
    this.lot.stay();
    this.plane = this.model.flight.plane;
    const ring = this.ring();
    const drone = this.model.flight.heartbeat && dronePlace(this.model.flight.heartbeat, this.plane);
    if (ring.length > 0) this.lot.bringInView(ring);
    else if (drone) this.lot.bringInView(squareAround(toCoordinate(drone)));
  }

  private drawn(ring: Ring, zones: readonly Ring[]): void {
    if (!this.plane) return;
    const plane = this.plane;
    const onEarth = (places: Ring): FenceCorner[] => places.map(([East, North]) => plane.toEarth({ North, East }));
    this.corners = onEarth(ring);
    this.zones = zones.map(onEarth);
    this.edited?.draw(this.corners, undefined, this.zones);
  }

  /** A square in the middle of the map: what is drawn, or a zone of it. */
  private square(): void {
    const zoning = this.edited?.zoning === true;
    const square = squareAround(toCoordinate(this.lot.centre), zoning ? ZONE_SQUARE_M : SQUARE_M);
    const ring = zoning ? this.ring() : square;
    const zones = zoning ? [...this.zoneRings(), square] : [];
    this.editor?.show(ring, zones);
    this.drawn(ring, zones);
  }

  private ring(): Ring {
    return this.onMap(this.edited?.draft?.corners ?? []);
  }

  private zoneRings(): Ring[] {
    return (this.edited?.draft?.zones ?? []).map((zone) => this.onMap(zone));
  }

  private onMap(corners: readonly FenceCorner[]): Ring {
    const { plane } = this;
    return plane ? corners.map((corner) => toCoordinate(plane.toMap(corner))) : [];
  }
}

function squareAround([east, north]: readonly [number, number], side = SQUARE_M): Ring {
  const half = side / 2;
  return [
    [east - half, north - half],
    [east - half, north + half],
    [east + half, north + half],
    [east + half, north - half],
  ];
}
