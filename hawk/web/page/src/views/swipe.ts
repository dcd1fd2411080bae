import { html, type TemplateResult } from "lit";
import { icon } from "../ui/icons.ts";

const STEP = 0.02;
const LARGE_STEP = 0.1;

interface Handle {
  at: number;
  /** What the slider is, and what its value means. */
  label: string;
  words: string;
  /** `isLast`: it was let go. */
  moved: (at: number, isLast: boolean) => void;
}

/** A slider across the map, by pointer, finger and arrow keys; the map below does not move with it. */
export function swipeHandle({ at, label, words, moved }: Handle): TemplateResult {
  const drag = (event: PointerEvent): void => {
    const handle = event.currentTarget as HTMLElement;
    if (handle.hasPointerCapture(event.pointerId)) moved(shareOf(handle, event.clientX), event.type === "pointerup");
  };
  const down = (event: PointerEvent): void => {
    event.preventDefault();
    (event.currentTarget as HTMLElement).focus();
    (event.currentTarget as HTMLElement).setPointerCapture(event.pointerId);
  };
  const key = (event: KeyboardEvent): void => {
    const to = keyed(event, at);
    if (to === null) return;
    event.preventDefault();
    moved(to, true);
  };
  return html`<div class="line"></div><div class="handle" role="slider" tabindex="0" aria-label=${label} aria-orientation="horizontal"
    aria-valuemin="0" aria-valuemax="100" aria-valuenow=${Math.round(100 * at)} aria-valuetext=${words}
    @pointerdown=${down} @pointermove=${drag} @pointerup=${drag} @keydown=${key}>${icon("left")}${icon("next")}</div>`;
}

/** Where a place of the screen lies across the map, 0 to 1. */
function shareOf(handle: HTMLElement, x: number): number {
  const { left = 0, width = 1 } = handle.parentElement?.getBoundingClientRect() ?? {};
  return rounded((x - left) / Math.max(1, width));
}

function rounded(at: number): number {
  return Math.min(1, Math.max(0, Math.round(1000 * at) / 1000));
}

/** Where a key brings the slider; null: none of its keys. */
function keyed({ key, shiftKey }: KeyboardEvent, at: number): number | null {
  const step = shiftKey ? LARGE_STEP : STEP;
  if (key === "ArrowRight" || key === "ArrowUp") return rounded(at + step);
  if (key === "ArrowLeft" || key === "ArrowDown") return rounded(at - step);
  if (key === "PageUp") return rounded(at + LARGE_STEP);
  if (key === "PageDown") return rounded(at - LARGE_STEP);
  return key === "Home" ? 0 : key === "End" ? 1 : null;
}
