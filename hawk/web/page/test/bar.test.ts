import "./dom.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import type { CheckItem, Heartbeat } from "../src/protocol.ts";
import { CELL } from "../src/state/tile-data.ts";
import { ActionBar } from "../src/ui/action-bar.ts";
import { leaveByEscape } from "../src/ui/escape.ts";
import { MoreActions } from "../src/ui/more-actions.ts";
import { MoveFields } from "../src/ui/move-fields.ts";
import { impossible, possible } from "./make.ts";
import { flying, type Rig, type Sent } from "./rig.ts";
import { Frames, Stage, words } from "./stage.ts";

const ON_GROUND: Partial<Heartbeat> = { State: "Idle", Armed: false, Landed: "ON_GROUND", "Relative Altitude": 0 };
const IN_AIR = possible("Autonomous Explore", "Autonomous Move", "Compulsive Move", "Return To Launch", "Land", "Hold");
const SQUARE = [
  { North: -50, East: -50 },
  { North: -50, East: 50 },
  { North: 50, East: 50 },
  { North: 50, East: -50 },
];

function failing(name: string, remedy: CheckItem["Remedy Command"] = null): CheckItem {
  return { Name: name, Passed: false, Value: "", Consequence: "", Remedy: "", "Remedy Command": remedy };
}

async function bar(changes: Partial<Heartbeat> = {}): Promise<{ rig: Rig; stage: Stage<ActionBar> }> {
  const rig = flying(changes);
  const part = new ActionBar();
  part.classAt = () => CELL.lot;
  const stage = new Stage(part, rig.operator);
  await stage.drawn();
  return { rig, stage };
}

function reason(stage: Stage<ActionBar>, name: string): string {
  return words(stage.button(name).querySelector(".sub")!);
}

