import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { FenceDraft } from "../src/fence/draft.ts";
import { FenceFileError, readFence, writeFence } from "../src/fence/geojson.ts";
import { LocalPlane } from "../src/fence/plane.ts";
import { dronePlace, draftFence, shownFence } from "../src/map/fence-shown.ts";
import type { Command, FenceCheck, FenceCorner, FenceSetup } from "../src/protocol.ts";
import { FenceEditing, type FenceHooks } from "../src/state/fence-edit.ts";
import { Operator } from "../src/state/operator.ts";
import { cannot } from "../src/words/actions.ts";
import { fenceSummary, fenceWords } from "../src/words/fence.ts";
import { FakeServer, FakeStorage, FakeTimers, settle } from "./fakes.ts";
import { heartbeat, impossible, possible, view, welcome } from "./make.ts";

const ORIGIN = { Latitude: 43.2609, Longitude: -79.9192 };
const PLANE = new LocalPlane(ORIGIN);
const SQUARE = ring([-50, -50], [50, -50], [50, 50], [-50, 50]);

function ring(...places: [number, number][]): FenceCorner[] {
  return places.map(([North, East]) => PLANE.toEarth({ North, East }));
}

function setup(changes: Partial<FenceSetup> = {}): FenceSetup {
  return {
    Source: "drawn",
    Corners: SQUARE,
    Zones: [],
    Inner: ring([-45, -45], [45, -45], [45, 45], [-45, 45]),
    "Inner Zones": [],
    Radius: null,
    Ceiling: 80,
    Margin: 5,
    "Ceiling Margin": 3,
    "Highest Ceiling": 100,
    Problem: "",
    ...changes,
  };
}

const CIRCLE = setup({ Source: "circle", Corners: [], Inner: [], Radius: 150, Ceiling: 100 });

function check(changes: Partial<FenceCheck> = {}): FenceCheck {
  return {
    Type: "Fence Check",
    Id: "x",
    Problem: "",
    Notes: [],
    Inner: setup().Inner,
    "Inner Zones": [],
    "North South": 100,
    "East West": 80,
    Area: 8000,
    ...changes,
  };
}

describe("the tangent plane", () => {
  // Latitude and longitude of the origin, north, east, latitude and longitude: computed by pymap3d.ned2geodetic.
  const REFERENCE = [
    [43.2609, -79.9192, 120.0, -80.0, 43.2619801248, -79.9201852983],
    [43.2609, -79.9192, -1500.0, 1900.0, 43.2473959761, -79.8958047475],
    [-33.9, 151.2, 120.0, -80.0, -33.8989181417, 151.1991350797],
    [-33.9, 151.2, -1500.0, 1900.0, -33.9135214615, 151.2205453608],
    [0.0, 0.0, 120.0, -80.0, 0.0010852434, -0.0007186522],
    [0.0, 0.0, -1500.0, 1900.0, -0.0135655423, 0.0170679911],
    [64.1, -21.9, 120.0, -80.0, 64.1010764277, -21.9016408604],
    [64.1, -21.9, -1500.0, 1900.0, 64.0865393137, -21.8610498876],
  ] as const;

  it("agrees with the drone's own to a millimetre, in both directions", () => {
    for (const [latitude, longitude, North, East, there, beside] of REFERENCE) {
      const plane = new LocalPlane({ Latitude: latitude, Longitude: longitude });
      const corner = plane.toEarth({ North, East });
      assert.ok(Math.abs(corner.Latitude - there) < 1e-8, `${corner.Latitude} ${there}`);
      assert.ok(Math.abs(corner.Longitude - beside) < 2e-8, `${corner.Longitude} ${beside}`);
      const back = plane.toMap({ Latitude: there, Longitude: beside });
      assert.ok(Math.hypot(back.North - North, back.East - East) < 0.4, JSON.stringify(back));
      const again = plane.toMap(corner);
      assert.ok(Math.hypot(again.North - North, again.East - East) < 0.001, JSON.stringify(again));
    }
  });
});

