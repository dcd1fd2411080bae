import "./dom.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import type { Heartbeat } from "../src/protocol.ts";
import { ChecksTab } from "../src/ui/checks-tab.ts";
import { CountsCard } from "../src/ui/counts-card.ts";
import { STANDARD } from "../src/state/preferences.ts";
import { HeightsButton } from "../src/ui/heights-button.ts";
import { LinkBanner } from "../src/ui/link-banner.ts";
import { SettingsTab } from "../src/ui/settings-tab.ts";
import { impossible, possible } from "./make.ts";
import { flying } from "./rig.ts";
import { Stage, words } from "./stage.ts";

const ON_GROUND: Partial<Heartbeat> = { State: "Idle", Armed: false, Landed: "ON_GROUND", "Relative Altitude": 0 };

describe("the link banner", () => {
  it("comes with the loss, says what the drone does, connects at once, and goes with the link", async () => {
    const rig = flying({ State: "Autonomous Explore" });
    const stage = new Stage(new LinkBanner(), rig.operator);
    await stage.drawn();
    assert.equal(stage.text, "");
    rig.server.last.break();
    rig.timers.advance(200);
    rig.operator.tick();
    await stage.drawn();
    assert.match(stage.text, /No word from the drone/);
    assert.match(stage.text, /By its settings it goes on until/);
    assert.match(stage.text, /the autopilot acts sooner by its own failsafe/);
    assert.match(stage.text, /returns home at the latest in 40 s/);
    const before = rig.server.sockets.length;
    await stage.press("Connect");
    assert.equal(rig.server.sockets.length, before + 1);
    rig.server.last.accept();
    rig.hear({ State: "Autonomous Explore" });
    await stage.drawn();
    assert.equal(stage.text, "");
  });

  it("draws each step of what the drone does as past or next", async () => {
    const rig = flying({ State: "Hover" });
    const stage = new Stage(new LinkBanner(), rig.operator);
    rig.server.last.break();
    rig.timers.advance(16_000);
    rig.operator.tick();
    await stage.drawn();
    const marks = [...stage.part.querySelectorAll("circle")].map((mark) => mark.getAttribute("class"));
    assert.deepEqual(marks, ["past", "past", "next"]);
  });
});

describe("the counts", () => {
  it("are not shown before a stall was found", async () => {
    const stage = new Stage(new CountsCard(), flying().operator);
    await stage.drawn();
    assert.equal(stage.text, "");
  });

  it("show each kind, and once it is explored how much was seen of what was found", async () => {
    const rig = flying({ State: "Autonomous Explore", Free: 114, Taken: 40, Unknown: 5, Explored: 0.9 });
    const stage = new Stage(new CountsCard(), rig.operator);
    await stage.drawn();
    const counted = [...stage.part.querySelectorAll<HTMLElement>("[data-count]")].map((each) => [each.dataset.count, words(each.querySelector("b")!)]);
    assert.deepEqual(counted, [["free", "114"], ["taken", "40"], ["unknown", "5"]]);
    assert.match(stage.text, /159 stalls found/);
    assert.doesNotMatch(stage.text, /%/, "it explores: more lot may come in sight");
    rig.hear({ State: "Hover", Free: 1, "Explore Done": true, Explored: 0.9 });
    await stage.drawn();
    assert.match(stage.text, /90 % seen of the lot found/, "explored, but a part could not be seen");
    rig.hear({ State: "Hover", Free: 1, "Explore Done": true, Explored: 1, "Free Range": [1, 1] });
    await stage.drawn();
    assert.match(stage.text, /the lot found seen whole/);
  });

  it("name the bounds of the free ones where they leave something open", async () => {
    const rig = flying({ Free: 71, Taken: 40, Explored: 1, "Explore Done": true, "Free Range": [66, 77] });
    const stage = new Stage(new CountsCard(), rig.operator);
    await stage.drawn();
    assert.match(stage.text, /66 to 77 are free in the lot found/);
    for (const none of [null, [71, 71] as [number, number]]) {
      rig.hear({ Free: 71, "Free Range": none });
      await stage.drawn();
      assert.doesNotMatch(stage.text, /are free/);
    }
  });

  it("say nothing of ground that was not seen: no bounds while it explores", async () => {
    const rig = flying({ State: "Autonomous Explore", Free: 9, Taken: 4, Explored: 0.99, "Explore Done": false, "Free Range": [8, 24] });
    const stage = new Stage(new CountsCard(), rig.operator);
    await stage.drawn();
    assert.doesNotMatch(stage.text, /are free|whole/);
  });

  it("name the suggested ones apart, also where there are no others", async () => {
    const rig = flying({ Free: 2, Taken: 1, Suggested: 4 });
    const stage = new Stage(new CountsCard(), rig.operator);
    await stage.drawn();
    assert.match(stage.text, /3 stalls found/);
    assert.match(stage.text, /4 suggested besides/);
    rig.hear({ Free: 0, Taken: 0, Suggested: 1 });
    await stage.drawn();
    assert.match(stage.text, /1 suggested besides/);
    rig.hear({ Free: 2, Suggested: 0 });
    await stage.drawn();
    assert.doesNotMatch(stage.text, /suggested/);
  });

  it("say until when they were counted once the link is lost", async () => {
    const rig = flying({ Free: 3 });
    const stage = new Stage(new CountsCard(), rig.operator);
    rig.timers.advance(3000);
    rig.operator.tick();
    await stage.drawn();
    assert.match(stage.text, /Counted up to \d\d:\d\d:\d\d/);
  });

  it("offer the survey on the ground alone", async () => {
    const rig = flying({ Free: 3 });
    const stage = new Stage(new CountsCard(), rig.operator);
    await stage.drawn();
    assert.deepEqual(stage.enabled(), []);
    rig.hear({ ...ON_GROUND, Free: 3 });
    await stage.drawn();
    const opened: unknown[] = [];
    stage.part.addEventListener("open-panel", (event) => opened.push((event as CustomEvent).detail));
    await stage.press("Show survey");
    assert.deepEqual(opened, ["survey"]);
  });
});

