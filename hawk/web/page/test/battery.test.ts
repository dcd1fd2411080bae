import "./dom.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import type { Heartbeat } from "../src/protocol.ts";
import { BatteryBar } from "../src/ui/battery-bar.ts";
import { batteryWords } from "../src/words/battery.ts";
import { heartbeat } from "./make.ts";
import { flying } from "./rig.ts";
import { Stage } from "./stage.ts";

const SHORT: Partial<Heartbeat> = { "Battery Needed Survey": 90, "Battery Left": -25, "Survey Share": 0.72 };

async function drawn(changes: Partial<Heartbeat>): Promise<Stage<BatteryBar>> {
  const rig = flying();
  rig.hear({ State: "Autonomous Explore", ...changes });
  const stage = new Stage(new BatteryBar(), rig.operator);
  await stage.drawn();
  return stage;
}

function shares(stage: Stage<BatteryBar>): Record<string, string> {
  const parts = [...stage.part.querySelectorAll<HTMLElement>(".charge i")];
  return Object.fromEntries(parts.map((part) => [part.className, part.style.getPropertyValue("--share")]));
}

describe("the battery bar", () => {
  it("shows the return, the survey and the rest as parts of a full battery", async () => {
    const stage = await drawn({});
    assert.deepEqual(shares(stage), { home: "24", survey: "31", left: "34" });
    assert.match(stage.text, /Battery 89 %/);
    assert.match(stage.text, /Enough for the lot found so far/);
  });

  it("says the same in words", async () => {
    const label = (await drawn({})).part.querySelector(".charge")?.getAttribute("aria-label");
    assert.equal(label, "Battery 89 %: home with the reserve 24 %, survey 31 %, left 34 %. Enough for the lot found so far.");
  });

  it("shows what is missing, and of how much of the survey it is enough", async () => {
    const stage = await drawn(SHORT);
    assert.deepEqual(shares(stage), { home: "24", survey: "65", missing: "11" });
    assert.match(stage.text, /Enough for about 70 % of the lot found so far/);
    assert.ok(stage.part.querySelector(".short .icon"));
  });

  it("is not drawn while charge or need are not known", async () => {
    assert.equal((await drawn({ "Battery Percentage": null })).text, "");
    assert.equal((await drawn({ "Battery Needed Home": null })).text, "");
  });

  it("shows the age of an old charge", async () => {
    assert.match((await drawn({ "Battery Age": 8 })).text, /8 s old/);
  });
});

describe("words about the battery", () => {
  const verdict = (changes: Partial<Heartbeat>) => batteryWords(heartbeat(changes))?.verdict;

  it("call an unknown lot as large as the fence", () => {
    assert.equal(verdict({ "Survey Basis": "fence" }), "Enough for a lot as large as the fence");
    assert.equal(verdict({ ...SHORT, "Survey Basis": "fence" }), "Enough for about 70 % of a lot as large as the fence");
  });

  it("distinguish a survey that is done from one of which nothing is known", () => {
    assert.equal(verdict({ "Battery Needed Survey": 0, "Battery Left": 65 }), "Nothing is left of the survey");
    const unknown = { "Battery Needed Survey": null, "Battery Left": null, "Survey Share": null, "Survey Basis": null };
    assert.equal(verdict(unknown), "What the survey needs is not known");
    assert.deepEqual(batteryWords(heartbeat(unknown))?.parts.map((part) => part.name), ["home", "left"]);
  });

  it("show no more for the return than there is", () => {
    const parts = batteryWords(heartbeat({ "Battery Percentage": 20, "Battery Needed Survey": null }))?.parts;
    assert.deepEqual(parts?.map((part) => [part.name, part.percent, part.shown]), [["home", 24, 20], ["missing", 4, 4]]);
  });
});
