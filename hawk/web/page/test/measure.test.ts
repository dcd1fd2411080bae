import "./dom.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { areaOf, crossesItself, lengthOf, Measure } from "../src/state/measure.ts";
import { leaveByEscape } from "../src/ui/escape.ts";
import { MeasureBar } from "../src/ui/measure-bar.ts";
import { MapTools } from "../src/ui/map-tools.ts";
import { measureWords } from "../src/words/measure.ts";
import { CIRCLE, possible } from "./make.ts";
import { flying } from "./rig.ts";
import { Stage } from "./stage.ts";

const at = (North: number, East: number) => ({ North, East });
const L_SHAPE = [at(0, 0), at(0, 20), at(10, 20), at(10, 10), at(30, 10), at(30, 0)];
const BOW_TIE = [at(0, 0), at(10, 10), at(10, 0), at(0, 10)];

describe("what is measured", () => {
  it("is the length along a line, and around a ring", () => {
    assert.equal(lengthOf({ points: [], closed: false }), 0);
    assert.equal(lengthOf({ points: [at(1, 1)], closed: false }), 0);
    assert.equal(lengthOf({ points: [at(0, 0), at(3, 4), at(3, 10)], closed: false }), 11);
    assert.equal(lengthOf({ points: L_SHAPE, closed: true }), 100);
  });

  it("is the area of a ring, in whichever direction it runs and wherever it lies", () => {
    assert.equal(areaOf({ points: L_SHAPE, closed: true }), 400);
    assert.equal(areaOf({ points: L_SHAPE.toReversed(), closed: true }), 400);
    assert.equal(areaOf({ points: L_SHAPE.map((point) => at(point.North - 500, point.East + 700)), closed: true }), 400);
    assert.equal(areaOf({ points: L_SHAPE, closed: false }), null);
  });

  it("is no area where the sides cross", () => {
    assert.deepEqual([BOW_TIE, L_SHAPE, L_SHAPE.slice(0, 3)].map(crossesItself), [true, false, false]);
    assert.equal(areaOf({ points: BOW_TIE, closed: true }), null);
  });
});

describe("the measuring tool", () => {
  it("closes at the first place, begins again after that, and takes back step by step", () => {
    const measure = new Measure(() => undefined);
    measure.begin();
    for (const point of [at(0, 0), at(0, 10), at(0.5, 0.5)]) measure.add(point, 2);
    assert.deepEqual([measure.drawn.points.length, measure.drawn.closed], [3, false], "two places make no ring");
    measure.add(at(1, 1), 2);
    assert.deepEqual([measure.drawn.points.length, measure.drawn.closed], [3, true]);
    measure.back();
    assert.deepEqual([measure.drawn.points.length, measure.drawn.closed], [3, false]);
    measure.back();
    measure.close();
    assert.deepEqual([measure.drawn.points.length, measure.drawn.closed], [2, false]);
    measure.add(at(9, 9), 2);
    measure.close();
    measure.add(at(7, 7), 2);
    assert.deepEqual(measure.drawn, { points: [at(7, 7)], closed: false });
    measure.end();
    assert.deepEqual([measure.open, measure.drawn.points], [false, []]);
  });

  it("says what to do, and what it found", () => {
    const words = (points: typeof L_SHAPE, closed: boolean) => measureWords({ points, closed }, "metres", false);
    assert.equal(words([], false).line, "Click two or more places.");
    assert.equal(words(L_SHAPE.slice(0, 1), false).line, "Click the next place.");
    assert.equal(words(L_SHAPE.slice(0, 2), false).title, "20 m");
    assert.equal(words(L_SHAPE, true).title, "400 m², 100 m around");
    assert.match(words(BOW_TIE, true).line, /sides cross/);
    assert.equal(measureWords({ points: L_SHAPE, closed: true }, "feet", true).title, "4306 ft², 328 ft around");
  });
});

describe("measuring and what else the map is pointed at for", () => {
  const able = { Options: possible("Autonomous Move", "Compulsive Move", "Set Fence"), "Fence Setup": CIRCLE };

  it("end each other", () => {
    const { operator } = flying(able);
    operator.pick(true);
    operator.beginMeasure();
    assert.deepEqual([operator.picking, operator.measure.open], [false, true]);
    operator.pick(true);
    assert.deepEqual([operator.picking, operator.measure.open], [true, false]);
    operator.pointAt(at(1, 2), false);
    operator.beginMeasure();
    assert.deepEqual([operator.question, operator.measure.open], [null, true]);
    operator.ask({ about: "move", target: at(3, 3) });
    assert.equal(operator.measure.open, false);
  });

  it("leaves other questions open, and ends when the fence is drawn", () => {
    const { operator } = flying({ ...able, State: "Idle", Armed: false, Landed: "ON_GROUND" });
    operator.ask({ about: "Arm" });
    operator.beginMeasure();
    assert.deepEqual([operator.question, operator.measure.open], [{ about: "Arm" }, true]);
    operator.editFence();
    assert.deepEqual([operator.fence.open, operator.measure.open], [true, false]);
    operator.beginMeasure();
    assert.equal(operator.measure.open, false);
  });

  it("is left by Escape", () => {
    const { operator } = flying(able);
    operator.beginMeasure();
    const escape = new KeyboardEvent("keydown", { key: "Escape" });
    leaveByEscape(escape, operator, () => assert.fail("something else was left"));
    assert.equal(operator.measure.open, false);
  });

  it("is begun and ended by a button, and shows what it measures", async () => {
    const { operator } = flying(able);
    const tools = new Stage(new MapTools(), operator);
    await tools.drawn();
    await tools.press("Measure");
    const bar = new Stage(new MeasureBar(), operator);
    operator.measure.add(at(0, 0), 1);
    operator.measure.add(at(30, 40), 1);
    await bar.drawn();
    assert.equal(bar.find("[role=status] b").textContent, "50 m");
    await bar.press("Take the last place back");
    assert.equal(operator.measure.drawn.points.length, 1);
    await bar.press("Stop measuring");
    assert.deepEqual([operator.measure.open, bar.has(".measure")], [false, false]);
  });
});
