import "./dom.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { scaleBar } from "../src/map/geometry.ts";
import type { FenceSetup, Heartbeat } from "../src/protocol.ts";
import { CELL } from "../src/state/tile-data.ts";
import { readPreferences } from "../src/state/preferences.ts";
import { FenceBar } from "../src/ui/fence-bar.ts";
import { HeightsButton } from "../src/ui/heights-button.ts";
import { UnitsSetting } from "../src/ui/units-setting.ts";
import * as format from "../src/words/format.ts";
import { glanceValues } from "../src/words/glance.ts";
import { heightsProblem } from "../src/words/heights.ts";
import { planMove } from "../src/words/move.ts";
import { heightsOf, topHeight } from "../src/words/plot.ts";
import { metresKept, metresOf, typed } from "../src/words/units.ts";
import { FakeStorage } from "./fakes.ts";
import { CIRCLE, heartbeat, possible, view } from "./make.ts";
import { flying, type Rig } from "./rig.ts";
import { Stage } from "./stage.ts";

const ON_GROUND: Partial<Heartbeat> = { State: "Idle", Armed: false, Landed: "ON_GROUND" };

function inFeet(changes: Partial<Heartbeat> = {}): Rig {
  const rig = flying({ ...ON_GROUND, ...changes });
  rig.operator.prefer({ units: "feet" });
  return rig;
}

describe("lengths in feet", () => {
  it("are given in feet, speeds in miles an hour, areas in square feet and acres", () => {
    assert.equal(format.height(35, "feet"), "115 ft");
    assert.equal(format.height(2, "feet"), "6.6 ft");
    assert.equal(format.distance(38.4, "feet"), "126 ft");
    assert.equal(format.margin(5, "feet"), "16.4 ft");
    assert.equal(format.margin(5, "metres"), "5 m");
    assert.equal(format.extent(150, 146.2, "feet"), "492 × 480 ft");
    assert.equal(format.offset(-59, 60, "feet"), "197 ft E, 194 ft S");
    assert.equal(format.speed(4, "feet"), "8.9 mph");
    assert.equal(format.area(312, "feet"), "3358 ft²");
    assert.equal(format.area(5168, "feet"), "1.28 acres");
    assert.equal(format.area(31_400, "feet"), "7.8 acres");
  });

  it("stand in every word that has a length", () => {
    const able = heartbeat({ Options: possible("Autonomous Move", "Compulsive Move") });
    const plan = planMove(view({ heartbeat: able, units: "feet" }), { North: 0, East: -38 }, CELL.lot);
    assert.deepEqual([plan?.question, plan?.pill], ["Move 125 ft west, staying at 115 ft?", "125 ft, 10 s"]);
    assert.equal(glanceValues(view({ units: "feet" })).find((value) => value.name === "height")?.value, "115 ft");
    assert.match(heightsProblem(15, 35, 130, 120, "feet"), /fence ends at 394 ft/);
    assert.deepEqual([topHeight(60, "metres"), topHeight(60, "feet")], [60, 200]);
    assert.deepEqual(heightsOf([{ at: 0, theirs: 0, height: 30.48, battery: 1 }], "feet").map((value) => Math.round(value ?? 0)), [100]);
  });

  it("have a scale bar in kilometres on a map of many lots", () => {
    assert.deepEqual([20, 500, 1000, 200_000].map((metres) => format.scaleLength(metres, "metres")), ["20 m", "500 m", "1 km", "200 km"]);
    assert.equal(format.scaleLength(2000, "feet"), "2000 ft");
  });

  it("have a round scale bar", () => {
    const { length, pixels } = scaleBar(0.1 / 0.3048, 120);
    assert.deepEqual([length, Math.round(pixels)], [20, 61]);
  });
});