describe("the bar", () => {
  it("offers on the ground what the drone offers, and says why the rest is impossible", async () => {
    const options = [...possible("Arm"), impossible("Takeoff", "Arm first."), impossible("Land", "It is on the ground.")];
    const { stage } = await bar({ ...ON_GROUND, Options: options });
    assert.deepEqual(stage.enabled(), ["More actions", "Arm"]);
    assert.equal(reason(stage, "Take off"), "Arm first");
    assert.equal(reason(stage, "Hold"), "On the ground");
    assert.equal(reason(stage, "Land"), "It is on the ground");
  });

  it("keeps the motors off while a check fails: Arm shows the checks", async () => {
    const { rig, stage } = await bar({ ...ON_GROUND, Checks: [failing("GPS")], Options: [impossible("Arm", "GPS.")] });
    const opened: string[] = [];
    stage.part.addEventListener("open-panel", (event) => opened.push((event as CustomEvent<string>).detail));
    assert.equal(reason(stage, "Arm"), "1 check failed");
    await stage.press("Arm");
    assert.deepEqual([opened, rig.sent(), rig.operator.question], [["checks"], [], null]);
  });

  it("sends what is pressed, once", async () => {
    const { rig, stage } = await bar({ Options: IN_AIR });
    await stage.press("Return home");
    await stage.press("Hold");
    assert.deepEqual(rig.sent().map((each) => each.Type), ["Return To Launch", "Hold"]);
  });

  it("asks before the motors start or it flies by itself: a click sends nothing, the slide does", async () => {
    for (const [name, changes, question, type] of [
      ["Arm", { ...ON_GROUND, Options: possible("Arm") }, "Start the motors?", "Arm"],
      ["Take off", { ...ON_GROUND, State: "Arm", Armed: true, Options: possible("Takeoff") }, "Take off to 35 m?", "Takeoff"],
      ["Explore", { Options: IN_AIR }, "Explore the whole lot?", "Autonomous Explore"],
    ] as [string, Partial<Heartbeat>, string, string][]) {
      const { rig, stage } = await bar(changes);
      stage.button(name).focus();
      await stage.press(name);
      assert.deepEqual(rig.sent(), [], name);
      assert.ok(stage.text.includes(question), stage.text);
      assert.equal(document.activeElement, stage.find("button.slide"), "by keyboard the slide is next");
      stage.find("hawk-slide").dispatchEvent(new Event("confirmed"));
      await stage.drawn();
      assert.deepEqual(rig.sent().map(({ Type, Confirmed }) => [Type, Confirmed]), [[type, undefined]]);
      assert.equal(stage.has("hawk-confirm"), false);
    }
  });

  it("shows the checks from the list of a low page, too", async () => {
    const rig = flying({ ...ON_GROUND, Checks: [failing("GPS")], Options: [impossible("Arm", "GPS.")] });
    const stage = new Stage(new MoreActions(), rig.operator);
    const opened: string[] = [];
    stage.part.addEventListener("open-panel", (event) => opened.push((event as CustomEvent<string>).detail));
    await stage.drawn();
    await stage.press("Arm");
    assert.deepEqual([opened, rig.operator.question], [["checks"], null]);
  });

  it("asks the same from the list of a low page", async () => {
    const rig = flying({ Options: IN_AIR });
    const stage = new Stage(new MoreActions(), rig.operator);
    await stage.drawn();
    await stage.press("Explore");
    assert.deepEqual([rig.sent(), rig.operator.question], [[], { about: "Autonomous Explore" }]);
  });

  it("keeps the slide shut once the drone would refuse it, and says why", async () => {
    const { rig, stage } = await bar({ ...ON_GROUND, Options: possible("Arm") });
    await stage.press("Arm");
    rig.hear({ ...ON_GROUND, Options: [impossible("Arm", "Battery: 9 %.")] });
    await stage.drawn();
    assert.match(stage.text, /Battery: 9 %\./);
    assert.equal((stage.find("button.slide") as HTMLButtonElement).disabled, true);
    stage.find("hawk-slide").dispatchEvent(new Event("confirmed"));
    assert.deepEqual(rig.sent(), []);
  });

  it("opens and shuts with what the drone says", async () => {
    const { rig, stage } = await bar({ Options: IN_AIR });
    assert.equal(stage.button("Explore").disabled, false);
    rig.hear({ State: "Autonomous Explore", Options: possible("Hold"), Explored: 0.4 });
    await stage.drawn();
    assert.equal(stage.button("Explore").disabled, true);
    assert.equal(stage.button("Explore").getAttribute("aria-pressed"), "true");
    assert.equal(stage.button("Hold").disabled, false);
  });

  it("without a link offers nothing that cannot arrive", async () => {
    const { rig, stage } = await bar({ Options: IN_AIR });
    rig.server.last.break();
    await stage.drawn();
    assert.deepEqual(stage.enabled(), ["More actions"]);
    assert.equal(reason(stage, "Hold"), "No link");
    assert.equal(reason(stage, "Return home"), "No link: does it itself");
  });

  it("lets those who watch Hold and ask for control, and nothing else", async () => {
    const { rig, stage } = await bar({ "In Control": false, Options: possible("Hold", "Land") });
    assert.deepEqual(stage.enabled(), ["Ask for control", "Hold"]);
    assert.equal(reason(stage, "Land"), "Someone else has control");
    await stage.press("Ask for control");
    await stage.press("Hold");
    assert.deepEqual(rig.sent().map((each) => [each.Type, each.Action]), [["Control", "Ask"], ["Hold", undefined]]);
  });

  it("lets anyone bring home and land a drone that nobody has control of", async () => {
    const { stage } = await bar({ "In Control": false, Controller: null, Options: possible("Hold", "Land", "Return To Launch") });
    assert.deepEqual(stage.enabled(), ["Return home", "Take control", "Land", "Hold"]);
  });

  it("lets anyone bring home, land and take over a drone whose operator is lost", async () => {
    const { rig, stage } = await bar({
      "In Control": false,
      "Controller Lost": true,
      Options: possible("Hold", "Land", "Return To Launch"),
    });
    assert.match(stage.text, /The operator in control is lost\./);
    assert.deepEqual(stage.enabled(), ["Return home", "Take control", "Land", "Hold"]);
    await stage.press("Land");
    await stage.press("Take control");
    assert.deepEqual(rig.sent().map((each) => [each.Type, each.Action]), [["Land", undefined], ["Control", "Request"]]);
  });

  it("shows the one who was lost who has control now", async () => {
    const { rig, stage } = await bar({ "In Control": false, Controller: "Operator 2", "Control Taken By": "Operator 2" });
    assert.match(stage.text, /Operator 2 has control\.\s*It was taken: you were lost, or did not answer\./);
    assert.equal(rig.operator.toasts.shown?.text, "Operator 2 took control: you were lost, or did not answer.");
    rig.operator.toasts.dismiss();
    rig.hear({ "In Control": false, Controller: "Operator 2", "Control Taken By": "Operator 2" });
    assert.equal(rig.operator.toasts.shown, null, "shown once");
  });

  it("asks first when a pilot would be overruled", async () => {
    const { rig, stage } = await bar({ State: "Manual", Options: possible("Land", "Resume", "Return To Launch") });
    for (const [name, question] of [
      ["Land", "Land straight down?"],
      ["Return home", "Return home and land there?"],
      ["Resume", "Resume, taking over from the remote control?"],
    ] as const) {
      await stage.press(name);
      assert.match(stage.text, new RegExp(question.replace("?", "\\?")));
      await stage.press("Cancel");
    }
    assert.deepEqual(rig.sent(), []);
  });
});

