import { FenceDraft } from "../fence/draft.ts";
import { FenceFileError, readFence, writeFence } from "../fence/geojson.ts";
import type { Command, FenceCorner, OutlineSetup } from "../protocol.ts";
import { say } from "../words/say.ts";
import { Drawing } from "./drawing.ts";

/** The rings of an outline, as the drone takes them. */
export interface OutlineRings {
  Polygons: FenceCorner[][];
  Holes: FenceCorner[][];
}

export interface OutlineHooks {
  /** Sends a command; a refusal is shown. Resolves to whether it was taken. */
  command: (command: Command, what: string) => Promise<boolean>;
  changed: () => void;
  showToast: (text: string, level: "info" | "warning") => void;
  storage: Pick<Storage, "getItem" | "setItem">;
}

const KEY = "hawk-outline";
/** An outline has no ceiling. */
const NO_CEILING = 1;

/** The area that Explore is to survey: drawing it, setting and clearing it, and the one of the last survey. */
export class OutlineEditing extends Drawing {
  /** What the drone has; null before it said so. */
  setup: OutlineSetup | null = null;
  saving = false;
  private readonly hooks: OutlineHooks;

  constructor(hooks: OutlineHooks) {
    super();
    this.hooks = hooks;
  }

  /** The outline that was in force last, as this browser kept it; null where there is none, or where it still is. */
  get last(): OutlineRings | null {
    return this.setup?.Source === "none" ? readRings(this.hooks.storage) : null;
  }

  /** The drone says what it is to survey. */
  hear(setup: OutlineSetup): void {
    this.setup = setup;
    if (setup.Source === "none") return;
    try {
      this.hooks.storage.setItem(KEY, JSON.stringify({ Polygons: setup.Polygons, Holes: setup.Holes }));
    } catch {
      return; // a browser that keeps nothing
    }
  }

  /** Opens the editor with what was left unset, else with the outline in force. One of several polygons is not edited. */
  begin(): void {
    const { Polygons: [ring = [], ...others] = [], Holes: holes = [] } = this.setup ?? {};
    if (others.length > 0) return;
    this.start(new FenceDraft(ring, NO_CEILING, holes));
    this.changed();
  }

  /** Asks the drone to survey what is drawn. A refusal is shown and the editor stays open. */
  async save(): Promise<void> {
    const { draft } = this;
    if (!draft?.isDrawn || this.saving) return;
    this.saving = true;
    this.changed();
    const rings = { Polygons: [[...draft.corners]], Holes: draft.zones.map((zone) => [...zone]) };
    const taken = await this.set(rings);
    this.saving = false;
    if (taken && this.draft === draft) this.cancel();
    else this.changed();
  }

  /** Asks the drone to survey the outline of the last survey again. */
  async takeLast(): Promise<void> {
    const { last } = this;
    if (last) await this.set(last);
  }

  async clear(): Promise<void> {
    const done = await this.hooks.command({ Type: "Clear Outline" }, say("remove-outline"));
    if (done) this.hooks.showToast(say("outline-is-removed"), "info");
  }

  override import(text: string): boolean {
    try {
      const file = readFence(text, "outline");
      this.draw(file.corners, undefined, file.zones);
      return true;
    } catch (error) {
      if (!(error instanceof FenceFileError)) throw error;
      this.showToast(error.message, "warning");
      return false;
    }
  }

  override export(): string | null {
    const { draft } = this;
    if (!draft?.isDrawn) return null;
    return writeFence({ corners: [...draft.corners], zones: draft.zones.map((zone) => [...zone]), ceiling: null }, "outline");
  }

  protected override redrawn(): void {
    this.changed();
  }

  protected override changed(): void {
    this.hooks.changed();
  }

  protected override showToast(text: string, level: "info" | "warning"): void {
    this.hooks.showToast(text, level);
  }

  private async set(rings: OutlineRings): Promise<boolean> {
    const taken = await this.hooks.command({ Type: "Set Outline", ...rings }, say("set-outline-what"));
    if (taken) this.hooks.showToast(say("outline-is-set"), "info");
    return taken;
  }
}

/** What was stored; null for what cannot be an outline. */
function readRings(storage: OutlineHooks["storage"]): OutlineRings | null {
  try {
    const stored: unknown = JSON.parse(storage.getItem(KEY) ?? "null");
    if (typeof stored !== "object" || stored === null) return null;
    const { Polygons, Holes } = stored as Partial<Record<keyof OutlineRings, unknown>>;
    return isRings(Polygons) && isRings(Holes) && Polygons.length > 0 ? { Polygons, Holes } : null;
  } catch {
    return null;
  }
}

function isRings(rings: unknown): rings is FenceCorner[][] {
  return Array.isArray(rings) && rings.every((ring) => Array.isArray(ring) && ring.length >= 3 && ring.every(isCorner));
}

function isCorner(corner: unknown): corner is FenceCorner {
  if (typeof corner !== "object" || corner === null) return false;
  const { Latitude, Longitude } = corner as Partial<Record<keyof FenceCorner, unknown>>;
  return Number.isFinite(Latitude) && Number.isFinite(Longitude);
}
