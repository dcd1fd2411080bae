import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { drawScene, plannedWay, type Surface } from "../src/map/draw-scene.ts";
import { EMPTY_SCENE, type Scene } from "../src/map/flight-scene.ts";
import { type RouteAnswer, RoutePlan, routePoints } from "../src/state/route-plan.ts";

const TARGET = { North: 20, East: 10 };
const WAY: [number, number][] = [
  [0, 10],
  [20, 10],
];

function answer(id: string, changes: Partial<RouteAnswer> = {}): RouteAnswer {
  return { kind: "route", id, points: WAY, length_m: 30, refused: null, ...changes };
}

describe("the way to a place that is asked about", () => {
  it("is the answer to the last question only", () => {
    const plan = new RoutePlan();
    const first = plan.ask({ North: 1, East: 2 });
    const second = plan.ask(TARGET);
    assert.deepEqual(second.target, [20, 10]);
    assert.equal(plan.take(answer(first.id)), false);
    assert.deepEqual([plan.state, plan.points], ["asking", []]);
    assert.equal(plan.take(answer(second.id)), true);
    assert.deepEqual([plan.state, plan.points, plan.metres], ["known", routePoints(WAY), 30]);
    plan.clear();
    assert.deepEqual([plan.state, plan.points], ["none", []]);
    assert.equal(plan.take(answer(second.id)), false);
  });

  it("may be refused, with the reason; what is no way is none", () => {
    for (const [changes, reason] of [
      [{ refused: "No way inside the lot." }, "No way inside the lot."],
      [{ points: [] }, "There is no way there."],
      [{ points: [[Number.NaN, 1]] as [number, number][] }, "There is no way there."],
    ] as const) {
      const plan = new RoutePlan();
      const { id } = plan.ask(TARGET);
      plan.take(answer(id, changes as Partial<RouteAnswer>));
      assert.deepEqual([plan.state, plan.reason, plan.points], ["refused", reason, []]);
    }
  });
});

/** Keeps the lines that are drawn: colour and pixels. */
function surface(): { surface: Surface; lines: { colour: string; pixels: number[][] }[] } {
  const lines: { colour: string; pixels: number[][] }[] = [];
  let pixels: number[][] = [];
  const calls: Record<string, unknown> = {
    beginPath: () => (pixels = []),
    moveTo: (x: number, y: number) => pixels.push([x, y]),
    lineTo: (x: number, y: number) => pixels.push([x, y]),
    stroke: () => lines.push({ colour: String(calls.strokeStyle), pixels: [...pixels] }),
  };
  const context = new Proxy(calls, {
    get: (kept, name) => kept[String(name)] ?? (() => undefined),
  }) as unknown as CanvasRenderingContext2D;
  const palette = { fog: "", grid: "", fence: "fence", plan: "plan", planCase: "case", asphalt: "", ground: "", veil: "" };
  return { surface: { context, palette, resolution: 1, pixel: ([east, north]) => [east, -north] }, lines };
}

function scene(changes: Partial<Scene>): Scene {
  return { ...EMPTY_SCENE, drone: { north: 0, east: 0, yaw: 0 }, ...changes };
}

describe("the way on the map", () => {
  const bent = [
    [0, -0],
    [10, -0],
    [10, -20],
  ];

  it("goes over its way points before the move, and straight where there are none", () => {
    const planned = scene({ planned: TARGET, plannedRoute: routePoints(WAY) });
    assert.deepEqual(plannedWay(planned, planned.drone!).map((place) => place.North), [0, 0, 20]);
    const straight = scene({ planned: TARGET });
    assert.equal(plannedWay(straight, straight.drone!).length, 2);
    const short = scene({ planned: TARGET, plannedRoute: routePoints(WAY.slice(0, 1)) });
    assert.deepEqual(plannedWay(short, short.drone!).at(-1), TARGET);
    const { surface: canvas, lines } = surface();
    drawScene(canvas, planned);
    assert.deepEqual(lines.find((line) => line.colour === "plan")?.pixels, bent);
  });

  it("goes over its way points during the move", () => {
    const { surface: canvas, lines } = surface();
    drawScene(canvas, scene({ route: routePoints(WAY), target: TARGET }));
    assert.deepEqual(lines.find((line) => line.colour === "plan")?.pixels, bent);
  });

  it("does not show what is flown while another place is asked about", () => {
    const { surface: canvas, lines } = surface();
    drawScene(canvas, scene({ route: [{ North: -99, East: 0 }], planned: TARGET }));
    assert.ok(lines.every((line) => line.pixels.every(([, y]) => y !== 99)));
  });

  it("has the autopilot's line around ours", () => {
    const { surface: canvas, lines } = surface();
    const limit = routePoints([[0, 0], [9, 0], [9, 9]]);
    drawScene(canvas, scene({ limit, fence: routePoints([[2, 1], [8, 1], [8, 7]]) }));
    assert.deepEqual(lines.filter((line) => line.colour === "fence").map((line) => line.pixels[0]), [[0, -0], [1, -2]]);
  });
});
