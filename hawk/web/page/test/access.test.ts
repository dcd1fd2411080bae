import "./dom.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import type { Heartbeat } from "../src/protocol.ts";
import { Alarms } from "../src/state/alarms.ts";
import { CELL } from "../src/state/tile-data.ts";
import { ActionBar } from "../src/ui/action-bar.ts";
import { KeysList } from "../src/ui/keys-list.ts";
import { actOnKey } from "../src/ui/keys.ts";
import { MessagesTab } from "../src/ui/messages-tab.ts";
import { StallsTab } from "../src/ui/stalls-tab.ts";
import { Tabs } from "../src/ui/tabs.ts";
import { KEYS } from "../src/words/keys.ts";
import { stallRows } from "../src/words/stall-rows.ts";
import { heartbeat, mapUpdate, possible, stall, view } from "./make.ts";
import { flying, type Rig } from "./rig.ts";
import { Stage, words } from "./stage.ts";

const ON_GROUND: Partial<Heartbeat> = { State: "Idle", Armed: false, Landed: "ON_GROUND", "Relative Altitude": 0 };
const IN_AIR = possible("Autonomous Explore", "Autonomous Move", "Return To Launch", "Land", "Hold");

function press(rig: Rig, key: string, target: HTMLElement = document.body, init: KeyboardEventInit = {}): string[] {
  const page: string[] = [];
  const event = new KeyboardEvent("keydown", { key, cancelable: true, bubbles: true, ...init });
  Object.defineProperty(event, "target", { value: target });
  actOnKey(event, rig.operator, (action) => page.push(action));
  return page;
}

/** The name of what has the focus: comparing elements themselves would print the whole page. */
function focused(): string {
  const element = document.activeElement;
  return element?.getAttribute("aria-label") ?? (element ? words(element) : "");
}

function types(rig: Rig): string[] {
  return rig.sent().map(({ Type }) => Type);
}

describe("keys", () => {
  it("hold the drone at once, in small and large letters", () => {
    const rig = flying({ Options: IN_AIR });
    press(rig, "h");
    press(rig, "H");
    assert.deepEqual(types(rig), ["Hold", "Hold"]);
  });

  it("press no button again that has the focus while Enter is kept down", () => {
    const pressed = (repeat: boolean): boolean => {
      const event = new KeyboardEvent("keydown", { key: "Enter", cancelable: true, bubbles: true, repeat });
      Object.defineProperty(event, "target", { value: document.createElement("button") });
      actOnKey(event, flying({ Options: IN_AIR }).operator, () => assert.fail("no key of the page"));
      return !event.defaultPrevented;
    };
    assert.deepEqual([pressed(false), pressed(true)], [true, false]);
  });

  it("ask before anything else, and send nothing", () => {
    for (const [key, changes, about] of [
      ["a", { ...ON_GROUND, Options: possible("Arm") }, "Arm"],
      ["t", { ...ON_GROUND, State: "Arm", Armed: true, Options: possible("Takeoff") }, "Takeoff"],
      ["e", { Options: IN_AIR }, "Autonomous Explore"],
      ["r", { State: "Manual", Options: possible("Resume") }, "Resume"],
    ] as [string, Partial<Heartbeat>, string][]) {
      const rig = flying(changes);
      press(rig, key);
      assert.equal(rig.operator.question?.about, about);
      assert.deepEqual(types(rig), []);
    }
  });

  it("do nothing that the drone does not offer", () => {
    const rig = flying({ ...ON_GROUND, Options: [] });
    for (const { key } of KEYS) press(rig, key);
    assert.equal(rig.operator.question, null);
    assert.deepEqual(types(rig), []);
  });

  it("know no landing and no cutting of the motors", () => {
    const rig = flying({ Options: [...IN_AIR, ...possible("Kill")] });
    for (const letter of "abcdefgijklmnopqrstuvwxyz0123456789 ") press(rig, letter);
    assert.ok(!types(rig).some((type) => ["Land", "Return To Launch", "Kill", "Kill Request", "Disarm"].includes(type)), types(rig).join());
  });

  it("are off while somebody types, holds a key down, or uses a shortcut of the browser", () => {
    const rig = flying({ Options: IN_AIR });
    const text = document.createElement("input");
    press(rig, "h", text);
    press(rig, "h", document.body, { repeat: true });
    press(rig, "h", document.body, { ctrlKey: true });
    press(rig, "h", document.body, { metaKey: true });
    press(rig, "h", document.body, { altKey: true });
    assert.deepEqual(types(rig), []);
    const box = document.createElement("input");
    box.type = "checkbox";
    press(rig, "h", box);
    assert.deepEqual(types(rig), ["Hold"]);
  });

  it("leave what is asked about the motors alone", () => {
    const rig = flying({ Options: IN_AIR });
    void rig.operator.cut.begin();
    press(rig, "e");
    assert.equal(rig.operator.question, null);
    press(rig, "h");
    assert.deepEqual(types(rig), ["Kill Request", "Hold"]);
  });

  it("open what belongs to the page", () => {
    const rig = flying();
    assert.deepEqual([...press(rig, "?"), ...press(rig, "v"), ...press(rig, "s")], ["keys", "swap", "survey"]);
  });

  it("are listed, each once", async () => {
    const stage = new Stage(new KeysList(), flying().operator);
    await stage.drawn();
    const keys = [...stage.part.querySelectorAll("kbd")].map((each) => words(each));
    assert.equal(new Set(keys).size, keys.length);
    for (const { key } of KEYS) assert.ok(keys.includes(key.toUpperCase()), key);
  });

  it("have the documentation of this version below them", async () => {
    const stage = new Stage(new KeysList(), flying().operator);
    await stage.drawn();
    assert.equal(stage.find("a").getAttribute("href"), "docs/");
    assert.match(stage.text, /Documentation of Parking Lot Hawk \S+/);
  });
});

