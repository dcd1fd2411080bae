import "./dom.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { FenceDraft } from "../src/fence/draft.ts";
import { FenceFileError, readFence, writeFence } from "../src/fence/geojson.ts";
import { LocalPlane } from "../src/fence/plane.ts";
import { drawScene } from "../src/map/draw-scene.ts";
import { draftFence, shownFence } from "../src/map/fence-shown.ts";
import { EMPTY_SCENE } from "../src/map/flight-scene.ts";
import type { Surface } from "../src/map/surface.ts";
import type { Command, FenceCheck, FenceCorner, FenceSetup } from "../src/protocol.ts";
import { FenceEditing } from "../src/state/fence-edit.ts";
import { CELL } from "../src/state/tile-data.ts";
import { FenceTools } from "../src/ui/fence-tools.ts";
import { fenceSummary, fenceWords } from "../src/words/fence.ts";
import { consequence, planMove } from "../src/words/move.ts";
import { FakeTimers, settle } from "./fakes.ts";
import { heartbeat, possible, view } from "./make.ts";
import { flying } from "./rig.ts";
import { Stage } from "./stage.ts";

const PLANE = new LocalPlane({ Latitude: 43.2609, Longitude: -79.9192 });
const SQUARE = ring([-50, -50], [50, -50], [50, 50], [-50, 50]);
const ROOF = ring([-10, -10], [10, -10], [10, 10], [-10, 10]);
const MAST = ring([30, 30], [34, 30], [32, 34]);

function ring(...places: [number, number][]): FenceCorner[] {
  return places.map(([North, East]) => PLANE.toEarth({ North, East }));
}

const SETUP: FenceSetup = {
  Source: "drawn",
  Corners: SQUARE,
  Zones: [ROOF, MAST],
  Inner: SQUARE,
  "Inner Zones": [ring([-15, -15], [15, -15], [15, 15], [-15, 15]), MAST],
  Radius: null,
  Ceiling: 80,
  Margin: 5,
  "Ceiling Margin": 3,
  "Highest Ceiling": 100,
  Problem: "",
};
const CHECK: FenceCheck = {
  Type: "Fence Check",
  Id: "x",
  Problem: "",
  Notes: [],
  Inner: SQUARE,
  "Inner Zones": SETUP["Inner Zones"],
  "North South": 100,
  "East West": 80,
  Area: 7600,
};
const READY = view({ heartbeat: heartbeat({ State: "Idle", Options: possible("Set Fence") }) });

function editing(): { fence: FenceEditing; sent: Command[]; answer: () => Promise<void> } {
  const timers = new FakeTimers();
  const sent: Command[] = [];
  const send = (command: Command): Promise<never> => {
    sent.push(command);
    return Promise.resolve(CHECK as never);
  };
  const fence = new FenceEditing({ send, changed: () => undefined, showToast: () => undefined, timers });
  const answer = async (): Promise<void> => {
    timers.advance(200);
    await settle();
  };
  return { fence, sent, answer };
}

describe("a fence file with zones", () => {
  it("is read as it was written: interior rings, closed and clockwise", () => {
    const text = writeFence({ corners: SQUARE, zones: [ROOF, ROOF.toReversed()], ceiling: 75 });
    const { coordinates } = (JSON.parse(text) as { geometry: { coordinates: [number, number][][] } }).geometry;
    assert.equal(coordinates.length, 3);
    for (const [index, positions] of coordinates.entries()) {
      assert.deepEqual(positions.at(0), positions.at(-1));
      const sum = positions.slice(1).reduce((all, [x, y], at) => all + (x - positions[at]![0]) * (y + positions[at]![1]), 0);
      assert.equal(sum < 0, index === 0);
    }
    const { zones } = readFence(text);
    assert.deepEqual(zones.map((zone) => new Set(zone.map((corner) => corner.Latitude))), [ROOF, ROOF].map((zone) => new Set(zone.map((corner) => corner.Latitude))));
  });

  const outer = [[0, 0], [9, 0], [9, 9], [0, 0]];
  const inner = [[4, 2], [5, 2], [5, 3], [4, 2]];
  const feature = (coordinates: unknown, properties: unknown = null): unknown => ({ type: "Feature", properties, geometry: { type: "Polygon", coordinates } });
  const zone = feature([inner], { exclusion: true });

  it("may hold zones as interior rings and as polygons of their own", () => {
    const content = { type: "FeatureCollection", features: [zone, feature([outer, inner], { ceiling_m: 60 }), zone] };
    const read = readFence(JSON.stringify(content));
    assert.deepEqual([read.corners.length, read.zones.length, read.ceiling], [3, 3, 60]);
    assert.deepEqual(read.zones[0]![0], { Latitude: 2, Longitude: 4 });
  });

  it("that is wrong is reported in words", () => {
    const wrong: [unknown, RegExp][] = [
      [{ features: [feature([outer]), feature([inner])] }, /exactly one polygon/],
      [{ features: [feature([outer]), feature([inner], { exclusion: "yes" })] }, /exactly one polygon/],
      [{ features: [zone] }, /exactly one polygon/],
      [{ features: [feature([outer]), feature([inner, inner], { exclusion: true })] }, /one ring without holes/],
      [feature([outer, [[0, 0], [1, 1], [0, 0]]]), /Zone 1 has 2 corners/],
      [feature([outer, inner, [[0, 0], [1, 99], [2, 2]]]), /Zone 2: corner 2 is no place on Earth/],
      [feature([outer, "none"]), /no ring of corners/],
    ];
    for (const [content, words] of wrong) {
      assert.throws(() => readFence(JSON.stringify(content)), (error) => error instanceof FenceFileError && words.test(error.message), JSON.stringify(content));
    }
  });
});

