import Layer from "ol/layer/Layer.js";
import type { FrameState } from "ol/Map.js";
import { FONT_FAMILY } from "../font.ts";
import type { Fullness, Trend } from "../words/section.ts";
import { type Coordinate, type Sight, toPixel } from "./geometry.ts";
import { isInside } from "./plan-layer.ts";
import { path } from "./surface.ts";
import { WideCanvas } from "./wide-canvas.ts";

/** A section on the map: its ring, its name and what was counted in it, in words. */
export interface SectionShape {
  id: string;
  name: string;
  words: string;
  look: Fullness | Trend;
  ring: readonly Coordinate[];
}

interface Look {
  colour: string;
  width: number;
  dash: number[];
}

/** Colours as those of stalls, free and taken, also of a change; words say the same beside the name, and lines differ in width and dashes. */
const LOOKS: Record<Fullness | Trend, Look> = {
  room: { colour: "#70b6ff", width: 3, dash: [] },
  full: { colour: "#ff6a14", width: 3, dash: [] },
  over: { colour: "#ff2d55", width: 6, dash: [] },
  alone: { colour: "#ffffff", width: 3, dash: [] },
  unseen: { colour: "#ffffff", width: 2, dash: [4, 4] },
  more: { colour: "#ff6a14", width: 3, dash: [] },
  fewer: { colour: "#70b6ff", width: 3, dash: [] },
  "surely-more": { colour: "#ff6a14", width: 6, dash: [] },
  "surely-fewer": { colour: "#70b6ff", width: 6, dash: [] },
  same: { colour: "#ffffff", width: 3, dash: [] },
};
const CASE = "rgba(16,22,28,.85)";
const FILL = "22";
const CHOSEN_FILL = "55";
/** Metres a pixel up to which there is room for words. */
const LABELLED = 0.35;
const LINE_PX = 15;

/** Sections with what a survey counted in them. */
export class SectionsLayer extends Layer {
  private shapes: readonly SectionShape[] = [];
  private chosen = "";
  private readonly wide = new WideCanvas("sections", (context, sight) => {
    for (const shape of this.shapes) drawRing(context, shape, sight, shape.id === this.chosen);
    if (sight.resolution <= LABELLED) for (const shape of this.shapes) drawWords(context, shape, sight);
  });

  constructor() {
    super({});
  }

  show(shapes: readonly SectionShape[], chosen: string): void {
    if (shapes === this.shapes && chosen === this.chosen) return;
    Object.assign(this, { shapes, chosen });
    this.wide.touch();
    this.changed();
  }

  /** The section at a place; "" for none. */
  at(place: Coordinate): string {
    return this.shapes.find(({ ring }) => isInside(ring, place))?.id ?? "";
  }

  override render(frame: FrameState | null): HTMLElement {
    if (frame) this.wide.show(frame);
    return this.wide.holder;
  }
}

/** The middle of a ring's corners. */
export function middleOf(ring: readonly Coordinate[]): Coordinate {
  const mean = (axis: 0 | 1): number => ring.reduce((sum, place) => sum + place[axis], 0) / ring.length;
  return [mean(0), mean(1)];
}

function drawRing(context: CanvasRenderingContext2D, { ring, look }: SectionShape, sight: Sight, isChosen: boolean): void {
  const { colour, width, dash } = LOOKS[look];
  path(context, ring.map((place) => toPixel(sight, place)), true);
  context.fillStyle = `${colour}${isChosen ? CHOSEN_FILL : FILL}`;
  context.fill();
  context.lineJoin = "round";
  const stroke = (style: string, wide: number, dashes: number[]): void => {
    context.setLineDash(dashes);
    context.strokeStyle = style;
    context.lineWidth = wide;
    context.stroke();
  };
  stroke(CASE, width + (isChosen ? 5 : 2), []);
  stroke(colour, width, dash);
  context.setLineDash([]);
}

function drawWords(context: CanvasRenderingContext2D, { ring, name, words }: SectionShape, sight: Sight): void {
  const [x, y] = toPixel(sight, middleOf(ring));
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.lineJoin = "round";
  context.lineWidth = 4;
  context.strokeStyle = CASE;
  context.fillStyle = "#fff";
  for (const [line, text] of [name, words].entries()) {
    context.font = `${line === 0 ? 700 : 600} 13px ${FONT_FAMILY}`;
    const down = y + (line - 0.5) * LINE_PX;
    context.strokeText(text, x, down);
    context.fillText(text, x, down);
  }
}
