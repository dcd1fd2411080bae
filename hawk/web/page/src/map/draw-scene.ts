import type { Point } from "../protocol.ts";
import { drawChanges } from "./draw-changes.ts";
import { drawMeasure } from "./draw-measure.ts";
import { drawTrail } from "./draw-trail.ts";
import { corners, toCoordinate } from "./geometry.ts";
import type { DroneMark, Scene } from "./flight-scene.ts";
import { path, type Pixel, stroke, type Surface } from "./surface.ts";

/** A route that ends this near the place ends there. */
const SAME_PLACE_M = 0.1;
/** Between two lines of an exclusion zone's hatching, pixels across and down. */
const HATCH_PX = 12;
/** Metres a pixel from which frames are thin: stalls are a few pixels wide. */
const FAR_RESOLUTION = 0.1;
const DARK = "#10161c";
const INK = "#15202b";

export function drawScene(surface: Surface, scene: Scene): void {
  const pixels = (places: readonly { North: number; East: number }[]): Pixel[] =>
    places.map((place) => surface.pixel(toCoordinate(place)));
  const drone = scene.drone ? surface.pixel([scene.drone.east, scene.drone.north]) : null;
  for (const zone of scene.zoneLimits) drawZone(surface, pixels(zone));
  for (const zone of scene.zones) drawFence(surface, pixels(zone));
  drawLimit(surface, pixels(scene.limit));
  drawFence(surface, pixels(scene.fence));
  drawOutline(surface, scene.outline.map(pixels));
  drawTrail(surface, drone && !scene.lost ? [...pixels(scene.trail), drone] : pixels(scene.trail));
  if (!scene.planned) drawRoute(surface, drone, pixels(scene.route), scene.target ? pixels([scene.target])[0] : undefined);
  drawFootprint(surface, pixels(scene.footprint));
  if (scene.changes) drawChanges(surface, scene.changes);
  for (const stall of scene.marked) drawFramed(surface, corners(stall).map(surface.pixel), surface.resolution < FAR_RESOLUTION ? 2.5 : 1);
  if (scene.selected) drawFramed(surface, corners(scene.selected).map(surface.pixel), 4);
  if (scene.home) drawHome(surface, surface.pixel(toCoordinate(scene.home)));
  if (scene.planned && scene.drone) drawPlanned(surface, scene, scene.drone);
  if (scene.measured) drawMeasure(surface, scene.measured);
  if (drone && scene.drone) drawDrone(surface, drone, scene.drone.yaw, scene.lost?.reach ?? null);
}

function drawFence({ context, palette }: Surface, fence: Pixel[]): void {
  if (fence.length < 3) return;
  path(context, fence, true);
  stroke(context, { colour: palette.fence, width: 2, dash: [2.5, 4.5] });
}