describe("the remedies of failed checks", () => {
  const missing = {
    Name: "Battery failsafe",
    Passed: false,
    Value: "off",
    Consequence: "With an empty battery the drone falls.",
    Remedy: "Set failsafes.",
    "Remedy Command": "Set Failsafes" as const,
  };

  it("are sent by a press", async () => {
    const rig = flying({ ...ON_GROUND, Checks: [missing], Options: possible("Set Failsafes") });
    const stage = new Stage(new ChecksTab(), rig.operator);
    await stage.drawn();
    await stage.press("Set failsafes");
    assert.equal(rig.sent().at(-1)?.Type, "Set Failsafes");
  });

  it("are not offered while they would be refused, and say why", async () => {
    const noLink = "No link to the autopilot: wait until it is found.";
    for (const [changes, why] of [
      [{ Options: [impossible("Set Failsafes", noLink)] }, noLink.slice(0, -1)],
      [{ Options: possible("Set Failsafes"), "In Control": false }, "Not in control"],
    ] as [Partial<Heartbeat>, string][]) {
      const stage = new Stage(new ChecksTab(), flying({ ...ON_GROUND, Checks: [missing], ...changes }).operator);
      await stage.drawn();
      assert.equal(stage.button("Set failsafes").disabled, true);
      assert.match(stage.text, new RegExp(why));
    }
  });
});