describe("a fence file", () => {
  it("is read as it was written, closed and counterclockwise", () => {
    for (const corners of [SQUARE, SQUARE.toReversed()]) {
      const text = writeFence({ corners, zones: [], ceiling: 75 });
      const [outer] = (JSON.parse(text) as { geometry: { coordinates: [number, number][][] } }).geometry.coordinates;
      assert.deepEqual(outer?.at(0), outer?.at(-1));
      const sum = outer!.slice(1).reduce((all, [x, y], index) => all + (x - outer![index]![0]) * (y + outer![index]![1]), 0);
      assert.ok(sum < 0);
      const { corners: read, ceiling } = readFence(text);
      assert.equal(ceiling, 75);
      assert.deepEqual(new Set(read.map((corner) => corner.Latitude)), new Set(corners.map((corner) => corner.Latitude)));
    }
  });

  const polygon = { type: "Polygon", coordinates: [[[0, 0], [1, 0], [1, 1], [0, 0]]] };

  it("may be a geometry, a feature or a collection of one", () => {
    const feature = { type: "Feature", properties: null, geometry: polygon };
    for (const content of [polygon, feature, { type: "FeatureCollection", features: [feature] }]) {
      assert.equal(readFence(JSON.stringify(content)).corners.length, 3);
      assert.equal(readFence(JSON.stringify(content)).ceiling, null);
    }
  });

  it("that holds none is reported in words", () => {
    const wrong: [unknown, RegExp][] = [
      ["{", /not GeoJSON/],
      [[], /exactly one polygon/],
      [{ type: "Point", coordinates: [0, 0] }, /exactly one polygon/],
      [{ features: [polygon, polygon] }, /exactly one polygon/],
      [{ features: [] }, /exactly one polygon/],
      [{ type: "Polygon" }, /no ring of corners/],
      [{ type: "Polygon", coordinates: [[[0, 0], [1, 1], [0, 0]]] }, /2 corners/],
      [{ type: "Polygon", coordinates: [[[0, 0], [1, 91], [0, 0]]] }, /corner 2 is no place on Earth/],
      [{ type: "Polygon", coordinates: [[["0", 0], [1, 1], [0, 0]]] }, /corner 1/],
      [{ type: "Polygon", coordinates: [[null, [1, 1], [0, 0]]] }, /corner 1/],
    ];
    for (const [content, words] of wrong) {
      const text = typeof content === "string" ? content : JSON.stringify(content);
      assert.throws(() => readFence(text), (error) => error instanceof FenceFileError && words.test(error.message), text);
    }
  });
});

describe("a draft", () => {
  it("takes back change by change, typing as one", () => {
    const draft = new FenceDraft([], 100);
    assert.equal(draft.isChanged, false);
    draft.draw(SQUARE);
    for (const typed of ["8", "80", "80,5"]) draft.typeCeiling(typed);
    assert.equal(draft.ceilingMetres, 80.5);
    draft.draw([]);
    draft.undo();
    assert.deepEqual([draft.corners, draft.ceiling], [SQUARE, "80,5"]);
    draft.undo();
    assert.equal(draft.ceiling, "100");
    draft.undo();
    assert.deepEqual([draft.corners, draft.canUndo, draft.isChanged], [[], false, false]);
    draft.undo();
    assert.deepEqual(draft.corners, []);
  });

  it("knows a ceiling only above 0", () => {
    const draft = new FenceDraft(SQUARE, 100);
    for (const typed of ["", "x", "0", "-3", "1e999"]) {
      draft.typeCeiling(typed);
      assert.equal(draft.ceilingMetres, null, typed);
    }
  });
});

function editing(): { fence: FenceEditing; timers: FakeTimers; sent: Command[]; toasts: string[]; answer: (answer: unknown) => Promise<void> } {
  const timers = new FakeTimers();
  const sent: Command[] = [];
  const toasts: string[] = [];
  const waiting: ((answer: never) => void)[] = [];
  const hooks: FenceHooks = {
    send: (command) => {
      sent.push(command);
      return new Promise((resolve) => waiting.push(resolve));
    },
    changed: () => undefined,
    showToast: (text) => toasts.push(text),
    timers,
  };
  const answer = async (given: unknown): Promise<void> => {
    waiting.shift()?.(given as never);
    await settle();
  };
  return { fence: new FenceEditing(hooks), timers, sent, toasts, answer };
}

