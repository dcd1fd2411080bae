import "./dom.ts";
import assert from "node:assert/strict";
import { afterEach, beforeEach, describe, it } from "node:test";
import { PlanEditing } from "../src/state/plan-edit.ts";
import { refusal } from "./api.ts";
import { FakeTimers } from "./fakes.ts";
import { PlanStore } from "./plan-store.ts";

const LABELS = ["A 1", "A 2", "A 3", "B 1"];

/** Lets every answer that is under way arrive. */
async function answered(): Promise<void> {
  for (let round = 0; round < 40; round += 1) await new Promise((resolve) => setImmediate(resolve));
}

describe("the editor of a plan", () => {
  const before = globalThis.fetch;
  let store: PlanStore;
  let timers: FakeTimers;
  let toasts: string[];

  beforeEach(() => {
    store = new PlanStore(LABELS);
    timers = new FakeTimers();
    toasts = [];
    globalThis.fetch = store.fetch;
  });

  afterEach(() => {
    globalThis.fetch = before;
  });

  const editor = (who = "Ann"): PlanEditing =>
    new PlanEditing({ who: () => who, changed: () => undefined, showToast: (text) => toasts.push(text), timers });

  const looked = async (who = "Ann"): Promise<PlanEditing> => {
    const editing = editor(who);
    await editing.begin("lot");
    await answered();
    return editing;
  };

  const opened = async (who = "Ann"): Promise<PlanEditing> => {
    const editing = await looked(who);
    await editing.edit();
    await answered();
    return editing;
  };

  it("shows the plan and locks nothing until the first change", async () => {
    const editing = await looked();
    assert.deepEqual([editing.open, editing.mayEdit, editing.own, editing.plan.stalls.size], [true, true, null, 4]);
    editing.undo();
    editing.choose(["A 1"]);
    await answered();
    assert.deepEqual(store.asked, [], "looking, choosing and an undo of nothing are no change");
    const other = await opened("Bob");
    assert.equal(other.own?.who, "Bob");
  });

  it("asks for an edit at the first change, and does what was asked for meanwhile", async () => {
    const editing = await looked();
    editing.do({ do: "remove", stalls: ["A 1"] });
    editing.do({ do: "remove", stalls: ["A 3"] });
    editing.undo();
    await answered();
    assert.deepEqual(store.asked.map(([path]) => path), ["edit", "plan", "plan", "plan/undo"]);
    assert.deepEqual([editing.own?.who, editing.waiting, [...editing.plan.stalls.keys()].sort()], ["Ann", 0, ["A 2", "A 3", "B 1"]]);
  });

  it("keeps the first change while the drone does not answer, and while another person edits", async () => {
    const editing = await looked();
    store.next.push("down");
    editing.do({ do: "remove", stalls: ["A 1"] });
    await answered();
    assert.deepEqual([editing.answers, editing.waiting], [false, 1]);
    const other = await opened("Bob");
    timers.advance(2000);
    await answered();
    assert.deepEqual([editing.other?.who, editing.own, editing.waiting, editing.mayEdit], ["Bob", null, 1, false]);
    await other.close("");
    await editing.ask(true);
    await answered();
    assert.deepEqual([editing.own === null, editing.waiting, editing.plan.get("A 1")], [false, 0, undefined]);
  });

  it("opens an edit again that is its own, or says whose it is", async () => {
    await opened("Bob");
    const editing = await looked();
    assert.deepEqual([editing.other?.who, editing.mayEdit], ["Bob", false]);
  });

  it("says so where the drone does not answer", async () => {
    store.next.push("down");
    const editing = await opened();
    assert.equal(editing.open, false);
    assert.match(toasts[0] ?? "", /the plan could not be read/);
  });

  it("does every step in its order, however quickly they are asked for", async () => {
    const editing = await opened();
    editing.do({ do: "confirm", all: true });
    editing.do({ do: "remove", stalls: ["A 2"] });
    editing.do({ do: "move", stalls: ["A 1"], north: 1, east: 0 });
    editing.undo();
    assert.deepEqual([editing.waiting, editing.plan.stalls.size, editing.plan.get("A 1")?.north], [4, 3, 1], "it is foreseen");
    await answered();
    assert.deepEqual(store.asked.slice(1).map(([path]) => path), ["plan", "plan", "plan", "plan/undo"]);
    assert.deepEqual([editing.waiting, editing.plan.get("A 1")?.north, editing.own?.undo, editing.own?.redo], [0, 0, 2, 1]);
    editing.redo();
    await answered();
    assert.equal(editing.plan.get("A 1")?.north, 1);
  });

  it("joins moves of the same stalls while they wait, and no others", async () => {
    const editing = await opened();
    for (const [stalls, east] of [[["A 1"], 1], [["A 1"], 2], [["A 1"], 4], [["A 2"], 1], [["A 1"], 8]] as const) {
      editing.do({ do: "move", stalls: [...stalls], north: 0, east });
    }
    await answered();
    assert.deepEqual(store.steps.map((each) => (each.do === "move" ? each.east : null)), [1, 6, 1, 8], "the first was sent already");
    assert.equal(editing.plan.get("A 1")?.east, 15);
  });

  it("shows the store's words at a refusal, takes back what was foreseen, and goes on", async () => {
    const editing = await opened();
    store.next.push(refusal(422, "A 1 would overlap A 2", { field: "stalls" }));
    editing.do({ do: "remove", stalls: ["A 1"] });
    editing.do({ do: "remove", stalls: ["A 3"] });
    await answered();
    assert.equal(editing.problem, "stalls: A 1 would overlap A 2");
    assert.deepEqual([...editing.plan.stalls.keys()].sort(), ["A 1", "A 2", "B 1"]);
    editing.do({ do: "confirm", all: true });
    assert.equal(editing.problem, "");
  });

  it("says that nothing is left to undo, and edits on", async () => {
    const editing = await opened();
    editing.undo();
    await answered();
    assert.match(editing.problem, /nothing of it is left/);
    assert.equal(editing.mayEdit, true);
  });

  it("asks again after no answer; what was done is not done twice", async () => {
    const editing = await opened();
    store.next.push("lost");
    editing.do({ do: "move", stalls: ["A 1"], north: 1, east: 0 });
    editing.do({ do: "remove", stalls: ["A 2"] });
    await answered();
    assert.deepEqual([editing.answers, editing.waiting], [false, 2]);
    timers.advance(1000);
    await answered();
    assert.deepEqual([editing.answers, editing.waiting, editing.plan.get("A 1")?.north], [true, 0, 1]);
    assert.deepEqual(store.steps.map((each) => each.do), ["move", "remove"]);
    assert.equal(editing.own?.undo, 2);
  });

  it("does what was not done as soon as the drone answers again", async () => {
    const editing = await opened();
    store.next.push("down", "down");
    editing.do({ do: "remove", stalls: ["A 2"] });
    await answered();
    timers.advance(1000);
    await answered();
    assert.equal(store.steps.length, 0);
    timers.advance(1000);
    await answered();
    assert.deepEqual([store.steps.length, editing.waiting, editing.plan.stalls.size], [1, 0, 3]);
  });

  it("shows what another person changes, who that is, and takes over", async () => {
    store.take("Bob");
    const editing = await opened();
    assert.deepEqual([editing.mayEdit, editing.other?.who], [false, "Bob"]);
    editing.do({ do: "remove", stalls: ["A 2"] });
    assert.equal(editing.waiting, 0, "one who only looks asks for nothing");
    store.change({ do: "remove", stalls: ["A 1"] });
    timers.advance(2000);
    await answered();
    assert.equal(editing.plan.get("A 1"), undefined);
    await editing.ask(true);
    assert.deepEqual([editing.mayEdit, editing.other, store.open?.who], [true, null, "Ann"]);
  });

  it("keeps the steps that another person's edit stopped, and does them after taking over", async () => {
    const editing = await opened();
    store.take("Bob");
    editing.do({ do: "remove", stalls: ["A 2"] });
    editing.do({ do: "remove", stalls: ["A 3"] });
    await answered();
    assert.deepEqual([editing.mayEdit, editing.other?.who, editing.waiting, store.steps.length], [false, "Bob", 2, 0]);
    await editing.ask(true);
    await answered();
    assert.deepEqual([editing.waiting, [...store.stalls.keys()]], [0, ["A 1", "B 1"]]);
  });

  it("notices within two seconds that another person took over, and forgets chosen stalls that went", async () => {
    const editing = await opened();
    editing.choose(["A 1", "A 2"]);
    store.take("Bob");
    store.change({ do: "remove", stalls: ["A 1"] });
    timers.advance(2000);
    await answered();
    assert.deepEqual([editing.mayEdit, editing.other?.who, [...editing.selection]], [false, "Bob", ["A 2"]]);
  });

  it("goes on after the edit was closed elsewhere", async () => {
    const editing = await opened();
    store.open = null;
    editing.do({ do: "remove", stalls: ["A 2"] });
    await answered();
    assert.deepEqual([editing.mayEdit, editing.problem, editing.waiting], [false, "edit: it was closed", 1]);
    await editing.ask(false);
    await answered();
    assert.deepEqual([editing.mayEdit, editing.problem, store.stalls.has("A 2")], [true, "", false]);
  });

  it("closes with a reason once all is done, and says the version", async () => {
    const editing = await opened();
    editing.do({ do: "remove", stalls: ["A 2"] });
    await editing.close("repainted");
    assert.deepEqual(store.asked.at(-1), ["edit/close", { edit: "edit-1", why: "repainted" }]);
    assert.deepEqual([editing.open, toasts], [false, ["The plan is closed as version 2 of the layout."]]);
  });

  it("says that the plan is as it was after an edit without a step", async () => {
    const editing = await opened();
    await editing.close("");
    assert.deepEqual(toasts, ["The plan is as it was."]);
  });

  it("says how many steps are lost with the one who leaves", async () => {
    const editing = await opened();
    store.take("Bob");
    editing.do({ do: "remove", stalls: ["A 2"] });
    await answered();
    editing.leave();
    assert.deepEqual([editing.open, toasts], [false, ["1 change of the plan was not done."]]);
  });

  it("chooses stalls, rows, and no more", async () => {
    const editing = await opened();
    editing.chooseRow("A");
    editing.toggle("B 1");
    editing.toggle("A 2");
    assert.deepEqual(editing.chosen.map(({ label }) => label), ["A 1", "A 3", "B 1"]);
    assert.deepEqual([editing.back(), editing.selection.size, editing.back()], [true, 0, false]);
  });

  it("names many stalls in parts that the store takes", async () => {
    store = new PlanStore(Array.from({ length: 2100 }, (_, index) => `A ${index + 1}`));
    globalThis.fetch = store.fetch;
    const editing = await opened();
    editing.choose(editing.plan.stalls.keys());
    editing.doChosen((stalls) => ({ do: "confirm", stalls }));
    await answered();
    assert.deepEqual(store.steps.map((each) => ("stalls" in each ? each.stalls.length : 0)), [1000, 1000, 100]);
  });
});