describe("the heights", () => {
  async function opened(changes: Partial<Heartbeat> = {}) {
    const rig = flying({ ...ON_GROUND, Options: possible("Configure"), Ceiling: 97, ...changes });
    const stage = new Stage(new HeightsButton(), rig.operator);
    await stage.drawn();
    await stage.press("Change heights");
    const type = (field: string, value: string): void => {
      const input = stage.input(`input[name=${field}]`);
      input.value = value;
      input.dispatchEvent(new Event("input"));
    };
    const save = async (): Promise<void> => {
      stage.find("form").dispatchEvent(new Event("submit", { cancelable: true }));
      await stage.drawn();
    };
    const isOpen = (): boolean => (stage.find("dialog") as HTMLDialogElement).open;
    return { rig, stage, type, save, isOpen };
  }

  it("cannot be changed in the air or without control, and say why", async () => {
    for (const [changes, why] of [
      [{ Options: [impossible("Configure", "Only on the ground.")] }, "Only on the ground"],
      [{ "In Control": false, Options: possible("Configure") }, "Not in control"],
    ] as const) {
      const stage = new Stage(new HeightsButton(), flying(changes as Partial<Heartbeat>).operator);
      await stage.drawn();
      assert.equal(stage.button("Change heights").disabled, true);
      assert.match(words(stage.button("Change heights")), new RegExp(why));
    }
  });

  it("begin with those in force and are sent as typed, with a comma too", async () => {
    const { rig, stage, type, save, isOpen } = await opened();
    assert.deepEqual([...stage.part.querySelectorAll("input")].map((input) => input.value), ["15", "35", "60"]);
    type("Des", "27,5");
    await save();
    const { Type, Min, Des, Max } = rig.sent().at(-1)!;
    assert.deepEqual([Type, Min, Des, Max], ["Configure", 15, 27.5, 60]);
    assert.equal(isOpen(), true, "it waits for the answer");
    await rig.answer(true);
    await stage.drawn();
    assert.equal(isOpen(), false);
  });

  it("that cannot be are not sent, and the field is named", async () => {
    const { rig, stage, type, save, isOpen } = await opened();
    type("Max", "98");
    await save();
    assert.match(stage.find(".problem").textContent, /Never above.*97 m/);
    type("Max", "abc");
    await save();
    assert.match(stage.find(".problem").textContent, /give a number/);
    assert.deepEqual(rig.sent(), []);
    assert.equal(isOpen(), true);
  });

  it("that the drone refuses stay to be mended", async () => {
    const { rig, stage, save, isOpen } = await opened();
    await save();
    await rig.answer(false, "The autopilot did not take it.");
    await stage.drawn();
    assert.equal(isOpen(), true);
    assert.match(stage.find(".problem").textContent, /The autopilot did not take it\./);
  });

  it("are not stored by Cancel or Escape", async () => {
    const { rig, stage, type, isOpen } = await opened();
    type("Des", "20");
    await stage.press("Cancel");
    assert.equal(isOpen(), false);
    await stage.press("Change heights");
    assert.equal(stage.input("input[name=Des]").value, "35");
    stage.find("dialog").dispatchEvent(new KeyboardEvent("keydown", { key: "Escape" }));
    assert.equal(isOpen(), false);
    assert.deepEqual(rig.sent(), []);
  });
});

describe("the settings", () => {
  it("keep how the page looks", async () => {
    const rig = flying();
    const stage = new Stage(new SettingsTab(), rig.operator);
    await stage.drawn();
    const [, , dark] = stage.part.querySelectorAll<HTMLInputElement>("input[name=theme]");
    dark!.dispatchEvent(new Event("change"));
    const hand = stage.input("input[type=checkbox]");
    hand.checked = true;
    hand.dispatchEvent(new Event("change"));
    await stage.drawn();
    assert.deepEqual(rig.operator.preferences, { ...STANDARD, theme: "dark", leftHanded: true });
    assert.deepEqual([...stage.part.querySelectorAll<HTMLInputElement>("input[name=theme]")].map((input) => input.checked), [false, false, true, false]);
  });

  it("give control back, and say whose it is", async () => {
    const rig = flying(ON_GROUND);
    const stage = new Stage(new SettingsTab(), rig.operator);
    await stage.drawn();
    await stage.press("Give back control");
    assert.deepEqual(rig.sent().map((each) => [each.Type, each.Action]), [["Control", "Release"]]);
    rig.hear({ "In Control": false, Controller: null });
    await stage.drawn();
    assert.match(stage.text, /Nobody has control/);
    rig.hear({ "In Control": false });
    await stage.drawn();
    assert.match(stage.text, /Someone else has control/);
    rig.hear({ "In Control": false, "Controller Lost": true });
    await stage.drawn();
    assert.match(stage.text, /The operator in control is lost/);
    rig.timers.advance(5000);
    rig.operator.tick();
    await stage.drawn();
    assert.match(stage.text, /Control is not known/);
  });

  it("lead to the documentation, with the version beside it", async () => {
    const stage = new Stage(new SettingsTab(), flying().operator);
    await stage.drawn();
    assert.match(stage.text, /Parking Lot Hawk \S+\s*Documentation\s*Licences/);
    const link = [...stage.part.querySelectorAll("a")].find((each) => each.textContent === "Documentation");
    assert.deepEqual([link?.getAttribute("href"), link?.getAttribute("target")], ["docs/", "_blank"]);
  });

  it("show the heights in force", async () => {
    const rig = flying();
    const stage = new Stage(new SettingsTab(), rig.operator);
    await stage.drawn();
    assert.match(stage.text, /Flies at 35 m\s*never below 15 m or above 60 m/);
  });
});