describe("a draft with zones", () => {
  it("takes back change by change, and without a fence it has no zones", () => {
    const draft = new FenceDraft(SQUARE, 80, [ROOF]);
    assert.equal(draft.isChanged, false);
    draft.draw(SQUARE, draft.ceiling, [ROOF, MAST]);
    assert.equal(draft.isChanged, true);
    draft.draw(SQUARE.slice(1));
    assert.equal(draft.zones.length, 2, "a corner of the fence that goes takes no zone with it");
    draft.draw([]);
    assert.deepEqual(draft.zones, []);
    draft.undo();
    draft.undo();
    draft.undo();
    assert.deepEqual([draft.zones, draft.isChanged], [[ROOF], false]);
  });
});

describe("the fence editor with zones", () => {
  it("begins with those that are kept, asks about them and saves them", async () => {
    const { fence, sent, answer } = editing();
    fence.begin(SETUP);
    await answer();
    await fence.save();
    assert.deepEqual(sent.map((command) => command.Type), ["Check Fence", "Set Fence"]);
    for (const command of sent) assert.deepEqual("Zones" in command && command.Zones, [ROOF, MAST]);
  });

  it("draws a zone only in a fence, and is done with it when it is closed or given up", () => {
    const { fence } = editing();
    fence.begin({ ...SETUP, Source: "circle", Corners: [], Zones: [] });
    fence.zone(true);
    assert.equal(fence.zoning, false);
    fence.draw(SQUARE);
    fence.remove(true);
    fence.zone(true);
    assert.deepEqual([fence.zoning, fence.removing], [true, false]);
    fence.zone(false);
    fence.zone(true);
    fence.draw(SQUARE, undefined, [ROOF]);
    assert.deepEqual([fence.zoning, fence.draft?.zones], [false, [ROOF]]);
    fence.zone(true);
    fence.undo();
    assert.deepEqual([fence.zoning, fence.draft?.zones], [false, []]);
  });

  it("takes zones from a file and gives them to one", () => {
    const { fence } = editing();
    fence.begin({ ...SETUP, Zones: [] });
    fence.import(writeFence({ corners: SQUARE, zones: [ROOF], ceiling: 70 }));
    assert.equal(fence.draft?.zones.length, 1);
    assert.equal(readFence(fence.export() ?? "").zones.length, 1);
    fence.import(writeFence({ corners: SQUARE, zones: [], ceiling: 70 }));
    assert.deepEqual(fence.draft.zones, [], "the file's zones, not those that were there");
  });

  it("leads through it in words", async () => {
    const { fence, answer } = editing();
    fence.begin(SETUP);
    await answer();
    assert.equal(fenceWords(fence, SETUP, READY, false).title, "Fence 80 × 100 m, 4 corners, 2 zones");
    fence.remove(true);
    assert.match(fenceWords(fence, SETUP, READY, true).line, /^Tap the corners that are to go, or into a zone/);
    fence.zone(true);
    const begun = fenceWords(fence, SETUP, READY, false);
    assert.match(begun.title, /^Draw a zone/);
    assert.equal(begun.reason, "Zone not closed yet", "a zone that is half drawn is not saved without it");
    fence.drawing(2);
    assert.match(fenceWords(fence, SETUP, READY, false).line, /A zone needs at least 3/);
    assert.equal(fenceSummary(SETUP, "metres").title, "Fence of 4 corners, 2 zones");
    assert.equal(fenceSummary({ ...SETUP, Zones: [ROOF] }, "metres").title, "Fence of 4 corners, 1 zone");
  });

  it("has a tool for it, which is on while a zone is drawn", async () => {
    const rig = flying({ State: "Idle", Armed: false, Landed: "ON_GROUND", "Fence Setup": { ...SETUP, Corners: [], Zones: [] }, Options: possible("Set Fence") });
    const stage = new Stage(new FenceTools(), rig.operator);
    const asked: unknown[] = [];
    stage.part.addEventListener("fence-tool", (event) => asked.push((event as CustomEvent).detail));
    rig.operator.editFence();
    await stage.drawn();
    assert.equal(stage.button("Add zone: an exclusion zone").disabled, true);
    rig.operator.fence.draw(SQUARE);
    await stage.drawn();
    await stage.press("Add zone: an exclusion zone");
    assert.equal(stage.button("Add zone: an exclusion zone").getAttribute("aria-pressed"), "true");
    await stage.press("Square");
    rig.operator.fence.drawing(3);
    await stage.drawn();
    await stage.press("Undo");
    await stage.press("Close the ring");
    assert.deepEqual(asked, ["square", "back", "close"]);
    await stage.press("Add zone: an exclusion zone");
    assert.deepEqual([rig.operator.fence.zoning, rig.operator.fence.begun], [false, 0]);
  });
});