describe("the fence editor", () => {
  it("asks once after a few quick changes, and says what the drone says", async () => {
    const { fence, timers, sent, answer } = editing();
    fence.begin(CIRCLE);
    timers.advance(1000);
    assert.deepEqual(sent, [], "nothing is drawn");
    fence.draw(SQUARE);
    fence.typeCeiling("80");
    assert.equal(fence.verdict.about, "asking");
    timers.advance(200);
    assert.deepEqual(sent, [{ Type: "Check Fence", Corners: SQUARE, Zones: [], Ceiling: 80 }]);
    await answer(check());
    assert.equal(fence.verdict.about, "good");
  });

  it("drops an answer about a drawing that has changed since", async () => {
    const { fence, timers, answer } = editing();
    fence.begin(setup());
    timers.advance(200);
    fence.draw(SQUARE.slice(1));
    await answer(check({ Problem: "Corners: old." }));
    assert.equal(fence.verdict.about, "asking");
    timers.advance(200);
    await answer(check({ Problem: "Corners: too narrow." }));
    assert.deepEqual(fence.verdict, { about: "problem", text: "Corners: too narrow." });
  });

  it("shows a refusal of the message itself, and an unusable ceiling without asking", async () => {
    const { fence, timers, sent, answer } = editing();
    fence.begin(setup());
    timers.advance(200);
    await answer({ Type: "Ack", Accepted: false, Reason: "Corners: a fence has 3 to 69 corners." });
    assert.deepEqual(fence.verdict, { about: "problem", text: "Corners: a fence has 3 to 69 corners." });
    fence.typeCeiling("high");
    timers.advance(200);
    assert.equal(fence.verdict.about, "problem");
    assert.equal(sent.length, 1);
  });

  it("saves, and closes only when the drone has kept it", async () => {
    const { fence, sent, toasts, answer } = editing();
    fence.begin(setup());
    fence.draw(SQUARE);
    void fence.save();
    await answer({ Type: "Ack", Accepted: false, Reason: "Flying: land first." });
    assert.deepEqual([fence.open, toasts], [true, ["Flying: land first."]]);
    void fence.save();
    await fence.save();
    await answer({ Type: "Ack", Accepted: true, Reason: "" });
    assert.deepEqual(sent.map((command) => command.Type), ["Set Fence", "Set Fence"], "not twice");
    fence.hear(heartbeat({ State: "Idle" }));
    fence.hear(heartbeat({ State: "Configure" }));
    assert.deepEqual([fence.open, fence.saving], [true, true]);
    fence.hear(heartbeat({ State: "Idle", "Fence Setup": setup() }));
    assert.deepEqual([fence.open, fence.draft, fence.saving], [false, null, false]);
    assert.match(toasts[1] ?? "", /saved/);
  });

  it("keeps what was drawn when the drone could not keep it", async () => {
    const { fence, toasts, answer } = editing();
    fence.begin(CIRCLE);
    fence.draw(SQUARE);
    void fence.save();
    await answer({ Type: "Ack", Accepted: true, Reason: "" });
    for (let beat = 0; beat < 4; beat += 1) fence.hear(heartbeat({ State: "Idle", Detail: "The fence was not saved." }));
    assert.deepEqual([fence.open, fence.saving, toasts], [true, false, ["The fence was not saved."]]);
    assert.deepEqual(fence.draft?.corners, SQUARE);
  });

  it("does not save what is no ring", async () => {
    const { fence, sent } = editing();
    fence.begin(CIRCLE);
    await fence.save();
    fence.draw(SQUARE.slice(2));
    await fence.save();
    assert.deepEqual(sent, []);
  });

  it("takes a file over, ceiling and all, and a bad one not at all", () => {
    const { fence, toasts } = editing();
    fence.begin(CIRCLE);
    assert.equal(fence.export(), null);
    assert.equal(fence.import("{"), false);
    assert.equal(toasts.length, 1);
    assert.deepEqual(fence.draft!.corners, []);
    assert.equal(fence.import(writeFence({ corners: SQUARE, zones: [], ceiling: 66 })), true);
    assert.equal(fence.draft!.ceiling, "66");
    assert.equal(readFence(fence.export() ?? "").corners.length, 4);
    fence.undo();
    assert.equal(fence.draft!.ceiling, "100");
  });

  it("keeps what was drawn when the drone is armed, and nothing when it is cancelled", () => {
    const { fence, toasts } = editing();
    fence.begin(CIRCLE);
    fence.draw(SQUARE);
    fence.pause("Only on the ground.");
    assert.equal(fence.open, false);
    assert.match(toasts[0] ?? "", /What was drawn is kept/);
    fence.pause("Only on the ground.");
    assert.equal(toasts.length, 1, "shown once");
    fence.begin(CIRCLE);
    assert.deepEqual(fence.draft!.corners, SQUARE);
    fence.cancel();
    fence.begin(CIRCLE);
    assert.deepEqual(fence.draft!.corners, []);
  });
});

