import Layer from "ol/layer/Layer.js";
import type { FrameState } from "ol/Map.js";
import type { Background } from "./background.ts";
import { type Extent, type Sight, sightExtent, toPixel } from "./geometry.ts";
import { type GroundTiles, outOf } from "./ground-tiles.ts";
import type { Palette } from "./palette.ts";
import { northUp, WideCanvas } from "./wide-canvas.ts";

const GRID_M = 20;
/** Tiles overlap by so much: their soft edges would let the ground shine through. */
const OVERLAP_PX = 0.5;

/** The lowest layer: a grid of 20 m, a background where there is one, and what the drone saw of the ground. */
export class GroundLayer extends Layer {
  palette: Palette | null = null;
  private frame: FrameState | null = null;
  private readonly wide = new WideCanvas("ground", (context, sight) => this.paint(context, sight));
  private readonly tiles: GroundTiles;
  private readonly background: Background;

  constructor(tiles: GroundTiles, background: Background) {
    super({});
    this.tiles = tiles;
    this.background = background;
  }

  override render(frame: FrameState | null): HTMLElement {
    this.frame = frame;
    if (frame) this.wide.show(frame);
    return this.wide.holder;
  }

  set held(held: boolean) {
    this.wide.held = held;
  }

  /** Draws this layer alone, as the view was last: what lies over it need not be drawn again. */
  repaint(): void {
    this.wide.touch();
    if (this.frame) this.wide.show(this.frame);
  }

  private paint(context: CanvasRenderingContext2D, sight: Sight): void {
    if (!this.palette) return;
    const shown = sightExtent(sight);
    const { resolution } = sight;
    northUp(context, sight);
    drawGrid(context, shown, sight, this.palette.grid);
    context.imageSmoothingQuality = "medium";
    this.background.draw(context, shown, resolution);
    const { place } = this.tiles;
    context.translate(place.east / resolution, -place.north / resolution);
    context.rotate(place.turn);
    this.tiles.draw(outOf(place, shown), resolution, (picture, east, north, width, height) => {
      const [across, down] = [width / resolution + 2 * OVERLAP_PX, height / resolution + 2 * OVERLAP_PX];
      context.drawImage(picture, east / resolution - OVERLAP_PX, -north / resolution - OVERLAP_PX, across, down);
    });
  }
}

function drawGrid(context: CanvasRenderingContext2D, [west, south, east, north]: Extent, sight: Sight, colour: string): void {
  const { resolution, rotation } = sight;
  const [left, top] = toPixel(sight, [0, 0]);
  const step = GRID_M * Math.max(1, 2 ** Math.ceil(Math.log2((resolution * 50) / GRID_M)));
  const sharp = (metres: number, origin: number): number =>
    rotation === 0 ? Math.round(metres / resolution + origin) + 0.5 - origin : metres / resolution;
  context.beginPath();
  for (let at = Math.ceil(west / step) * step; at < east; at += step) {
    context.moveTo(sharp(at, left), -north / resolution);
    context.lineTo(sharp(at, left), -south / resolution);
  }
  for (let at = Math.ceil(south / step) * step; at < north; at += step) {
    context.moveTo(west / resolution, sharp(-at, top));
    context.lineTo(east / resolution, sharp(-at, top));
  }
  context.strokeStyle = colour;
  context.lineWidth = 1;
  context.stroke();
}