describe("zones on the map", () => {
  const near = (a: number | undefined, b: number): boolean => Math.abs((a ?? Infinity) - b) < 0.01;
  const inForce = [{ North: 1, East: 1 }, { North: 9, East: 1 }, { North: 9, East: 9 }];

  it("are those in force in the air, the planned ones on the ground, and the drone's answer while drawing", () => {
    const reported = { "Fence Zones": [inForce], "Fence Zone Limits": [inForce, inForce] };
    const flown = shownFence(heartbeat({ State: "Hover", ...reported }), SETUP, PLANE);
    assert.deepEqual([flown.zones, flown.zoneLimits], [[inForce], [inForce, inForce]]);
    const idle = shownFence(heartbeat({ State: "Idle", ...reported }), SETUP, PLANE);
    assert.ok(near(idle.zoneLimits[0]?.[0]?.North, -10) && near(idle.zones[0]?.[0]?.North, -15));
    const drawn = draftFence(CHECK, PLANE);
    assert.deepEqual([drawn.zones.length, drawn.zoneLimits], [2, []], "the editor shows the zones itself");
  });

  it("are hatched over all of them, in another colour than the fence", () => {
    const lines: { colour: string; pixels: number[][] }[] = [];
    let pixels: number[][] = [];
    let clipped = 0;
    const calls: Record<string, unknown> = {
      canvas: { width: 200, height: 100 },
      beginPath: () => (pixels = []),
      moveTo: (x: number, y: number) => pixels.push([x, y]),
      lineTo: (x: number, y: number) => pixels.push([x, y]),
      clip: () => (clipped += 1),
      stroke: () => lines.push({ colour: String(calls.strokeStyle), pixels: [...pixels] }),
    };
    const context = new Proxy(calls, { get: (kept, name) => kept[String(name)] ?? (() => undefined) }) as unknown as CanvasRenderingContext2D;
    const palette = { fog: "", grid: "", fence: "fence", zone: "zone", plan: "", planCase: "case", asphalt: "", ground: "", veil: "", begins: "#0a6a4c", ends: "#a31d17", confirmed: "" };
    const surface: Surface = { context, palette, resolution: 1, rotation: 0, pixel: ([east, north]) => [east, 100 - north] };
    const corners = [[20, 20], [60, 20], [60, 80], [20, 80]].map(([North, East]) => ({ North: North!, East: East! }));
    const huge = [[-9e6, -9e6], [9e6, -9e6], [9e6, 9e6], [-9e6, 9e6]].map(([North, East]) => ({ North: North!, East: East! }));
    drawScene(surface, { ...EMPTY_SCENE, zoneLimits: [corners], zones: [corners] });
    const [hatching] = lines.filter((line) => line.colour === "zone");
    assert.equal(clipped, 1);
    assert.ok(hatching && hatching.pixels.length > 12);
    const sums = hatching.pixels.map(([x, y]) => x! + y!);
    assert.ok(Math.min(...sums) <= 20 + 40 && Math.max(...sums) >= 80 + 80 - 12, "from one corner to the other");
    assert.ok(lines.some((line) => line.colour === "fence"), "our line around it is dotted like the fence's");
    const before = lines.length;
    drawScene(surface, { ...EMPTY_SCENE, zoneLimits: [huge] });
    assert.ok((lines[before]?.pixels.length ?? Infinity) < 100, "only what is on the map");
  });
});

describe("a move and zones", () => {
  const able = heartbeat({ Options: possible("Autonomous Move", "Compulsive Move"), "Fence Zones": [[[-5, 10], [5, 10], [5, 20], [-5, 20]].map(([North, East]) => ({ North: North!, East: East! }))] });

  it("into one is not offered, and straight across one only over the lot", () => {
    const into = planMove(view({ heartbeat: able }), { North: 0, East: 15 }, CELL.lot)!;
    assert.deepEqual([into.insideFence, into.choices.map((choice) => choice.possible)], [false, [false, false]]);
    assert.match(consequence(view({ heartbeat: able }), into, "Compulsive Move"), /In a zone or its margin\. Choose a place .* out of zones/);
    const across = planMove(view({ heartbeat: able }), { North: 0, East: 30 }, CELL.lot)!;
    assert.deepEqual(across.choices.map((choice) => choice.possible), [true, false]);
    assert.equal(across.choices[1]?.reason, "The straight path there crosses a zone");
    const beside = planMove(view({ heartbeat: able }), { North: 20, East: 30 }, CELL.lot)!;
    assert.deepEqual(beside.choices.map((choice) => choice.possible), [true, true]);
  });
});