/** The area to explore is a plan: a thin line in its colour, and a little of it over what lies inside. */
function drawOutline({ context, palette }: Surface, rings: Pixel[][]): void {
  if (rings.length === 0) return;
  context.beginPath();
  for (const ring of rings) {
    ring.forEach(([x, y], index) => (index === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
    context.closePath();
  }
  context.globalAlpha = 0.06;
  context.fillStyle = palette.plan;
  context.fill("evenodd");
  context.globalAlpha = 1;
  context.lineJoin = "round";
  stroke(context, { colour: palette.planCase, width: 4 });
  stroke(context, { colour: palette.plan, width: 2 });
}

/** Beyond this line the autopilot itself acts. */
function drawLimit({ context, palette }: Surface, limit: Pixel[]): void {
  if (limit.length < 3) return;
  path(context, limit, true);
  stroke(context, { colour: palette.fence, width: 1.5 });
}

/** An exclusion zone is hatched, so that it differs from the fence at a glance and in any colours. */
function drawZone({ context, palette }: Surface, zone: Pixel[]): void {
  if (zone.length < 3) return;
  context.save();
  path(context, zone, true);
  context.clip();
  drawHatching(context, zone);
  stroke(context, { colour: palette.planCase, width: 3 });
  stroke(context, { colour: palette.zone, width: 1.5 });
  context.restore();
  path(context, zone, true);
  stroke(context, { colour: palette.planCase, width: 4 });
  stroke(context, { colour: palette.zone, width: 2 });
}

/** Lines from lower left to upper right over all of a ring, fixed to the page so that neighbours match. */
function drawHatching(context: CanvasRenderingContext2D, ring: readonly Pixel[]): void {
  const columns = ring.map(([x]) => x);
  const rows = ring.map(([, y]) => y);
  const { width, height } = context.canvas;
  const [left, right] = [Math.max(Math.min(...columns), 0), Math.min(Math.max(...columns), width)];
  const [top, bottom] = [Math.max(Math.min(...rows), 0), Math.min(Math.max(...rows), height)];
  context.beginPath();
  for (let sum = Math.floor((left + top) / HATCH_PX) * HATCH_PX; sum <= right + bottom; sum += HATCH_PX) {
    context.moveTo(sum - bottom, bottom);
    context.lineTo(sum - top, top);
  }
}

function drawRoute(surface: Surface, drone: Pixel | null, route: Pixel[], target: Pixel | undefined): void {
  const { context, palette } = surface;
  const stops = route.length > 0 ? route : target ? [target] : [];
  if (stops.length === 0) return;
  path(context, drone ? [drone, ...stops] : stops);
  context.lineJoin = "round";
  stroke(context, { colour: palette.planCase, width: 5 });
  stroke(context, { colour: palette.plan, width: 3, dash: [9, 5] });
  for (const [x, y] of stops) {
    context.beginPath();
    context.arc(x, y, 5, 0, 2 * Math.PI);
    context.fillStyle = palette.planCase;
    context.fill();
    stroke(context, { colour: palette.plan, width: 3 });
  }
}

/** Corner brackets: a whole frame would read as the edge of the lot. */
function drawFootprint({ context }: Surface, footprint: Pixel[]): void {
  if (footprint.length !== 4) return;
  context.beginPath();
  footprint.forEach((corner, index) => {
    const before = footprint[(index + 3) % 4] ?? corner;
    const after = footprint[(index + 1) % 4] ?? corner;
    context.moveTo(...toward(corner, before, 22));
    context.lineTo(...corner);
    context.lineTo(...toward(corner, after, 22));
  });
  context.lineJoin = "miter";
  stroke(context, { colour: DARK, width: 6 });
  stroke(context, { colour: "#fff", width: 3 });
}

function toward(from: Pixel, to: Pixel, pixels: number): Pixel {
  const [dx, dy] = [to[0] - from[0], to[1] - from[1]];
  const share = Math.min(0.4, pixels / Math.max(1, Math.hypot(dx, dy)));
  return [from[0] + dx * share, from[1] + dy * share];
}

function drawFramed({ context }: Surface, ring: Pixel[], width: number): void {
  path(context, ring, true);
  context.lineJoin = "round";
  stroke(context, { colour: DARK, width: width + 3 });
  stroke(context, { colour: "#fff", width });
}

function drawHome({ context }: Surface, [x, y]: Pixel): void {
  context.beginPath();
  context.roundRect(x - 14, y - 14, 28, 28, 6);
  context.fillStyle = "#fff";
  context.fill();
  stroke(context, { colour: INK, width: 2 });
  path(context, [
    [x - 8, y],
    [x, y - 8],
    [x + 8, y],
  ]);
  context.moveTo(x - 5.5, y - 1);
  context.lineTo(x - 5.5, y + 7);
  context.lineTo(x + 5.5, y + 7);
  context.lineTo(x + 5.5, y - 1);
  context.lineJoin = context.lineCap = "round";
  stroke(context, { colour: INK, width: 2 });
  context.lineCap = "butt";
}

function drawPlanned(surface: Surface, scene: Scene, drone: DroneMark): void {
  const { context, palette, pixel } = surface;
  if (!scene.planned) return;
  const [north, east] = [scene.planned.North - drone.north, scene.planned.East - drone.east];
  if (scene.footprint.length === 4) {
    path(context, scene.footprint.map((corner) => pixel([corner.East + east, corner.North + north])), true);
    context.globalAlpha = 0.12;
    context.fillStyle = palette.plan;
    context.fill();
    context.globalAlpha = 1;
    stroke(context, { colour: palette.plan, width: 2, dash: [4, 4] });
  }
  const target = pixel(toCoordinate(scene.planned));
  const points = plannedPath(scene, drone);
  path(context, points.map((place) => pixel(toCoordinate(place))));
  context.lineJoin = "round";
  stroke(context, { colour: palette.planCase, width: 6 });
  stroke(context, { colour: palette.plan, width: 3.5, dash: [10, 5] });
  context.beginPath();
  context.arc(...target, 12, 0, 2 * Math.PI);
  context.fillStyle = palette.planCase;
  context.fill();
  stroke(context, { colour: palette.plan, width: 4 });
  context.beginPath();
  context.arc(...target, 4, 0, 2 * Math.PI);
  context.fillStyle = palette.plan;
  context.fill();
}

/** From the drone over the waypoints, where there are any, to the place that is asked about. */
export function plannedPath(scene: Scene, drone: DroneMark): Point[] {
  const last = scene.plannedRoute.at(-1);
  const end = scene.planned;
  const ends = end === null || (last && Math.hypot(last.North - end.North, last.East - end.East) < SAME_PLACE_M);
  return [{ North: drone.north, East: drone.east }, ...scene.plannedRoute, ...(ends ? [] : [end])];
}

const ARROW: readonly Pixel[] = [
  [0, -11],
  [8, 9],
  [0, 4.5],
  [-8, 9],
];

function drawDrone(surface: Surface, [x, y]: Pixel, yaw: number, reach: number | null): void {
  const { context, resolution, rotation } = surface;
  if (reach !== null) drawReach(context, [x, y], Math.max(26, reach / resolution));
  context.beginPath();
  context.arc(x, y, 19, 0, 2 * Math.PI);
  context.fillStyle = reach === null ? DARK : "rgba(74,87,99,.75)";
  context.fill();
  stroke(context, reach === null ? { colour: "#fff", width: 3 } : { colour: "#fff", width: 3, dash: [6, 4] });
  context.save();
  context.translate(x, y);
  context.rotate(yaw + rotation);
  path(context, ARROW, true);
  context.lineJoin = "round";
  if (reach === null) {
    context.fillStyle = "#fff";
    context.fill();
  } else {
    stroke(context, { colour: "#fff", width: 2 });
  }
  context.restore();
}

function drawReach(context: CanvasRenderingContext2D, [x, y]: Pixel, radius: number): void {
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.fillStyle = "rgba(16,22,28,.22)";
  context.fill();
  stroke(context, { colour: DARK, width: 3.5 });
  stroke(context, { colour: "#fff", width: 2.5, dash: [8, 6] });
}