describe("the operator and the fence", () => {
  function grounded(): { operator: Operator; server: FakeServer } {
    const timers = new FakeTimers();
    const server = new FakeServer();
    const outside = { commandUrl: "ws://drone/ws", open: server.open, timers, wallClock: () => 1_000_000, storage: new FakeStorage(), session: new FakeStorage() };
    const operator = new Operator(outside);
    operator.connect();
    server.last.accept();
    server.last.say(welcome());
    return { operator, server };
  }

  it("edits on the ground only, and the bar is free again when motors run", () => {
    const { operator, server } = grounded();
    operator.editFence();
    assert.equal(operator.fence.open, false, "no fence was received yet");
    server.last.say(heartbeat({ State: "Idle", Armed: false, "Fence Setup": setup() }));
    server.last.say(heartbeat({ State: "Idle", Armed: false }));
    operator.editFence();
    assert.equal(operator.fence.open, true);
    server.last.say(heartbeat({ State: "Configure", Armed: false }));
    assert.equal(operator.fence.open, true);
    for (const State of ["Arm", "Takeoff", "Hover", "Manual"]) {
      server.last.say(heartbeat({ State }));
      assert.equal(operator.fence.open, false);
      operator.editFence();
      assert.equal(operator.fence.open, false, State);
    }
  });

  it("centres the map on the drone before its first arm, then on the datum", () => {
    const { operator, server } = grounded();
    const before = { State: "Idle", Datum: null, North: null, East: null };
    server.last.say(heartbeat({ ...before, ...ORIGIN }));
    const plane = operator.flight.plane;
    server.last.say(heartbeat({ ...before, Latitude: ORIGIN.Latitude + 1e-5, Longitude: ORIGIN.Longitude }));
    assert.equal(operator.flight.plane, plane, "the drone's jitter does not move the map");
    server.last.say(heartbeat({ Datum: [43, -79] }));
    assert.deepEqual(operator.flight.plane?.origin, { Latitude: 43, Longitude: -79 });
  });
});

describe("the fence on the map", () => {
  const inForce = [{ North: 1, East: 1 }, { North: 9, East: 1 }, { North: 9, East: 9 }];
  const limit = [{ North: 0, East: 0 }, { North: 10, East: 0 }, { North: 10, East: 10 }];
  const near = (a: number | undefined, b: number): boolean => Math.abs((a ?? Infinity) - b) < 0.01;

  it("is the one in force in the air, and the next one on the ground", () => {
    const flying = shownFence(heartbeat({ State: "Hover", Fence: inForce, "Fence Limit": limit }), setup(), PLANE);
    assert.deepEqual(flying, { inner: inForce, limit, zones: [], zoneLimits: [] });
    const idle = shownFence(heartbeat({ State: "Idle", Fence: inForce, "Fence Limit": limit }), setup(), PLANE);
    assert.ok(near(idle.limit[0]?.North, -50) && near(idle.inner[0]?.North, -45));
    const bad = shownFence(heartbeat({ State: "Idle", Fence: inForce, "Fence Limit": limit }), setup({ Problem: "unreadable" }), PLANE);
    assert.deepEqual(bad.inner, inForce);
  });

  it("is a circle around the drone before its first arm", () => {
    const before = heartbeat({ State: "Idle", North: null, East: null, ...ORIGIN });
    const { inner, limit: outer } = shownFence(before, CIRCLE, PLANE);
    assert.ok(outer.every((place) => near(Math.hypot(place.North, place.East), 150)));
    assert.ok(inner.every((place) => near(Math.hypot(place.North, place.East), 145)));
    assert.deepEqual(shownFence(before, CIRCLE, null), { inner: [], limit: [], zones: [], zoneLimits: [] });
    assert.ok(near(dronePlace(before, PLANE)?.North, 0));
  });

  it("has our line as the drone answered it while it is drawn", () => {
    assert.ok(near(draftFence(check(), PLANE).inner[0]?.East, -45));
    assert.deepEqual(draftFence(null, PLANE).inner, []);
  });
});

