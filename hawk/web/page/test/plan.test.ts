import "./dom.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { LocalPlane } from "../src/fence/plane.ts";
import type { Rectangle } from "../src/map/geometry.ts";
import { isInside } from "../src/map/plan-layer.ts";
import { type Datum, inverse, lotFrame, shifted, shiftedShape } from "../src/plan/frame.ts";
import { countFor, depthOf, rowShapes } from "../src/plan/rows.ts";
import { ShownPlan } from "../src/plan/shown-plan.ts";
import { snapEnd, snapFar, snapMove, snapPlace, snapStall } from "../src/plan/snap.ts";
import { inOrder, type PlanStall, rowsOf, usualSize } from "../src/plan/values.ts";

function stall(label: string, north: number, east: number, changes: Partial<PlanStall> = {}): PlanStall {
  return { id: label, label, north, east, angle: 0, width: 2.5, length: 5, kind: "", is_confirmed: false, is_named: false, ...changes };
}

function near(found: readonly number[], wanted: readonly number[], within = 1e-6): void {
  assert.equal(found.length, wanted.length);
  found.forEach((value, index) => assert.ok(Math.abs(value - (wanted[index] ?? Number.NaN)) < within, `${found.join()} is not ${wanted.join()}`));
}

function flat(shapes: readonly Rectangle[]): number[] {
  return shapes.flatMap(({ north, east, angle, width, length }) => [north, east, angle, width, length]);
}

const USUAL = { width: 2.5, length: 5 };
/** Four stalls from west to east, their fronts in the south. */
const ROW = [0, 1, 2, 3].map((along) => stall(`A ${along + 1}`, 2.5, 1.25 + 2.5 * along));

describe("a row that is drawn", () => {
  // the numbers are those of hawk.lots.plan.geometry.row_shapes
  it("has the stalls that the store makes of it", () => {
    const square = rowShapes({ front: [[0, 0], [0, 10]], far: [-5.2, 3], count: 4, lean: 0, double: false });
    near(flat(square), [1.25, 3.75, 6.25, 8.75].flatMap((east) => [-2.6, east, 0, 2.5, 5.2]));
    const angled = rowShapes({ front: [[1, 2], [9, 8]], far: [0, 14], count: 3, lean: Math.PI / 6, double: false });
    const rest = [1.690699, 2.886751, 10.111279];
    near(flat(angled), [[1.628922, 8.846692], [4.295589, 10.846692], [6.962256, 12.846692]].flatMap((place) => [...place, ...rest]), 2e-6);
  });

  it("is double with the second side turned by half a turn", () => {
    const double = rowShapes({ front: [[0, 0], [0, 10]], far: [10.4, 3], count: 4, lean: (-20 * Math.PI) / 180, double: true });
    const rest = [2.792527, 2.349232, 4.678674];
    const [near_, far] = [[0.303677, 2.803677, 5.303677, 7.803677], [2.196323, 4.696323, 7.196323, 9.696323]] as const;
    near(flat(double), [...near_.map((east) => [2.6, east]), ...far.map((east) => [7.8, east])].flatMap((place) => [...place, ...rest]), 2e-6);
  });

  it("is parallel where the stalls are longer along the front", () => {
    const found = rowShapes({ front: [[0, 0], [0, 12]], far: [2.2, 1], count: 2, lean: 0, double: false });
    near(flat(found), [3, 9].flatMap((east) => [1.1, east, Math.PI / 2, 2.2, 6]));
  });

  it("is none without room", () => {
    assert.deepEqual(rowShapes({ front: [[0, 0], [0, 0.1]], far: [5, 0], count: 1, lean: 0, double: false }), []);
    assert.deepEqual(rowShapes({ front: [[0, 0], [0, 10]], far: [0.2, 0], count: 4, lean: 0, double: false }), []);
  });

  it("has the count whose pitch is nearest to the lot's", () => {
    assert.equal(countFor(10.1, USUAL, 0, false), 4);
    assert.equal(countFor(10.1, USUAL, 0, true), 2);
    assert.equal(countFor(10.1, USUAL, Math.PI / 4, false), 3);
    assert.equal(countFor(0.4, USUAL, 0, false), 1);
    assert.equal(depthOf([[0, 0], [0, 10]], [-5, 99]), 5);
  });
});