describe("the remedy of a failed check", () => {
  const FAILSAFES = failing("Failsafe", "Set Failsafes");
  const offered = (...commands: string[]): Partial<Heartbeat> => ({ Options: [...possible(...commands), impossible("Arm", "Failsafe: off.")] });

  it("is the bar's primary button, before Arm, and sends its command", async () => {
    const checks = [failing("GPS"), FAILSAFES, failing("Link", "Set Failsafes")];
    const { rig, stage } = await bar({ ...ON_GROUND, Checks: checks, ...offered("Set Failsafes") });
    assert.deepEqual([...stage.part.querySelectorAll(".act.primary")].map((each) => words(each)), ["Set failsafes Mends 2 failed checks"]);
    assert.deepEqual(stage.enabled(), ["More actions", "Set failsafes", "Arm"]);
    await stage.press("Set failsafes");
    assert.deepEqual(rig.sent().map((each) => each.Type), ["Set Failsafes"]);
  });

  it("is on the narrowest bar, where Arm alone was", async () => {
    const { stage } = await bar({ ...ON_GROUND, Checks: [FAILSAFES], ...offered("Set Failsafes") });
    const first = stage.part.querySelectorAll(".act.first:not(.more)");
    assert.deepEqual([...first].map((each) => words(each.querySelector("b")!)), ["Set failsafes"]);
    assert.equal(stage.part.querySelectorAll(".act.key").length, 3, "no more than there is room for");
  });

  it("allows arming after a cut, and opens the editor of the fence", async () => {
    const cut = await bar({ ...ON_GROUND, Checks: [failing("Kill", "Clear Kill")], ...offered("Clear Kill") });
    await cut.stage.press("Allow arming again");
    assert.deepEqual(cut.rig.sent().map((each) => each.Type), ["Clear Kill"]);
    const fence = await bar({ ...ON_GROUND, Checks: [failing("Fence", "Set Fence")], ...offered("Set Fence") });
    const opened: string[] = [];
    fence.stage.part.addEventListener("open-panel", (event) => opened.push((event as CustomEvent<string>).detail));
    await fence.stage.press("Draw the fence");
    assert.deepEqual([opened, fence.rig.sent()], [["fence"], []]);
  });

  it("is passed over while the drone would refuse it, and is a look at the checks where no command mends one", async () => {
    const { rig, stage } = await bar({
      ...ON_GROUND,
      Checks: [FAILSAFES, failing("Kill", "Clear Kill")],
      Options: [impossible("Set Failsafes", "They are being set."), ...possible("Clear Kill")],
    });
    assert.deepEqual([...stage.part.querySelectorAll(".act.primary b")].map((each) => words(each)), ["Allow arming again"]);
    rig.hear({ Checks: [failing("GPS"), failing("Battery")], Options: [impossible("Arm", "GPS.")] });
    await stage.drawn();
    assert.deepEqual([...stage.part.querySelectorAll(".act.primary")].map((each) => words(each)), ["Show checks 2 failed: what to do"]);
  });

  it("shows the checks to a finger that was moving when it became another one", async () => {
    const { rig, stage } = await bar({ ...ON_GROUND, Checks: [failing("GPS")], Options: [impossible("Arm", "GPS.")] });
    const opened: string[] = [];
    stage.part.addEventListener("open-panel", (event) => opened.push((event as CustomEvent<string>).detail));
    rig.hear({ Checks: [failing("GPS"), FAILSAFES], ...offered("Set Failsafes") });
    await stage.drawn();
    rig.timers.advance(300);
    await stage.press("Set failsafes");
    assert.deepEqual([opened.length, rig.sent()], [1, []]);
    rig.timers.advance(600);
    await stage.press("Set failsafes");
    assert.deepEqual(rig.sent().map((each) => each.Type), ["Set Failsafes"]);
  });

  it("is nothing in flight, nor for those who watch", async () => {
    for (const changes of [{ Checks: [FAILSAFES] }, { ...ON_GROUND, "In Control": false, Controller: null, Checks: [FAILSAFES] }]) {
      const { stage } = await bar({ ...changes, ...offered("Set Failsafes") });
      assert.equal(stage.has('[data-action="remedy"]'), false);
    }
  });

  it("hands the focus on: from Take control to it, from it to Arm", async () => {
    const grounded = { ...ON_GROUND, Checks: [FAILSAFES], ...offered("Set Failsafes") };
    const { rig, stage } = await bar({ ...grounded, "In Control": false, Controller: null });
    stage.button("Take control").focus();
    rig.hear({ "In Control": true, Controller: "Ana" });
    await stage.drawn();
    assert.match(words(document.activeElement!), /^Set failsafes/);
    rig.hear({ "In Control": true, Controller: "Ana", Checks: [], Options: possible("Arm") });
    await stage.drawn();
    assert.match(words(document.activeElement!), /^Arm/);
  });
});

