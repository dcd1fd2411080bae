import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { drawScene, plannedPath } from "../src/map/draw-scene.ts";
import { EMPTY_SCENE, type Scene } from "../src/map/flight-scene.ts";
import type { Surface } from "../src/map/surface.ts";
import type { Command, Point, RouteAnswer } from "../src/protocol.ts";
import { RoutePlan } from "../src/state/route-plan.ts";
import { settle } from "./fakes.ts";
import { possible } from "./make.ts";
import { flying } from "./rig.ts";

const TARGET = { North: 20, East: 10 };
const ROUTE: Point[] = [
  { North: 0, East: 10 },
  { North: 20, East: 10 },
];

function answer(changes: Partial<RouteAnswer> = {}): RouteAnswer {
  return { Type: "Route", Id: "r", Points: ROUTE, Length: 30, Refused: null, ...changes };
}

function asking(): { plan: RoutePlan; sent: Command[]; reply: (answer: unknown) => Promise<void> } {
  const sent: Command[] = [];
  const waiting: ((answer: never) => void)[] = [];
  const send = (command: Command): Promise<never> => {
    sent.push(command);
    return new Promise((resolve) => waiting.push(resolve));
  };
  const reply = async (given: unknown): Promise<void> => {
    waiting.shift()?.(given as never);
    await settle();
  };
  return { plan: new RoutePlan(send, () => undefined), sent, reply };
}

describe("the route to a place that is asked about", () => {
  it("is the answer to the last question only", async () => {
    const { plan, sent, reply } = asking();
    void plan.ask({ North: 1, East: 2 });
    void plan.ask(TARGET);
    assert.deepEqual(sent.at(-1), { Type: "Route Request", X: 20, Y: 10, Frame: "Map" });
    await reply(answer());
    assert.deepEqual([plan.state, plan.points], ["asking", []]);
    await reply(answer());
    assert.deepEqual([plan.state, plan.points, plan.metres], ["known", ROUTE, 30]);
    void plan.ask(TARGET);
    plan.clear();
    await reply(answer());
    assert.deepEqual([plan.state, plan.points], ["none", []]);
  });

  it("may be refused, with the reason", async () => {
    for (const [given, reason] of [
      [answer({ Points: [], Refused: "No route inside the lot." }), "No route inside the lot."],
      [answer({ Points: [] }), "There is no route there."],
      [{ Type: "Ack", Accepted: false, Reason: "No link." }, "No link."],
    ] as const) {
      const { plan, reply } = asking();
      void plan.ask(TARGET);
      await reply(given);
      assert.deepEqual([plan.state, plan.reason, plan.points], ["refused", reason, []]);
    }
  });

  it("is asked for with the question, where the lot can be flown over, and forgotten with it", async () => {
    const rig = flying({ Options: possible("Autonomous Move", "Compulsive Move") });
    rig.operator.ask({ about: "move", target: TARGET });
    const { Type, Id } = rig.sent().at(-1)!;
    assert.equal(Type, "Route Request");
    rig.server.last.say({ ...answer(), Id });
    await settle();
    assert.deepEqual(rig.operator.routePlan.points, ROUTE);
    rig.operator.choose("Compulsive Move");
    assert.deepEqual(rig.operator.question, { about: "move", target: TARGET, kind: "Compulsive Move" });
    assert.equal(rig.operator.routePlan.state, "known");
    rig.operator.ask(null);
    assert.equal(rig.operator.routePlan.state, "none");
    const blind = flying({ Options: possible("Compulsive Move") });
    blind.operator.ask({ about: "move", target: TARGET });
    assert.deepEqual(blind.sent(), []);
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
  const palette = { fog: "", grid: "", fence: "fence", zone: "zone", plan: "plan", planCase: "case", asphalt: "", ground: "", veil: "", begins: "#0a6a4c", ends: "#a31d17", confirmed: "" };
  return { surface: { context, palette, resolution: 1, rotation: 0, pixel: ([east, north]) => [east, -north] }, lines };
}

function scene(changes: Partial<Scene>): Scene {
  return { ...EMPTY_SCENE, drone: { north: 0, east: 0, yaw: 0 }, ...changes };
}

describe("the route on the map", () => {
  const bent = [
    [0, -0],
    [10, -0],
    [10, -20],
  ];

  it("goes over its waypoints before the move, and straight where there are none", () => {
    const planned = scene({ planned: TARGET, plannedRoute: ROUTE });
    assert.deepEqual(plannedPath(planned, planned.drone!).map((place) => place.North), [0, 0, 20]);
    const straight = scene({ planned: TARGET });
    assert.equal(plannedPath(straight, straight.drone!).length, 2);
    const short = scene({ planned: TARGET, plannedRoute: ROUTE.slice(0, 1) });
    assert.deepEqual(plannedPath(short, short.drone!).at(-1), TARGET);
    const { surface: canvas, lines } = surface();
    drawScene(canvas, planned);
    assert.deepEqual(lines.find((line) => line.colour === "plan")?.pixels, bent);
  });

  it("goes over its waypoints during the move", () => {
    const { surface: canvas, lines } = surface();
    drawScene(canvas, scene({ route: ROUTE, target: TARGET }));
    assert.deepEqual(lines.find((line) => line.colour === "plan")?.pixels, bent);
  });

  it("does not show what is flown while another place is asked about", () => {
    const { surface: canvas, lines } = surface();
    drawScene(canvas, scene({ route: [{ North: -99, East: 0 }], planned: TARGET }));
    assert.ok(lines.every((line) => line.pixels.every(([, y]) => y !== 99)));
  });

  it("has the autopilot's line around ours", () => {
    const { surface: canvas, lines } = surface();
    const places = (...pairs: [number, number][]): Point[] => pairs.map(([North, East]) => ({ North, East }));
    drawScene(canvas, scene({ limit: places([0, 0], [9, 0], [9, 9]), fence: places([2, 1], [8, 1], [8, 7]) }));
    assert.deepEqual(lines.filter((line) => line.colour === "fence").map((line) => line.pixels[0]), [[0, -0], [1, -2]]);
  });
});
