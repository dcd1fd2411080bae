import Layer from "ol/layer/Layer.js";
import type { FrameState } from "ol/Map.js";
import type { GroundTiles } from "./ground-tiles.ts";
import type { Palette } from "./palette.ts";

const GRID_M = 20;

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
    const { resolution, center } = frame.viewState;
    const x = (east: number): number => width / 2 + (east - (center[0] ?? 0)) / resolution;
    const y = (north: number): number => height / 2 - (north - (center[1] ?? 0)) / resolution;
    drawGrid(context, { width, height, x, y, metres: resolution, colour: this.palette.grid });
    context.imageSmoothingQuality = "medium";
    const inSight = (east: number, north: number, side: number): boolean =>
      x(east + side) > 0 && y(north - side) > 0 && x(east) < width && y(north) < height;
    this.tiles.draw(inSight, (picture, east, north, side) => {
      const [left, top] = [x(east), y(north)];
      context.drawImage(picture, left, top, x(east + side) - left, y(north - side) - top);
    });
  }
}

interface GridFrame {
  width: number;
  height: number;
  x: (east: number) => number;
  y: (north: number) => number;
  metres: number;
  colour: string;
}

function drawGrid(context: CanvasRenderingContext2D, frame: GridFrame): void {
  const step = GRID_M * Math.max(1, 2 ** Math.ceil(Math.log2((frame.metres * 50) / GRID_M)));
  context.beginPath();
  const pixels = step / frame.metres;
  for (let at = frame.x(0) % pixels; at < frame.width; at += pixels) {
    context.moveTo(Math.round(at) + 0.5, 0);
    context.lineTo(Math.round(at) + 0.5, frame.height);
  }
  for (let at = frame.y(0) % pixels; at < frame.height; at += pixels) {
    context.moveTo(0, Math.round(at) + 0.5);
    context.lineTo(frame.width, Math.round(at) + 0.5);
  }
  context.strokeStyle = frame.colour;
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