describe("motors that went off before take-off", () => {
  const armed = { ...ON_GROUND, State: "Arm", Armed: true, Options: possible("Takeoff", "Disarm") };
  const idle = { ...ON_GROUND, Options: [...possible("Arm"), impossible("Takeoff", "Arm first.")] };

  it("are explained where Take off is refused", async () => {
    const { rig, stage } = await bar(armed);
    rig.hear(idle);
    await stage.drawn();
    assert.equal(reason(stage, "Take off"), "The motors went off by themselves: Arm again");
    assert.match(rig.operator.toasts.shown?.text ?? "", /^The motors went off by themselves/);
    assert.match(rig.operator.flight.lines[0]?.text ?? "", /^The motors went off by themselves/);
    rig.hear(armed);
    rig.hear({ ...idle, Killed: true });
    await stage.drawn();
    assert.equal(reason(stage, "Take off"), "Arm first");
  });

  it("are no news to the one who switched them off", async () => {
    const { rig, stage } = await bar(armed);
    await stage.press("Disarm");
    rig.hear(idle);
    await stage.drawn();
    assert.equal(reason(stage, "Take off"), "Arm first");
  });
});

describe("a move by typed metres", () => {
  async function typing(changes: Partial<Heartbeat> = {}): Promise<{ rig: Rig; stage: Stage<MoveFields>; type: (field: string, text: string) => void; set: () => Promise<void> }> {
    const rig = flying({ Options: IN_AIR, Fence: SQUARE, North: 10, East: -5, Home: { North: 2, East: 3 }, ...changes });
    const stage = new Stage(new MoveFields(), rig.operator);
    await stage.drawn();
    assert.equal(stage.text, "", "nothing is asked before Move");
    rig.operator.pick(true);
    await stage.drawn();
    await stage.press("Or type how far");
    const type = (field: string, text: string): void => {
      stage.input(`input[name=${field}]`).value = text;
      stage.find(`input[name=${field}]`).dispatchEvent(new Event("input"));
    };
    const set = async (): Promise<void> => {
      stage.find("form").dispatchEvent(new Event("submit", { cancelable: true }));
      await stage.drawn();
    };
    return { rig, stage, type, set };
  }

  it("asks for the place so far north and east of the drone", async () => {
    const { rig, type, set } = await typing();
    type("north", "-12,5");
    type("east", "7");
    await set();
    assert.deepEqual(rig.operator.question, { about: "move", target: { North: -2.5, East: 2 } });
    assert.deepEqual(orders(rig), [], "nothing flies before the slide");
  });

  it("goes from where it was armed, at a height of its own, straight", async () => {
    const { rig, stage, type, set } = await typing();
    const from = stage.find("select") as HTMLSelectElement;
    from.value = "home";
    from.dispatchEvent(new Event("change"));
    type("north", "10");
    type("height", "25");
    await set();
    assert.deepEqual(rig.operator.question, { about: "move", target: { North: 12, East: 3 }, height: 25, kind: "Compulsive Move" });
    const part = new ActionBar();
    part.classAt = () => CELL.lot;
    const bars = new Stage(part, rig.operator);
    await bars.drawn();
    assert.match(bars.text, /sinking to 25 m/);
    assert.equal(bars.part.querySelectorAll<HTMLInputElement>("input[type=radio]")[0]?.disabled, true);
    bars.find("hawk-slide").dispatchEvent(new Event("confirmed"));
    const [{ Type, X, Y, Frame, Height }] = orders(rig) as [Sent];
    assert.deepEqual([Type, X, Y, Frame, Height], ["Compulsive Move", 12, 3, "Map", 25]);
  });

  it("names the field that is wrong, and asks nothing", async () => {
    const { rig, stage, type, set } = await typing();
    await set();
    assert.match(stage.text, /North, East: give a number/);
    type("north", "ten");
    await set();
    assert.match(stage.text, /North, East: give a number/);
    type("north", "10");
    type("height", "500");
    await set();
    assert.match(stage.text, /Height: give a number from/);
    assert.equal(rig.operator.question, null);
  });

  it("is refused outside the fence like any other place", async () => {
    const { rig, type, set } = await typing();
    type("east", "90");
    await set();
    const part = new ActionBar();
    part.classAt = () => CELL.lot;
    const bars = new Stage(part, rig.operator);
    await bars.drawn();
    assert.match(bars.text, /Outside the fence/);
    assert.equal((bars.find("button.slide") as HTMLButtonElement).disabled, true);
  });
});