describe("the next step", () => {
  async function bar(changes: Partial<Heartbeat>): Promise<{ rig: Rig; stage: Stage<ActionBar> }> {
    const rig = flying(changes);
    const part = new ActionBar();
    part.classAt = () => CELL.lot;
    const stage = new Stage(part, rig.operator);
    await stage.drawn();
    return { rig, stage };
  }
  const primary = (stage: Stage<ActionBar>): string[] => [...stage.part.querySelectorAll(".act.primary b")].map((each) => words(each));

  it("is the one primary button", async () => {
    for (const [changes, name] of [
      [{ ...ON_GROUND, Options: possible("Arm") }, "Arm"],
      [{ ...ON_GROUND, State: "Arm", Armed: true, Options: possible("Takeoff", "Disarm") }, "Take off"],
      [{ Options: IN_AIR }, "Explore"],
      [{ "Explore Done": true, Options: IN_AIR }, "Return home"],
      [{ State: "Manual", Options: possible("Resume") }, "Resume"],
    ] as [Partial<Heartbeat>, string][]) {
      const { stage } = await bar(changes);
      assert.deepEqual(primary(stage), [name]);
    }
  });

  it("is none while the drone is busy, nor for those who watch", async () => {
    for (const changes of [
      { State: "Autonomous Explore", Options: IN_AIR },
      { ...ON_GROUND, Options: possible("Arm"), "In Control": false, Controller: "ana" },
    ] as Partial<Heartbeat>[]) {
      const { stage } = await bar(changes);
      assert.deepEqual(primary(stage), []);
    }
  });

  it("leaves little room to the steps behind", async () => {
    const { stage } = await bar({ Options: IN_AIR });
    assert.deepEqual([...stage.part.querySelectorAll(".act.done b")].map((each) => words(each)), ["Arm", "Take off"]);
  });

  it("gets the focus that its predecessor had", async () => {
    const { rig, stage } = await bar({ ...ON_GROUND, Options: possible("Arm") });
    stage.button("Arm").focus();
    await stage.press("Arm");
    stage.find("hawk-slide").dispatchEvent(new Event("confirmed"));
    await stage.drawn();
    rig.hear({ ...ON_GROUND, State: "Arm", Armed: true, Options: possible("Takeoff") });
    await stage.drawn();
    assert.match(focused(), /^Take off/);
  });

  it("gets the focus of whatever is done with elsewhere on the page", async () => {
    const { rig, stage } = await bar({ ...ON_GROUND, Options: possible("Arm") });
    const strip = document.body.appendChild(document.createElement("button"));
    strip.focus();
    strip.remove();
    rig.hear({ ...ON_GROUND, Options: possible("Arm") });
    await stage.drawn();
    assert.match(focused(), /^Arm/);
  });

  it("takes no focus from elsewhere", async () => {
    const { rig, stage } = await bar({ ...ON_GROUND, Options: possible("Arm") });
    stage.button("Arm").focus();
    stage.button("Arm").blur();
    document.body.dispatchEvent(new Event("pointerdown", { bubbles: true }));
    rig.hear({ ...ON_GROUND, State: "Arm", Armed: true, Options: possible("Takeoff") });
    await stage.drawn();
    assert.doesNotMatch(focused(), /^Take off/);
  });
});

