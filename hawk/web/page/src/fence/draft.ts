import type { FenceCorner } from "../protocol.ts";

/** Corners of exclusion zones, each in order, not closed. */
export type Zones = readonly (readonly FenceCorner[])[];

/** One moment of a drawing. */
interface Drawn {
  readonly corners: readonly FenceCorner[];
  readonly zones: Zones;
  readonly ceiling: string;
}

const REMEMBERED = 200;
const NO_ZONES: Zones = [];

/** A fence that is being drawn. Each change can be taken back. */
export class FenceDraft {
  /** In order around the fence, not closed; fewer than three while nothing is drawn. */
  corners: readonly FenceCorner[];
  zones: Zones;
  /** As it was typed, metres. */
  ceiling: string;
  private readonly saved: Drawn;
  private before: Drawn[] = [];

  constructor(corners: readonly FenceCorner[], ceiling: number, zones: Zones = NO_ZONES) {
    this.corners = corners;
    this.zones = zones;
    this.ceiling = String(ceiling);
    this.saved = { corners, zones, ceiling: this.ceiling };
  }

  get canUndo(): boolean {
    return this.before.length > 0;
  }

  get isDrawn(): boolean {
    return this.corners.length >= 3;
  }

  get isChanged(): boolean {
    const redrawn = this.corners !== this.saved.corners && (this.isDrawn || this.saved.corners.length > 0);
    const rezoned = this.zones !== this.saved.zones && (this.zones.length > 0 || this.saved.zones.length > 0);
    return redrawn || rezoned || this.ceiling !== this.saved.ceiling;
  }

  /** Metres, null for what is no number above 0. */
  get ceilingMetres(): number | null {
    const value = Number(this.ceiling.trim().replace(",", ".") || Number.NaN);
    return Number.isFinite(value) && value > 0 ? value : null;
  }

  /** Without corners there are no zones either. */
  draw(corners: readonly FenceCorner[], ceiling = this.ceiling, zones = corners.length === 0 ? NO_ZONES : this.zones): void {
    const nothing = corners.length === 0 && this.corners.length === 0 && ceiling === this.ceiling;
    if (!nothing) this.remember();
    this.corners = corners;
    this.zones = zones;
    this.ceiling = ceiling;
  }

  /** Typing is one change, whatever the number of keys. */
  typeCeiling(ceiling: string): void {
    const last = this.before.at(-1);
    if (last?.corners === this.corners && last.zones === this.zones && last.ceiling !== this.ceiling) this.ceiling = ceiling;
    else this.draw(this.corners, ceiling);
  }

  undo(): void {
    const last = this.before.pop();
    if (!last) return;
    this.corners = last.corners;
    this.zones = last.zones;
    this.ceiling = last.ceiling;
  }

  private remember(): void {
    this.before = [...this.before, { corners: this.corners, zones: this.zones, ceiling: this.ceiling }].slice(-REMEMBERED);
  }
}