describe("snapping", () => {
  it("puts a new stall beside its row, at the row's pitch and angle", () => {
    const wanted = { north: 2.5, east: 11.25, angle: 0, width: 2.5, length: 5 };
    assert.deepEqual(snapStall([2.9, 11.8], ROW, [], USUAL), wanted);
  });

  it("puts it where vision saw one, and never where one stands", () => {
    const seen: Rectangle = { north: 20, east: 20, angle: 0.3, width: 2.4, length: 5.1 };
    assert.deepEqual(snapStall([20.8, 20.2], ROW, [seen], USUAL), seen);
    const free = snapStall([2.5, 6.3], ROW, [{ ...seen, north: 2.5, east: 6.2 }], USUAL);
    near([free.north, free.east], [2.5, 6.3]);
  });

  it("leaves it where it is far off or not asked for, in the direction of the nearest", () => {
    const turned = ROW.map((each) => ({ ...each, angle: 1 }));
    assert.deepEqual(snapStall([9, 40], turned, [], USUAL), { north: 9, east: 40, angle: 1, ...USUAL });
    assert.deepEqual(snapStall([2.9, 11.8], ROW, [], USUAL, true), { north: 2.9, east: 11.8, angle: 0, ...USUAL });
  });

  it("puts a front's end on a corner, else on the line of a row", () => {
    near(snapPlace([0.3, 10.4], ROW), [0, 10]);
    near(snapPlace([0.3, 14], ROW), [0, 14]);
    assert.deepEqual(snapPlace([1.5, 14], ROW), [1.5, 14]);
    assert.deepEqual(snapPlace([0.3, 40], ROW), [0.3, 40], "the line ends somewhere");
  });

  it("turns a front into the direction of rows near by, to whole pitches", () => {
    near(snapEnd([-8, 0], [-7.7, 10.2], ROW, 2.5), [-8, 10]);
    near(snapEnd([-8, 0], [-7.7, 11.2], ROW, 2.5), [-8, 11.2]);
    near(snapEnd([-8, 0], [-3, 10.2], ROW, 2.5), [-3, 10.2]);
    near(snapEnd([-8, 0], [-18.1, 0.3], ROW, 2.5), [-18, 0]);
  });

  it("makes a row as deep as stalls are, or up to another row", () => {
    const front = [[-20, 0], [-20, 10]] as const;
    near(snapFar(front, [-25.4, 4], ROW, 5), [-25, 4]);
    near(snapFar(front, [-28, 4], ROW, 5), [-28, 4]);
    near(snapFar([[-6, 0], [-6, 10]], [-0.3, 4], ROW, 5), [0, 4]);
  });

  it("moves what is moved beside what stays, or onto what vision saw", () => {
    const moved = [stall("B 1", 2.9, 11.5), stall("B 2", 2.9, 14)];
    near(snapMove(moved, ROW, []), [-0.4, -0.25]);
    near(snapMove([stall("B 1", 30, 30)], ROW, [{ north: 30.2, east: 30.1, angle: 0, width: 2.5, length: 5 }]), [0.2, 0.1]);
    assert.deepEqual(snapMove([stall("B 1", 30, 30)], ROW, []), [0, 0]);
  });
});

describe("the lot's frame on the map", () => {
  const DATUM: Datum = [48.001, 11.002];
  const MAP = new LocalPlane({ Latitude: 48, Longitude: 11 });

  // the numbers are those of hawk.lots.registration.frames.frame_of
  it("lies by its datum where the map is of another flight", () => {
    const { toMap, by } = lotFrame(DATUM, [{ datum: [48.5, 11], place: { north: 1, east: 2, turn: 0 } }], MAP);
    assert.equal(by, "gnss");
    near([toMap.north, toMap.east], [111.192268, 149.247823], 2e-3);
    near([toMap.turn], [-2.5941e-5], 1e-8);
  });

  it("lies by the stalls where the map is that of a survey that was placed on them", () => {
    const place = { north: 3, east: -2, turn: 0.1 };
    const { toMap, by } = lotFrame(DATUM, [{ datum: [48, 11], place }, { datum: [48, 11], place: null }], MAP);
    assert.equal(by, "survey");
    near(shifted(toMap, shifted(place, [7, 8])), [7, 8]);
  });

  it("is the map's own while there is none", () => {
    assert.deepEqual(lotFrame(DATUM, [], null), { toMap: { north: 0, east: 0, turn: 0 }, by: "own" });
  });

  it("turns stalls with it, and back", () => {
    const shift = { north: 5, east: 6, turn: Math.PI / 2 };
    const moved = shiftedShape(shift, stall("A 1", 1, 0));
    near([moved.north, moved.east, moved.angle], [5, 7, Math.PI / 2]);
    const back = shiftedShape(inverse(shift), moved);
    near([back.north, back.east, back.angle], [1, 0, 0]);
  });
});

