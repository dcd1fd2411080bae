import { path, type Pixel, stroke, type Surface } from "./surface.ts";

/** The last metres flown are drawn in full, and those before fade until only so much of them is left. */
const FULL_M = 100;
const FADED_M = 700;
const LEAST = 0.25;
const STEPS = 8;
const DARK = "#10161c";

/** A piece of the trail, by its first and last point; `share`: how much of it is to be seen, 0 to 1. */
export interface Piece {
  from: number;
  to: number;
  share: number;
}

/** The trail in pieces, oldest first: the longer ago, counted by the distance flown since, the fainter. */
export function fading(trail: readonly Pixel[], resolution: number): Piece[] {
  const pieces: Piece[] = [];
  let since = 0;
  for (let index = trail.length - 1; index > 0; index -= 1) {
    const [here, before] = [trail[index], trail[index - 1]];
    if (!here || !before) break;
    const share = shareAt(since);
    const last = pieces.at(-1);
    if (last?.share === share) last.from = index - 1;
    else pieces.push({ from: index - 1, to: index, share });
    since += Math.hypot(here[0] - before[0], here[1] - before[1]) * resolution;
  }
  return pieces.toReversed();
}

function shareAt(metres: number): number {
  const faded = Math.min(1, Math.max(0, (metres - FULL_M) / (FADED_M - FULL_M)));
  return 1 - (Math.floor(faded * STEPS) / STEPS) * (1 - LEAST);
}

export function drawTrail({ context, resolution }: Surface, trail: readonly Pixel[]): void {
  const shown = thinned(trail);
  const pieces = fading(shown, resolution);
  context.lineJoin = "round";
  for (const line of [{ colour: DARK, width: 5 }, { colour: "#fff", width: 2.5 }]) {
    for (const { from, to, share } of pieces) {
      context.globalAlpha = share;
      path(context, shown.slice(from, to + 1));
      stroke(context, line);
    }
  }
  context.globalAlpha = 1;
}

/** Leaves out points that are less than two pixels from the last one. */
function thinned(pixels: readonly Pixel[]): Pixel[] {
  let last: Pixel = [Infinity, Infinity];
  return pixels.filter((pixel, index) => {
    const near = Math.abs(pixel[0] - last[0]) + Math.abs(pixel[1] - last[1]) < 2;
    if (near && index < pixels.length - 1) return false;
    last = pixel;
    return true;
  });
}
