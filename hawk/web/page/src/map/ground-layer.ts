import Layer from "ol/layer/Layer.js";
import type { FrameState } from "ol/Map.js";
import { type Extent, type Sight, sightExtent, toPixel } from "./geometry.ts";
import type { GroundTiles } from "./ground-tiles.ts";
import type { Palette } from "./palette.ts";

const GRID_M = 20;
/** Tiles overlap by so much: their soft edges would let the ground shine through. */
const OVERLAP_PX = 0.5;

/** The lowest layer: a grid of 20 m, and what the drone saw of the ground. */
export class GroundLayer extends Layer {
  palette: Palette | null = null;
  private frame: FrameState | null = null;
  private readonly canvas = document.createElement("canvas");
  /** OpenLayers draws the next layer into a bare canvas below it: this one is wiped on its own, so it is not bare. */
  private readonly holder = document.createElement("div");

  private readonly tiles: GroundTiles;

  constructor(tiles: GroundTiles) {
    super({});
    this.tiles = tiles;
    this.holder.className = "ground";
    this.holder.append(this.canvas);
  }

  override render(frame: FrameState | null): HTMLElement {
    this.frame = frame;
    this.repaint();
    return this.holder;
  }

  /** Draws this layer alone, as the view was last: what lies over it need not be drawn again. */
  repaint(): void {
    const frame = this.frame;
    const context = this.canvas.getContext("2d");
    if (!frame || !context || !this.palette) return;
    const ratio = frame.pixelRatio;
    const [width, height] = [frame.size[0] ?? 0, frame.size[1] ?? 0];
    resize(this.canvas, width, height, ratio);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    const sight = sightOf(frame);
    const shown = sightExtent(sight);
    northUp(context, sight);
    drawGrid(context, shown, sight, this.palette.grid);
    context.imageSmoothingQuality = "medium";
    const inSight = (east: number, north: number, side: number): boolean =>
      east + side > shown[0] && north > shown[1] && east < shown[2] && north - side < shown[3];
    const { resolution } = sight;
    this.tiles.draw(inSight, (picture, east, north, side) => {
      const length = side / resolution + 2 * OVERLAP_PX;
      context.drawImage(picture, east / resolution - OVERLAP_PX, -north / resolution - OVERLAP_PX, length, length);
    });
  }
}

/** What OpenLayers is about to show. */
export function sightOf({ size, viewState }: FrameState): Sight {
  const { center, resolution, rotation } = viewState;
  return { width: size[0] ?? 0, height: size[1] ?? 0, center: [center[0] ?? 0, center[1] ?? 0], resolution, rotation };
}

/** From here on one draws in pixels right (east) and down (south) of the map's origin, whichever way the map is turned. */
export function northUp(context: CanvasRenderingContext2D, { width, height, center, resolution, rotation }: Sight): void {
  context.translate(width / 2, height / 2);
  context.rotate(rotation);
  context.translate(-center[0] / resolution, center[1] / resolution);
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

/** Gives a canvas the size of its place, at the screen's own resolution. */
export function resize(canvas: HTMLCanvasElement, width: number, height: number, ratio: number): void {
  const [across, down] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== across) canvas.width = across;
  if (canvas.height !== down) canvas.height = down;
  canvas.style.width = `${width}px`;
  canvas.style.height = `${height}px`;
}
