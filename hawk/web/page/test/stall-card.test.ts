import "./dom.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { corners } from "../src/map/geometry.ts";
import { cropExtent, upright } from "../src/map/stall-crop.ts";
import type { Heartbeat } from "../src/protocol.ts";
import { CELL } from "../src/state/tile-data.ts";
import { ConfirmBar } from "../src/ui/confirm-bar.ts";
import { StallCard } from "../src/ui/stall-card.ts";
import { likelihood, lookAgain } from "../src/words/stall.ts";
import { heartbeat, impossible, mapUpdate, possible, stall, view } from "./make.ts";
import { flying } from "./rig.ts";
import { Stage, words } from "./stage.ts";

describe("how sure a stall is", () => {
  it("is said in words, with one set of thresholds", () => {
    const cases: [Parameters<typeof likelihood>[0], string][] = [
      [{ state: "free", taken: 0.02 }, "almost surely free"],
      [{ state: "free", taken: 0.1 }, "almost surely free"],
      [{ state: "free", taken: 0.11 }, "probably free"],
      [{ state: "taken", taken: 0.97 }, "almost surely taken"],
      [{ state: "taken", taken: 0.7 }, "probably taken"],
      [{ state: "unknown", taken: 0.5 }, "unclear"],
      [{ state: "unknown", taken: 0.58 }, "unclear"],
      [{ state: "unknown", taken: 0.38 }, "unclear, probably free"],
      [{ state: "unknown", taken: 0.62 }, "unclear, probably taken"],
      [{ state: "free", taken: null }, "free"],
      [{ state: "unknown", taken: null }, "unclear"],
    ];
    assert.equal(likelihood({ state: "suggested", taken: 1 }), "suggested");
    for (const [one, wanted] of cases) assert.equal(likelihood(one), wanted);
  });

  it("never contradicts the drone's own call", () => {
    assert.equal(likelihood({ state: "free", taken: 0.47 }), "probably free");
    assert.equal(likelihood({ state: "taken", taken: 0.47 }), "probably taken");
  });
});

describe("a stall's picture", () => {
  it("stands upright in the middle and fits, however the stall lies", () => {
    for (const angle of [0, 0.6, 1.5, 2.9]) {
      const one = { north: 37, east: -12, angle, width: 2.5, length: 5 };
      const [a, b, c, d, e, f] = upright(one, 120, 192);
      const found = corners(one).map(([east, north]) => [a * east - c * north + e, b * east - d * north + f] as [number, number]);
      const [xs, ys] = [found.map(([x]) => x), found.map(([, y]) => y)];
      const [width, height] = [Math.max(...xs) - Math.min(...xs), Math.max(...ys) - Math.min(...ys)];
      assert.ok(Math.abs(width / height - 0.5) < 1e-9, "its long side is up and down");
      assert.ok(height > 0.7 * 192 && height < 192 && width < 120);
      assert.ok(Math.abs(Math.min(...xs) + width / 2 - 60) < 1e-6 && Math.abs(Math.min(...ys) + height / 2 - 96) < 1e-6);
    }
  });

  it("needs only the ground around it", () => {
    const [west, south, east, north] = cropExtent({ north: 10, east: 20, angle: 0.4, width: 2.5, length: 5 });
    assert.ok(west < 20 - 4 && east > 20 + 4 && south < 10 - 4 && north > 10 + 4 && east - west < 20);
  });
});

describe("the stall's card", () => {
  const able: Partial<Heartbeat> = { State: "Hover", Options: possible("Autonomous Move", "Compulsive Move") };

  async function shown(changes: Partial<Heartbeat> = {}, drawn = true) {
    const rig = flying({ ...able, ...changes });
    rig.hear({ "Occupancy Map": mapUpdate({ Stalls: [stall(7, { North: 0, East: 38, State: "unknown", Taken: 0.62 })] }) });
    const card = new StallCard();
    const pictures: number[] = [];
    card.draw = (one) => (pictures.push(one.id), drawn);
    card.chosen = 7;
    const stage = new Stage(card, rig.operator);
    await stage.drawn();
    return { rig, stage, pictures };
  }

  it("names a stall as the lot's plan does", async () => {
    const { rig, stage } = await shown();
    assert.equal(words(stage.find(".h")), "Stall 7");
    rig.hear({ "Occupancy Map": mapUpdate({ Stalls: [stall(7, { Version: 2, Label: "B 12" })] }) });
    await stage.drawn();
    assert.equal(words(stage.find(".h")), "Stall B 12");
  });

  it("has the stall's picture, where there is one, and how sure it is", async () => {
    const { stage, pictures } = await shown();
    assert.equal(words(stage.find(".kind")).replace(/^\? /, ""), "Unclear, probably taken");
    assert.equal(stage.find("canvas").hidden, false);
    assert.ok(pictures.includes(7));
    const bare = await shown({}, false);
    assert.equal(bare.stage.find("canvas").hidden, true);
  });

  it("sends the drone there by the guided question, inside the lot, and only after the slide", async () => {
    const { rig, stage } = await shown();
    await stage.press("Look again");
    assert.deepEqual(rig.operator.question, { about: "move", target: { North: 0, East: 38 }, kind: "Autonomous Move", stall: 7 });
    assert.equal(rig.sent().some((each) => each.Type.endsWith("Move")), false, "nothing moves yet");
    assert.equal(stage.has(".pop"), false);
    const bar = new ConfirmBar();
    bar.question = rig.operator.question;
    bar.classAt = () => CELL.taken;
    const asked = new Stage(bar, rig.operator);
    await asked.drawn();
    assert.match(asked.text, /Look at stall 7 again\? ?Fly 38 m east, staying at 35 m\. /);
    asked.find("hawk-slide").dispatchEvent(new CustomEvent("confirmed"));
    await asked.drawn();
    const { Type, X, Y, Frame } = rig.sent().at(-1)!;
    assert.deepEqual([Type, X, Y, Frame], ["Autonomous Move", 0, 38, "Map"]);
  });

  it("offers no second look on the ground, without control or without a link, and says why the drone would refuse", async () => {
    assert.equal(lookAgain(view({ heartbeat: heartbeat(able) })), "");
    assert.equal(lookAgain(view({ heartbeat: heartbeat({ ...able, "In Control": false }) })), null);
    assert.equal(lookAgain(view({ heartbeat: heartbeat({ ...able, Armed: false, Landed: "ON_GROUND" }) })), null);
    assert.equal(lookAgain(view({ heartbeat: heartbeat(able), silence: 9 })), null);
    const { stage } = await shown({ Options: [impossible("Autonomous Move", "The remote control flies.")] });
    assert.equal(stage.button("Look again").disabled, true);
    assert.match(words(stage.button("Look again")), /The remote control flies/);
  });
});