describe("the words about the fence", () => {
  const ready = view({ heartbeat: heartbeat({ State: "Idle", Options: possible("Set Fence") }) });

  it("lead through drawing, in the words of the hand", () => {
    const { fence } = editing();
    fence.begin(CIRCLE);
    assert.match(fenceWords(fence, CIRCLE, ready, true).line, /^Tap its corners/);
    fence.drawing(2);
    assert.match(fenceWords(fence, CIRCLE, ready, false).line, /2 corners set. A fence needs at least 3/);
    fence.drawing(3);
    assert.match(fenceWords(fence, CIRCLE, ready, false).line, /Click the first one again, or Close/);
    assert.equal(fenceWords(fence, CIRCLE, ready, false).reason, "Not closed yet");
  });

  it("say what the fence would be, or what is wrong, or why it cannot be saved", async () => {
    const { fence, timers, answer } = editing();
    fence.begin(CIRCLE);
    fence.draw(SQUARE, "80");
    assert.equal(fenceWords(fence, CIRCLE, ready, false).line, "Being checked.");
    timers.advance(200);
    await answer(check());
    const good = fenceWords(fence, CIRCLE, ready, false);
    assert.deepEqual(good, {
      title: "Fence 80 × 100 m, 4 corners",
      line: "The drone stays 5 m inside it, at the dotted line, and below 77 m.",
      level: "",
      reason: "",
    });
    const other = view({ heartbeat: heartbeat({ "In Control": false, Options: possible("Set Fence") }) });
    assert.equal(fenceWords(fence, CIRCLE, other, false).reason, "Not in control");
    const flying = view({ heartbeat: heartbeat({ Options: [impossible("Set Fence", "Flying: land first.")] }) });
    assert.equal(fenceWords(fence, CIRCLE, flying, false).reason, "Flying: land first");
    const lost = view({ silence: 9 });
    assert.match(fenceWords(fence, CIRCLE, lost, false).line, /No link/);
    assert.equal(cannot(lost, "Set Fence"), "No link");
    fence.draw(SQUARE.toReversed());
    timers.advance(200);
    await answer(check({ Notes: ["The drone stands 9 m outside."] }));
    assert.deepEqual([fenceWords(fence, CIRCLE, ready, false).line, fenceWords(fence, CIRCLE, ready, false).level], ["The drone stands 9 m outside.", "warning"]);
    fence.remove(true);
    assert.match(fenceWords(fence, CIRCLE, ready, true).line, /^Tap the corners that are to go/);
    fence.remove(false);
    fence.draw(SQUARE);
    timers.advance(200);
    await answer(check({ Problem: "Corners: the sides 1-2 and 3-4 cross: move a corner." }));
    const bad = fenceWords(fence, CIRCLE, ready, false);
    assert.match(bad.line, /cross/);
    assert.notEqual(bad.reason, "");
  });

  it("say that nothing changed", async () => {
    const { fence, timers, answer } = editing();
    fence.begin(setup());
    timers.advance(200);
    await answer(check());
    assert.equal(fenceWords(fence, setup(), ready, false).reason, "Nothing changed");
  });

  it("sum up which fence counts", () => {
    assert.equal(fenceSummary(null, "metres").line, "not known yet");
    assert.deepEqual(fenceSummary(setup(), "metres"), { title: "Fence of 4 corners", line: "drawn, up to 80 m" });
    assert.equal(fenceSummary(setup({ Source: "file" }), "metres").line, "from the settings, up to 80 m");
    assert.deepEqual(fenceSummary(CIRCLE, "metres"), { title: "Fence: circle of 150 m", line: "around where it is armed, up to 100 m" });
    assert.equal(fenceSummary(setup({ Problem: "cannot be read" }), "metres").line, "cannot be read");
  });
});
