import "./dom.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import type { Heartbeat } from "../src/protocol.ts";
import { ConfirmBar } from "../src/ui/confirm-bar.ts";
import { EarlierSurvey } from "../src/ui/earlier-survey.ts";
import { impossible, possible } from "./make.ts";
import { flying } from "./rig.ts";
import { Stage } from "./stage.ts";

const WITH_A_MAP: Partial<Heartbeat> = {
  State: "Idle",
  Armed: false,
  Landed: "ON_GROUND",
  Free: 30,
  Taken: 20,
  Unknown: 1,
  "Lot Area": 5200,
  Options: possible("New Survey"),
};

describe("a survey on the map", () => {
  it("is offered to go on or to begin a new one, before the next flight", async () => {
    const rig = flying(WITH_A_MAP);
    const stage = new Stage(new EarlierSurvey(), rig.operator);
    await stage.drawn();
    assert.match(stage.text, /51 stalls on 0\.52 ha\. The next flight goes on with it\./);
    assert.deepEqual(stage.enabled(), ["Open last survey", "Continue survey", "New survey"]);
    const opened: string[] = [];
    stage.part.addEventListener("open-panel", (event) => opened.push((event as CustomEvent<string>).detail));
    await stage.press("Open last survey");
    assert.deepEqual(opened, ["survey"]);
    const before = rig.sent().length;
    await stage.press("Continue survey");
    assert.equal(stage.text, "");
    assert.equal(rig.sent().length, before, "it goes on by itself: nothing is sent");
  });

  it("is offered again after the next flight", async () => {
    const rig = flying(WITH_A_MAP);
    const stage = new Stage(new EarlierSurvey(), rig.operator);
    await stage.drawn();
    await stage.press("Continue survey");
    rig.hear({ State: "Hover", Armed: true, Landed: "IN_AIR", Options: [impossible("New Survey", "Flying: land first.")] });
    await stage.drawn();
    assert.equal(stage.text, "");
    rig.hear({});
    await stage.drawn();
    assert.notEqual(stage.text, "");
  });

  it("is not asked about without control, in the air, or with an empty map", async () => {
    const others: Partial<Heartbeat>[] = [
      { "In Control": false, Controller: "Eve" },
      { State: "Hover" },
      { Options: [impossible("New Survey", "The map is empty: the next flight begins it.")] },
    ];
    for (const changes of others) {
      const stage = new Stage(new EarlierSurvey(), flying({ ...WITH_A_MAP, ...changes }).operator);
      await stage.drawn();
      assert.equal(stage.text, "");
    }
  });

  it("is left only after a slide, and says that nothing stored is lost", async () => {
    const rig = flying(WITH_A_MAP);
    const stage = new Stage(new EarlierSurvey(), rig.operator);
    await stage.drawn();
    const before = rig.sent().length;
    await stage.press("New survey");
    assert.equal(rig.sent().length, before);
    assert.deepEqual(rig.operator.question, { about: "New Survey" });
    const bar = new ConfirmBar();
    bar.question = { about: "New Survey" };
    const asked = new Stage(bar, rig.operator);
    await asked.drawn();
    assert.match(asked.text, /The last survey stays stored on the drone/);
    asked.find("hawk-slide").dispatchEvent(new Event("confirmed"));
    assert.equal(rig.sent().at(-1)?.Type, "New Survey");
  });
});