/** What was sent to be done: asking for the route there does nothing. */
function orders(rig: Rig): Sent[] {
  return rig.sent().filter((each) => each.Type !== "Route Request");
}

describe("the confirm bar", () => {
  async function asked(changes: Partial<Heartbeat> = {}): Promise<{ rig: Rig; stage: Stage<ActionBar> }> {
    const made = await bar({ Options: IN_AIR, Fence: SQUARE, ...changes });
    made.rig.operator.ask({ about: "move", target: { North: 0, East: 30 } });
    await made.stage.drawn();
    return made;
  }

  it("stands in for the guided actions and leaves Land and Hold in reach", async () => {
    const { rig, stage } = await asked();
    assert.match(stage.text, /Move 30 m east/);
    assert.equal(stage.has("[data-action]"), false);
    await stage.press("Hold");
    assert.deepEqual(orders(rig).map((each) => each.Type), ["Hold"]);
  });

  it("sends nothing before the slide is at its end", async () => {
    const { rig, stage } = await asked();
    await stage.press("Cancel");
    assert.deepEqual(orders(rig), []);
    assert.equal(stage.has("hawk-confirm"), false);
  });

  it("moves inside the lot where there is lot, else where it is chosen", async () => {
    const { rig, stage } = await asked();
    stage.find("hawk-slide").dispatchEvent(new Event("confirmed"));
    rig.operator.ask({ about: "move", target: { North: 0, East: 30 } });
    await stage.drawn();
    const [, anywhere] = stage.part.querySelectorAll<HTMLInputElement>("input[type=radio]");
    anywhere!.checked = true;
    anywhere!.dispatchEvent(new Event("change"));
    await stage.drawn();
    stage.find("hawk-slide").dispatchEvent(new Event("confirmed"));
    assert.deepEqual(
      orders(rig).map(({ Type, X, Y, Frame }) => [Type, X, Y, Frame]),
      [["Autonomous Move", 0, 30, "Map"], ["Compulsive Move", 0, 30, "Map"]],
    );
  });

  it("refuses a place outside the fence: its slide does not move", async () => {
    const { rig, stage } = await asked();
    rig.operator.ask({ about: "move", target: { North: 0, East: 90 } });
    await stage.drawn();
    assert.match(stage.text, /Outside the fence/);
    assert.equal((stage.find("button.slide") as HTMLButtonElement).disabled, true);
    stage.find("hawk-slide").dispatchEvent(new Event("confirmed"));
    assert.deepEqual(orders(rig), []);
  });

  it("no longer runs a kind of move that the drone withdrew after it was chosen", async () => {
    const { rig, stage } = await asked();
    const [, anywhere] = stage.part.querySelectorAll<HTMLInputElement>("input[type=radio]");
    anywhere!.dispatchEvent(new Event("change"));
    rig.hear({ Options: [...possible("Autonomous Move"), impossible("Compulsive Move", "No position.")] });
    await stage.drawn();
    assert.match(stage.text, /No position\./);
    stage.find("hawk-slide").dispatchEvent(new Event("confirmed"));
    assert.deepEqual(orders(rig), []);
  });

  it("opens for a place on the map only after Move; while it is open another place takes the first one's place", async () => {
    const { rig, stage } = await bar({ Options: IN_AIR, Fence: SQUARE });
    assert.equal(rig.operator.pointAt({ North: 0, East: 30 }, false), false);
    await stage.drawn();
    assert.equal(stage.has("hawk-confirm"), false, "a plain click opens nothing");
    await stage.press("Move");
    assert.equal(rig.operator.pointAt({ North: 0, East: 30 }, true), true);
    assert.equal(rig.operator.pointAt({ North: 0, East: 20 }, true), false, "a stall is looked at");
    assert.equal(rig.operator.pointAt({ North: 0, East: 10 }, false), true);
    await stage.drawn();
    assert.match(stage.text, /Move 10 m east/);
    rig.operator.ask({ about: "Autonomous Explore" });
    assert.equal(rig.operator.pointAt({ North: 0, East: 10 }, false), false, "another question stays");
    assert.deepEqual(rig.operator.question, { about: "Autonomous Explore" });
  });

  it("ends a press of Enter when another place takes the first one's place", async () => {
    const frames = new Frames();
    const { rig, stage } = await asked();
    stage.find("button.slide").dispatchEvent(new KeyboardEvent("keydown", { key: "Enter", bubbles: true }));
    frames.advance(500);
    rig.operator.pointAt({ North: 0, East: 10 }, false);
    await stage.drawn();
    frames.advance(2000);
    assert.deepEqual(orders(rig), []);
  });

  it("is left by Escape wherever the focus is, as the cut and the pointing are; a dialog's own Escape leaves it open", async () => {
    const { rig } = await asked();
    let closed = 0;
    const escape = (prevented = false): void => {
      const event = new KeyboardEvent("keydown", { key: "Escape", cancelable: true });
      if (prevented) event.preventDefault();
      leaveByEscape(event, rig.operator, () => (closed += 1));
    };
    escape(true);
    assert.equal(rig.operator.question?.about, "move");
    void rig.operator.cut.begin();
    escape();
    assert.deepEqual([rig.operator.cut.current, rig.operator.question], [null, { about: "move", target: { North: 0, East: 30 } }], "the innermost first");
    escape();
    assert.equal(rig.operator.question, null);
    rig.operator.pick(true);
    escape();
    assert.deepEqual([rig.operator.picking, closed], [false, 0]);
    escape();
    assert.equal(closed, 1);
    assert.deepEqual(orders(rig).map((each) => each.Type), ["Kill Request"]);
  });

  it("goes away when the state changes under it", async () => {
    const { rig, stage } = await asked();
    rig.hear({ State: "Return To Launch" });
    await stage.drawn();
    assert.equal(stage.has("hawk-confirm"), false);
  });

  it("says to the drone that overruling the pilot was confirmed", async () => {
    const { rig, stage } = await bar({ State: "Manual", Options: possible("Land", "Resume") });
    await stage.press("Land");
    stage.find("hawk-slide").dispatchEvent(new Event("confirmed"));
    await stage.drawn();
    assert.deepEqual(orders(rig).map(({ Type, Confirmed }) => [Type, Confirmed]), [["Land", true]]);
  });

  it("is confirmed by Enter kept pressed for a second, not by a tap on it", async () => {
    const frames = new Frames();
    const { rig, stage } = await asked();
    const slide = stage.find("button.slide");
    const key = (type: string) => slide.dispatchEvent(new KeyboardEvent(type, { key: "Enter", bubbles: true }));
    key("keydown");
    frames.advance(900);
    key("keyup");
    frames.advance(900);
    assert.deepEqual(orders(rig), []);
    key("keydown");
    frames.advance(500);
    frames.advance(600);
    assert.deepEqual(orders(rig).map((each) => each.Type), ["Autonomous Move"]);
  });
});
