import "./dom.ts";
import assert from "node:assert/strict";
import { afterEach, beforeEach, describe, it } from "node:test";
import { AllSettings } from "../src/ui/all-settings.ts";
import { settingGroups, settingWords } from "../src/words/settings.ts";
import type { Setting } from "../src/link/settings.ts";
import { flying } from "./rig.ts";
import { Stage, words } from "./stage.ts";

const RESERVE: Setting = {
  Section: "flight",
  Key: "battery_reserve_percent",
  Text: "battery reserve on arrival at home, percent",
  Unit: "%",
  Value: 25,
  Default: 20,
  Lowest: 5,
  Highest: 80,
};
const TOKEN: Setting = { Section: "web", Key: "token", Text: "the operator's token", Unit: "", Value: null, Default: null, Lowest: null, Highest: null };
const YAW: Setting = { Section: "camera", Key: "mount_yaw_deg", Text: "rotation of the mount", Unit: "°", Value: 0, Default: 0, Lowest: -180, Highest: 180 };
const HOSTS: Setting = { Section: "web", Key: "allowed_hosts", Text: "host names", Unit: "", Value: ["a.example", "b.example"], Default: [], Lowest: null, Highest: null };

describe("all settings", () => {
  const before = globalThis.fetch;
  let asked: number;
  let answer: () => Promise<Response>;

  beforeEach(() => {
    asked = 0;
    answer = () => Promise.resolve(Response.json({ Settings: [RESERVE, TOKEN, YAW, HOSTS] }));
    globalThis.fetch = () => {
      asked += 1;
      return answer();
    };
  });

  afterEach(() => {
    globalThis.fetch = before;
  });

  async function opened(stage: Stage<AllSettings>, open = true): Promise<void> {
    const details = stage.find("details") as HTMLDetailsElement;
    details.open = open;
    details.dispatchEvent(new Event("toggle"));
    await stage.drawn();
  }

  it("are asked for when they are opened, once", async () => {
    const stage = new Stage(new AllSettings(), flying().operator);
    await stage.drawn();
    assert.equal(asked, 0);
    await opened(stage);
    await opened(stage, false);
    await opened(stage);
    assert.equal(asked, 1);
    assert.match(words(stage.find("dl")), /battery_reserve_percent 25 % changed 5 to 80 % battery reserve on arrival/);
  });

  it("are asked for again after no answer", async () => {
    answer = () => Promise.reject(new TypeError("no link"));
    const stage = new Stage(new AllSettings(), flying().operator);
    await stage.drawn();
    await opened(stage);
    assert.match(stage.text, /does not answer/);
    answer = () => Promise.resolve(new Response("", { status: 500 }));
    await opened(stage);
    assert.match(stage.text, /does not answer/);
    answer = () => Promise.resolve(Response.json({ Settings: [YAW] }));
    await opened(stage);
    assert.match(stage.text, /mount_yaw_deg/);
  });

  it("are searched", async () => {
    const stage = new Stage(new AllSettings(), flying().operator);
    await stage.drawn();
    await opened(stage);
    const field = stage.input("input");
    field.value = "battery home";
    field.dispatchEvent(new Event("input"));
    await stage.drawn();
    assert.equal(stage.part.querySelectorAll("dt").length, 1);
    field.value = "submarine";
    field.dispatchEvent(new Event("input"));
    await stage.drawn();
    assert.match(stage.text, /No setting is like this/);
  });
});

describe("a setting in words", () => {
  it("has value, unit and bounds", () => {
    assert.deepEqual(settingWords(YAW), { name: "mount_yaw_deg", value: "0°", bounds: "-180 to 180°", text: YAW.Text, changed: false });
    assert.equal(settingWords(TOKEN).value, "not set");
    assert.equal(settingWords(TOKEN).bounds, "");
    assert.equal(settingWords({ ...RESERVE, Value: null }).value, "not set");
    assert.equal(settingWords({ ...TOKEN, Value: true, Default: false }).value, "true");
  });

  it("lists values, and is changed when the list is another", () => {
    assert.deepEqual([settingWords(HOSTS).value, settingWords(HOSTS).changed], ["a.example, b.example", true]);
    assert.equal(settingWords({ ...HOSTS, Value: [] }).value, "none");
  });

  it("stands with its section, in the drone's order", () => {
    assert.deepEqual(
      settingGroups([RESERVE, TOKEN, YAW, HOSTS], "").map(([section, all]) => [section, all.length]),
      [["flight", 1], ["web", 2], ["camera", 1]],
    );
  });
});
