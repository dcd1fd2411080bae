import { html, svg, type TemplateResult } from "lit";
import type { StallState } from "../state/map-store.ts";

const MARKS = {
  free: svg`<rect x="1" y="1" width="30" height="18" class="plate"/><rect x="1" y="1" width="30" height="18" class="free"/>`,
  taken: svg`<rect x="1" y="1" width="30" height="18" class="plate dark"/>
    <path class="hatch" d="M-1 11L11 -1M3 19.5L22 .5M13 19.5L31.5 1M23 19.5L32 10.5"/>
    <rect x="1.5" y="1.5" width="29" height="17" class="taken"/>`,
  unknown: svg`<rect x="1" y="1" width="30" height="18" class="plate dark"/>
    <rect x="3.5" y="3.5" width="25" height="13" class="unclear"/>
    <text x="16" y="14.4" text-anchor="middle" class="mark">?</text>`,
  suggested: svg`<rect x="1" y="1" width="30" height="18" class="plate dark"/>
    <rect x="3.5" y="3.5" width="25" height="13" class="unclear dotted"/>`,
};

/** The map's symbol of a kind of stall, for legends. */
export function swatch(state: StallState): TemplateResult {
  return html`<svg class="swatch" viewBox="0 0 32 20" aria-hidden="true">${MARKS[state]}</svg>`;
}