describe("a typed length", () => {
  it("in feet becomes metres to the centimetre", () => {
    assert.equal(metresOf("100", "feet"), 30.48);
    assert.equal(metresOf("114,8", "feet"), 34.99);
    assert.equal(metresOf("27,25", "metres"), 27.25);
  });

  it("that is no number above 0 is none", () => {
    for (const text of ["", " ", "abc", "0", "-5", "1e999", "12 m"]) assert.equal(metresOf(text, "feet"), null, text);
  });

  it("that was not changed stays exactly what it was", () => {
    for (const metres of [15, 35, 60, 97.5]) {
      assert.equal(metresKept(typed(metres, "feet"), metres, "feet"), metres);
      assert.equal(metresKept(typed(metres, "metres"), metres, "metres"), metres);
    }
    assert.equal(metresKept("100", 35, "feet"), 30.48);
  });
});

describe("with feet chosen", () => {
  it("heights are offered in feet and sent in metres, unchanged ones as they were", async () => {
    const rig = inFeet({ Options: possible("Configure"), Ceiling: 120 });
    const stage = new Stage(new HeightsButton(), rig.operator);
    await stage.drawn();
    await stage.press("Change heights");
    assert.deepEqual([...stage.part.querySelectorAll("input")].map((input) => input.value), ["49.2", "114.8", "196.9"]);
    assert.match(stage.text, /Feet above the place/);
    const max = stage.input("input[name=Max]");
    max.value = "400";
    max.dispatchEvent(new Event("input"));
    stage.find("form").dispatchEvent(new Event("submit", { cancelable: true }));
    await stage.drawn();
    assert.match(stage.find(".problem").textContent, /fence ends at 394 ft/);
    assert.deepEqual(rig.sent(), []);
    max.value = "200";
    max.dispatchEvent(new Event("input"));
    stage.find("form").dispatchEvent(new Event("submit", { cancelable: true }));
    await stage.drawn();
    const { Min, Des, Max } = rig.sent().at(-1)!;
    assert.deepEqual([Min, Des, Max], [15, 35, 60.96]);
  });

  it("a number typed as metres before the choice is not read as feet", async () => {
    const rig = flying({ ...ON_GROUND, Options: possible("Configure") });
    const stage = new Stage(new HeightsButton(), rig.operator);
    await stage.drawn();
    await stage.press("Change heights");
    rig.operator.prefer({ units: "feet" });
    await stage.drawn();
    stage.find("form").dispatchEvent(new Event("submit", { cancelable: true }));
    await stage.drawn();
    const { Min, Des, Max } = rig.sent().at(-1)!;
    assert.deepEqual([Min, Des, Max], [15, 35, 60]);
    assert.match(stage.text, /Metres above the place/);
  });

  it("the fence's ceiling is typed in feet and kept in metres", async () => {
    const setup: FenceSetup = { ...CIRCLE, Ceiling: 100 };
    const rig = inFeet({ "Fence Setup": setup, Options: possible("Set Fence") });
    rig.operator.editFence();
    rig.operator.fence.draw([48, 48.001, 48.002].map((Latitude) => ({ Latitude, Longitude: 11 })));
    const stage = new Stage(new FenceBar(), rig.operator);
    await stage.drawn();
    const input = stage.input("input");
    assert.equal(input.value, "328.1");
    assert.equal(rig.operator.fence.draft?.ceilingMetres, 100, "nothing typed yet");
    input.value = "250";
    input.dispatchEvent(new Event("input"));
    await stage.drawn();
    assert.equal(rig.operator.fence.draft.ceilingMetres, 76.2);
    assert.equal(input.value, "250");
    input.value = "high";
    input.dispatchEvent(new Event("input"));
    await stage.drawn();
    assert.equal(rig.operator.fence.draft.ceilingMetres, null);
    rig.operator.fence.undo();
    await stage.drawn();
    assert.equal(input.value, "328.1");
  });

  it("the browser keeps it, and whatever else is stored means metres", async () => {
    const { operator } = flying();
    const stage = new Stage(new UnitsSetting(), operator);
    await stage.drawn();
    stage.part.querySelectorAll("input")[1]?.dispatchEvent(new Event("change"));
    assert.equal(operator.view().units, "feet");
    const storage = new FakeStorage();
    storage.setItem("hawk-page", JSON.stringify({ units: "yards" }));
    assert.equal(readPreferences(storage).units, "metres");
  });
});