describe("stalls of a plan", () => {
  it("are in the order of rows and numbers", () => {
    const labels = ["B 2", "AA 1", "Boss", "B 10", "A 9"];
    assert.deepEqual(inOrder(labels.map((label) => stall(label, 0, 0))).map(({ label }) => label), ["A 9", "B 2", "B 10", "AA 1", "Boss"]);
    assert.deepEqual(rowsOf(labels.map((label) => stall(label, 0, 0))), ["A", "B", "AA"]);
  });

  it("have a usual size, also where there is none", () => {
    assert.deepEqual(usualSize([]), { width: 2.5, length: 5 });
    assert.deepEqual(usualSize([3, 2, 2.2].map((width) => stall("A 1", 0, 0, { width }))), { width: 2.2, length: 5 });
  });

  it("lie in a box by their middles", () => {
    const ring: [number, number][] = [[0, 0], [10, 0], [10, 4], [0, 4]];
    assert.deepEqual(([[5, 2], [11, 2], [5, -1], [0.1, 3.9]] as [number, number][]).map((place) => isInside(ring, place)), [true, false, false, true]);
  });
});

describe("the plan as it is shown", () => {
  const whole = (stalls: PlanStall[]) => ({ revision: 1, whole: true, stalls, gone: [], zones: [], named_zones: [], sections: [], edit: null });
  const done = { undo: 1, redo: 0, zones: [], named_zones: [], sections: [], gone: [] };

  it("has at once what was asked for, and after the answer what the store says", () => {
    const plan = new ShownPlan();
    plan.take(whole(ROW), []);
    const move = { do: "move", stalls: ["A 1", "A 2"], north: 1, east: 0 } as const;
    const asked = { ...move, stalls: [...move.stalls] };
    assert.deepEqual([...plan.foresee([asked], asked)], ["A 1", "A 2"]);
    assert.equal(plan.get("A 1")?.north, 3.5);
    plan.done({ ...done, revision: 2, stalls: [stall("A 1", 3.4, 1.25), stall("A 2", 3.5, 3.75)] }, [], asked);
    assert.deepEqual([plan.get("A 1")?.north, plan.revision], [3.4, 2]);
  });

  it("keeps later steps in sight while earlier ones are answered", () => {
    const plan = new ShownPlan();
    plan.take(whole(ROW), []);
    const first = { do: "confirm", all: true } as const;
    const later = { do: "remove", stalls: ["A 3"] } as const;
    const waiting = [{ ...later, stalls: [...later.stalls] }];
    plan.foresee([first, ...waiting], first);
    plan.done({ ...done, revision: 2, stalls: ROW.map((each) => ({ ...each, is_confirmed: true })) }, waiting, first);
    assert.deepEqual([...plan.stalls.keys()], ["A 1", "A 2", "A 4"]);
  });

  it("is as before after a refusal, and loses what is gone", () => {
    const plan = new ShownPlan();
    plan.take(whole(ROW), []);
    const asked = { do: "remove" as const, stalls: ["A 1"] };
    plan.foresee([asked], asked);
    assert.equal(plan.stalls.size, 3);
    plan.foresee([], asked);
    assert.equal(plan.stalls.size, 4);
    plan.take({ ...whole([]), whole: false, revision: 2, gone: ["A 2"] }, []);
    assert.deepEqual([...plan.stalls.keys()].sort(), ["A 1", "A 3", "A 4"]);
  });

  it("is summed up again after each change", () => {
    const plan = new ShownPlan();
    plan.take(whole(ROW), []);
    assert.deepEqual(plan.summary, { usual: USUAL, rows: ["A"], confirmed: 0, guessed: 4 });
    const confirm = { do: "confirm", all: true } as const;
    plan.foresee([confirm], confirm);
    assert.equal(plan.summary.confirmed, 4);
    plan.take({ ...whole([stall("B 1", 0, 0, { width: 3 })]), revision: 2 }, []);
    assert.deepEqual(plan.summary, { usual: { width: 3, length: 5 }, rows: ["B"], confirmed: 0, guessed: 1 });
  });

  it("is another one where all of it comes again", () => {
    const plan = new ShownPlan();
    plan.take(whole(ROW), []);
    plan.take({ ...whole([stall("B 1", 0, 0)]), revision: 3 }, []);
    assert.deepEqual([...plan.stalls.keys()], ["B 1"]);
  });
});
