import type { StallState } from "../state/map-store.ts";
import type { Rgb } from "./palette.ts";
import type { Rectangle } from "./geometry.ts";

/**
 * How stalls look: free light and plain, taken dark and hatched, unclear dark with dashes and a question mark, suggested
 * dotted and empty. A car is to be seen beneath each, and free and taken differ in brightness, so that they are distinct in
 * grey, too.
 */
export interface Fill {
  colour: Rgb;
  /** 0 to 1. */
  alpha: number;
}

export const FILLS: Record<StallState, Fill> = {
  free: { colour: [112, 182, 255], alpha: 0.46 },
  taken: { colour: [16, 22, 28], alpha: 0.34 },
  unknown: { colour: [16, 22, 28], alpha: 0.38 },
  suggested: { colour: [16, 22, 28], alpha: 0 },
};
export const LINES: Record<StallState, string> = { free: "#e3f1ff", taken: "#e05a00", unknown: "#fff", suggested: "#fff" };
/** Dashes of the outlines, pixels. */
export const DASHES: Record<StallState, number[]> = { free: [], taken: [], unknown: [4, 3], suggested: [1.5, 3] };
export const HATCH: Fill = { colour: [255, 106, 20], alpha: 0.9 };
/** Part of the ground that the lines of the hatching cover. */
export const HATCH_SHARE = 0.24;
/** Colours of stalls by the share of surveys that found them taken, a fifth each. */
export const HEAT: readonly Fill[] = ([[255, 245, 214], [253, 194, 122], [239, 127, 60], [185, 60, 27], [95, 15, 10]] as const).map((colour) => ({ colour, alpha: 0.85 }));
/** Between two lines of the hatching: metres, and on the screen at least and at most this number of pixels. */
const HATCH_M = 0.55;
const HATCH_PX = [5, 24] as const;

/** A width of an outline and what else is drawn, by metres a pixel. */
export interface Detail {
  line: number;
  hatched: boolean;
  /** Question marks on what is unclear. */
  marked: boolean;
}

const NEAR = 0.19;
const FAR = 0.45;

export function detailAt(resolution: number): Detail {
  if (resolution <= NEAR) return { line: 1.5, hatched: true, marked: true };
  return resolution <= FAR ? { line: 1, hatched: true, marked: false } : { line: 0, hatched: false, marked: false };
}

/** Pixels between two lines of the hatching, across them. */
export function hatchPeriod(resolution: number): number {
  return Math.min(HATCH_PX[1], Math.max(HATCH_PX[0], HATCH_M / resolution));
}

/** Stalls that were found a little too large overlap by some centimetres: each is drawn smaller by so much on every side. */
const GAP_M = 0.08;
/** Of each side this much is drawn in any case. */
const LEAST_SIDE = 0.5;

/** A stall as it is drawn: its outline lies inside it, by half its width, so that it never lies on the neighbour's. */
export function inset(stall: Rectangle, line: number, resolution: number): Rectangle {
  const by = 2 * (GAP_M + (line / 2) * resolution);
  const smaller = (side: number): number => Math.max(side * LEAST_SIDE, side - by);
  return { ...stall, width: smaller(stall.width), length: smaller(stall.length) };
}

export function css({ colour, alpha }: Fill): string {
  return `rgba(${colour.join(",")},${alpha})`;
}

/** Brightness of a stall as the eye takes it over ground of a colour: relative luminance (WCAG 2), 0 to 1, on average. */
export function brightnessOver(state: StallState, ground: Rgb): number {
  const filled = over(FILLS[state], ground);
  if (state !== "taken") return luminance(filled);
  return (1 - HATCH_SHARE) * luminance(filled) + HATCH_SHARE * luminance(over(HATCH, filled));
}

/** Contrast of two brightnesses, 1 to 21 (WCAG 2). */
export function contrast(one: number, other: number): number {
  return (Math.max(one, other) + 0.05) / (Math.min(one, other) + 0.05);
}

function over({ colour, alpha }: Fill, ground: Rgb): Rgb {
  const mix = (at: 0 | 1 | 2): number => colour[at] * alpha + ground[at] * (1 - alpha);
  return [mix(0), mix(1), mix(2)];
}

export function luminance(colour: Rgb): number {
  const [red, green, blue] = colour.map((value) => {
    const share = value / 255;
    return share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
  });
  return 0.2126 * (red ?? 0) + 0.7152 * (green ?? 0) + 0.0722 * (blue ?? 0);
}