describe("a row that is drawn on a plan", () => {
  const before = globalThis.fetch;
  const store = new PlanStore(LABELS);
  globalThis.fetch = store.fetch;
  afterEach(() => {
    globalThis.fetch = before;
  });

  it("is added by three places, with the count that was typed", async () => {
    globalThis.fetch = store.fetch;
    const editing = new PlanEditing({ who: () => "Ann", changed: () => undefined, showToast: () => undefined, timers: new FakeTimers() });
    await editing.begin("lot");
    const { drawing } = editing;
    drawing.use("row");
    drawing.add([-20, 0]);
    drawing.pointer = [-20, 10];
    assert.deepEqual([drawing.row?.count, drawing.rowStalls.length, drawing.isWhole], [4, 4, false]);
    drawing.add([-20, 10]);
    drawing.add([-25, 4]);
    drawing.set({ count: "3", double: false, style: "angled", lean: "30", kind: "disabled" });
    assert.equal(drawing.isWhole, true);
    drawing.finish();
    await answered();
    const lean = Math.PI / 6;
    const wanted = { do: "add_row", front: [[-20, 0], [-20, 10]], far: [-25, 4], count: 3, lean, kind: "disabled" };
    assert.deepEqual(store.steps, [wanted]);
    assert.deepEqual([drawing.places, drawing.count, drawing.tool], [[], "", "row"]);
  });

  it("is taken back place by place, then the tool", async () => {
    globalThis.fetch = store.fetch;
    const editing = new PlanEditing({ who: () => "Ann", changed: () => undefined, showToast: () => undefined, timers: new FakeTimers() });
    await editing.begin("lot");
    editing.drawing.use("area");
    editing.drawing.add([0, 0]);
    assert.deepEqual([editing.back(), editing.back(), editing.drawing.tool, editing.back()], [true, true, "choose", false]);
  });
});
