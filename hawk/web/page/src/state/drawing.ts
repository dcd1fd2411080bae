import type { FenceDraft, Zones } from "../fence/draft.ts";
import type { FenceCorner } from "../protocol.ts";
import { say, sentences } from "../words/say.ts";

/** An area that is being drawn on the map, with zones cut out of it. What it is for, its own classes know. */
export abstract class Drawing {
  draft: FenceDraft | null = null;
  /** True while the editor is open; a draft survives when the editor closes because the drone took off. */
  open = false;
  /** Corners of a ring that is not closed yet. */
  begun = 0;
  /** Whether a corner that is pointed at is removed. */
  removing = false;
  /** Whether the ring that is drawn next is cut out. */
  zoning = false;

  /** Closes the editor; what was drawn is given up. */
  cancel(): void {
    this.close();
    this.draft = null;
    this.changed();
  }

  /** Closes the editor because it cannot be drawn now; what was drawn is kept until it is opened again. */
  pause(reason: string): void {
    if (!this.open) return;
    const kept = this.draft?.isChanged === true;
    this.close();
    if (!kept) this.draft = null;
    this.showToast(sentences(reason, kept ? say("drawing-kept") : ""), "warning");
  }

  /** A drawing without zones keeps those that are there; one without corners has none. */
  draw(corners: readonly FenceCorner[], ceiling?: string, zones?: Zones): void {
    this.draft?.draw(corners, ceiling, zones);
    this.begun = 0;
    this.zoning = false;
    if (!this.draft?.isDrawn) this.removing = false;
    this.redrawn();
  }

  undo(): void {
    this.draft?.undo();
    this.begun = 0;
    this.zoning = false;
    this.redrawn();
  }

  /** Number of corners of the ring that is being drawn. */
  drawing(begun: number): void {
    if (begun === this.begun) return;
    this.begun = begun;
    this.changed();
  }

  remove(removing: boolean): void {
    this.removing = removing;
    this.zoning = false;
    this.changed();
  }

  /** Begins a zone, or gives up the one that is being drawn. */
  zone(zoning: boolean): void {
    this.zoning = zoning && this.draft?.isDrawn === true;
    this.removing = false;
    this.begun = 0;
    this.changed();
  }

  /** Takes a file's drawing over; a file without one is reported and changes nothing. */
  abstract import(text: string): boolean;

  /** GeoJSON of what is drawn; null while there is nothing. */
  abstract export(): string | null;

  /** Something else is drawn now. */
  protected abstract redrawn(): void;
  protected abstract changed(): void;
  protected abstract showToast(text: string, level: "info" | "warning"): void;

  protected start(draft: FenceDraft): void {
    this.open = true;
    this.begun = 0;
    this.removing = this.zoning = false;
    this.draft ??= draft;
  }

  protected close(): void {
    this.open = false;
    this.removing = this.zoning = false;
    this.begun = 0;
  }
}