describe("what is heard", () => {
  it("is a lost link in flight, once, and its return", () => {
    const alarms = new Alarms();
    assert.deepEqual(alarms.look(view()), []);
    const lost = view({ link: "closed", silence: 20 });
    assert.deepEqual(alarms.look(lost), ["Link lost."]);
    assert.deepEqual(alarms.look(lost), []);
    assert.deepEqual(alarms.look(view()), ["Link is back."]);
  });

  it("is no lost link on the ground", () => {
    assert.deepEqual(new Alarms().look(view({ link: "closed", silence: 20, heartbeat: heartbeat(ON_GROUND) })), []);
  });

  it("is a low battery, once, and again after it was well", () => {
    const alarms = new Alarms();
    const charged = (charge: number): string[] => alarms.look(view({ heartbeat: heartbeat({ "Battery Percentage": charge }) }));
    assert.deepEqual(charged(40), []);
    assert.deepEqual(charged(28), ["Battery low: 28 %. It soon returns home."]);
    assert.deepEqual(charged(27), []);
    assert.deepEqual(charged(60), []);
    assert.equal(charged(20).length, 1);
  });
});

describe("the stalls as a table", () => {
  it("has free ones first, then the nearest, with place and time", () => {
    const rig = flying({
      "Occupancy Map": mapUpdate({
        Stalls: [
          stall(1, { State: "taken", North: 1, East: 0 }),
          stall(2, { State: "free", North: 30, East: 0 }),
          stall(3, { State: "free", North: 0, East: -12 }),
          stall(4, { State: "unknown", North: 0, East: 5, Seen: 0 }),
        ],
      }),
    });
    const rows = stallRows(rig.operator.map.stalls.values(), { North: 0, East: 0 }, (at) => at, "metres");
    assert.deepEqual(rows.map((row) => row.id), [3, 2, 4, 1]);
    assert.equal(rows[0]?.place, "12 m west of home");
    assert.equal(rows[2]?.seen, "not seen itself");
  });

  it("shows on the map the one that is clicked", async () => {
    const rig = flying({ "Occupancy Map": mapUpdate({ Stalls: [stall(1, { North: 1 }), stall(2, { North: 2 })] }) });
    const stage = new Stage(new StallsTab(), rig.operator);
    await stage.drawn();
    const shown: number[] = [];
    rig.operator.addEventListener("stall", (event) => shown.push((event as CustomEvent<number>).detail));
    await stage.press("Show stall 2 on the map");
    stage.find("tbody tr td").click();
    assert.deepEqual(shown, [2, 1]);
  });

  it("is drawn page by page", async () => {
    const all = Array.from({ length: 120 }, (_, k) => stall(k + 1, { North: k, State: k === 119 ? "suggested" : "free" }));
    const stage = new Stage(new StallsTab(), flying({ "Occupancy Map": mapUpdate({ Stalls: all }) }).operator);
    await stage.drawn();
    const lines = (): number => stage.part.querySelectorAll("tbody tr").length;
    assert.equal(lines(), 50);
    await stage.press("Show more");
    await stage.press("Show more");
    assert.equal(lines(), 120);
    assert.match(stage.text, /119 stalls/, "a suggested one is in no count");
  });
});

describe("tabs and messages", () => {
  it("go on by the arrow keys, with the focus", async () => {
    const stage = new Stage(new Tabs(), flying().operator);
    await stage.drawn();
    const chosen = (): string => words(stage.find('[role="tab"][aria-selected="true"]'));
    assert.equal(chosen(), "Messages");
    stage.find(".tablist").dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowLeft", cancelable: true, bubbles: true }));
    await stage.drawn();
    assert.equal(chosen(), "Settings");
    assert.equal(focused(), "Settings");
    assert.equal(stage.part.querySelectorAll('[role="tab"][tabindex="0"]').length, 1);
  });

  it("stay pressed and focused as what they are when another one comes", async () => {
    const rig = flying();
    const stage = new Stage(new Tabs(), rig.operator);
    await stage.drawn();
    const stalls = stage.button("Stalls");
    rig.hear({ ...ON_GROUND, Checks: [{ Name: "GPS", Passed: true, Value: "", Consequence: "", Remedy: "", "Remedy Command": null }] });
    await stage.drawn();
    assert.equal(words(stage.find('[role="tab"]')), "Checks");
    assert.equal(words(stalls), "Stalls");
    stalls.click();
    await stage.drawn();
    assert.equal(words(stage.find('[role="tab"][aria-selected="true"]')), "Stalls");
  });

  it("say what a filter leaves out, and show all again", async () => {
    const rig = flying({ Messages: [{ Number: 1, Time: "2026-01-02T03:04:05Z", Level: "info", Text: "Took off.", Details: "" }] });
    const stage = new Stage(new MessagesTab(), rig.operator);
    await stage.drawn();
    await stage.press("Warnings");
    assert.match(stage.text, /0 of 1 messages shown/);
    await stage.press("Show all");
    assert.match(stage.text, /Took off\./);
    assert.doesNotMatch(stage.text, /messages shown/);
  });

  it("are seen in a log", async () => {
    const rig = flying();
    rig.server.last.break();
    rig.timers.advance(16_000);
    rig.operator.tick();
    const stage = new Stage(new MessagesTab(), rig.operator);
    await stage.drawn();
    assert.match(words(stage.find('[role="log"]')), /Link lost/);
  });
});
