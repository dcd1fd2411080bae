import "./dom.ts";
import assert from "node:assert/strict";
import { afterEach, beforeEach, describe, it } from "node:test";
import type { Operator } from "../src/state/operator.ts";
import { labelByKey } from "../src/state/plan-labels.ts";
import { undoByKey } from "../src/ui/plan-keys.ts";
import { PlanPanel } from "../src/ui/plan-panel.ts";
import { PlanTools } from "../src/ui/plan-tools.ts";
import { refusal } from "./api.ts";
import { settle } from "./fakes.ts";
import { PlanStore } from "./plan-store.ts";
import { flying, type Rig } from "./rig.ts";
import { Stage } from "./stage.ts";

async function answered(): Promise<void> {
  for (let round = 0; round < 20; round += 1) await settle();
}

describe("the parts of the plan's editor", () => {
  const before = globalThis.fetch;
  let store: PlanStore;
  let rig: Rig;
  let model: Operator;
  let stage: Stage<PlanPanel>;

  const open = async (): Promise<void> => {
    rig = flying();
    model = rig.operator;
    model.prefer({ name: "Ann" });
    model.editPlan("lot");
    await answered();
    stage = new Stage(new PlanPanel(), model);
    await stage.drawn();
  };

  beforeEach(() => {
    store = new PlanStore(["A 1", "A 2", "B 1"]);
    globalThis.fetch = store.fetch;
  });

  afterEach(() => {
    model.plan.leave();
    globalThis.fetch = before;
  });

  const type = async (name: string, value: string): Promise<void> => {
    const field = stage.input(`[name=${name}]`);
    field.value = value;
    field.dispatchEvent(new Event(field.tagName === "SELECT" ? "change" : "input"));
    await stage.drawn();
  };
  const submit = async (name: string): Promise<void> => {
    stage.input(`[name=${name}]`).closest("form")?.dispatchEvent(new Event("submit", { cancelable: true }));
    await answered();
    await stage.drawn();
  };
  const press = async (name: string): Promise<void> => {
    await stage.press(name);
    await answered();
    await stage.drawn();
  };

  it("say whose plan it is, and who edits it", async () => {
    await open();
    assert.match(stage.text, /Plan of Lot 1\s?3 stalls, 0 confirmed/);
    assert.match(stage.text, /Nobody edits\. Your first change begins an edit\./);
    assert.equal(stage.has(".closing"), false);
    assert.match(stage.text, /Click a stall, with Shift several/);
    assert.match(stage.text, /No stall is chosen/);
    await press("Confirm all");
    assert.match(stage.text, /You edit since/);
    assert.equal(stage.has(".closing"), true);
  });

  it("are left alone while another person edits, but for taking over", async () => {
    store.take("Bob");
    await open();
    assert.match(stage.text, /Bob edits since/);
    assert.equal(stage.has("hawk-plan-chosen"), false);
    const tools = new Stage(new PlanTools(), model);
    await tools.drawn();
    assert.deepEqual(tools.enabled(), []);
    stage = new Stage(new PlanPanel(), model);
    await stage.drawn();
    await press("Take over");
    assert.match(stage.text, /You edit since/);
  });

  it("confirm all, or a row that is chosen by its letter", async () => {
    await open();
    await type("row", "A");
    assert.match(stage.text, /2 stalls are chosen/);
    await press("Confirm");
    assert.deepEqual(store.steps, [{ do: "confirm", stalls: ["A 1", "A 2"] }]);
    await type("row", "");
    await press("Confirm all");
    assert.deepEqual(store.steps[1], { do: "confirm", all: true });
  });

  it("remove what is chosen, and choose nothing then", async () => {
    await open();
    await type("row", "A");
    await press("Remove");
    assert.deepEqual([...store.stalls.keys()], ["B 1"]);
    assert.match(stage.text, /No stall is chosen/);
  });

  it("set kind, size, angle and numbers of what is chosen", async () => {
    await open();
    await type("row", "A");
    await type("kind", "charging");
    await type("width", "2,3");
    await type("length", "4.8");
    await submit("width");
    await type("turn", "-90");
    await submit("turn");
    await type("letter", "c");
    await type("first", "7");
    await submit("letter");
    const stalls = ["A 1", "A 2"];
    assert.deepEqual(store.steps, [
      { do: "set_kind", stalls, kind: "charging" },
      { do: "widen", stalls, width: 2.3, length: 4.8 },
      { do: "turn", stalls, by: -Math.PI / 2, about: "middle" },
      { do: "renumber", stalls, letter: "C", first: 7 },
    ]);
  });

  it("say of a label whether it is as painted or our guess", async () => {
    await open();
    assert.match(stage.text, /3 stalls, 0 confirmed; 3 labels are our guess/);
    await type("row", "B");
    assert.match(stage.text, /B 1 is chosen our guess/);
    await press("Confirm");
    assert.match(stage.text, /B 1 is chosen as painted/);
    await type("row", "*");
    assert.match(stage.text, /3 stalls are chosen 2 of 3 labels are our guess/);
    assert.match(stage.text, /3 stalls, 1 confirmed; 2 labels are our guess/);
  });

  it("name, swap, reverse and shift rows by button", async () => {
    await open();
    await type("row", "A");
    assert.equal(stage.button("Swap names").disabled, true);
    await press("Number from the other end");
    await press("Numbers +1");
    await press("Numbers −1");
    await type("to", " Nord ");
    await submit("to");
    model.plan.choose(["A 1", "B 1"]);
    await stage.drawn();
    await press("Swap names");
    assert.deepEqual(store.steps, [
      { do: "reverse", row: "A" },
      { do: "shift", row: "A", by: 1 },
      { do: "shift", row: "A", by: -1 },
      { do: "rename", row: "A", to: "Nord" },
      { do: "swap", rows: ["B", "Nord"] },
    ]);
    assert.match(stage.text, /3 stalls, 0 confirmed$|3 stalls, 0 confirmed /);
    model.plan.undo();
    await answered();
    assert.deepEqual([...store.stalls.values()].map(({ label }) => label), ["Nord 1", "Nord 2", "B 1"]);
  });

  it("name, swap, reverse and shift rows by key", async () => {
    await open();
    for (const key of ["x", "i", "n", "PageUp"]) assert.equal(labelByKey(key, model.plan), true);
    await answered();
    assert.deepEqual(store.steps, []);
    model.plan.choose(["A 1"]);
    for (const key of ["I", "x", "PageUp", "PageDown"]) labelByKey(key, model.plan);
    await answered();
    const stalls = ["A 1"];
    assert.deepEqual(store.steps, [
      { do: "reverse", stalls },
      { do: "shift", stalls, by: 1 },
      { do: "shift", stalls, by: -1 },
    ]);
    labelByKey("N", model.plan);
    await stage.drawn();
    assert.equal(document.activeElement?.getAttribute("name"), "to");
    assert.equal(labelByKey("q", model.plan), false);
  });

  it("split a single stall, and none of several", async () => {
    await open();
    await type("row", "A");
    assert.equal(stage.has("[name=parts]"), false);
    await type("row", "B");
    await type("parts", "3");
    await submit("parts");
    assert.deepEqual(store.steps, [{ do: "split", stall: "B 1", parts: 3 }]);
  });

  it("take feet where the page has them, and say what is no number", async () => {
    await open();
    model.prefer({ units: "feet" });
    await type("row", "B");
    await type("width", "8");
    await submit("width");
    assert.deepEqual(store.steps[0], { do: "widen", stalls: ["B 1"], width: 2.44, length: 5 });
    await type("turn", "much");
    await submit("turn");
    assert.match(stage.text, /Turn by, °: give a number/);
    assert.equal(store.steps.length, 1);
  });

  it("show the store's words", async () => {
    await open();
    store.next.push(refusal(422, "<b>A 1</b> would overlap", { field: "stalls" }));
    await press("Confirm all");
    assert.match(stage.text, /stalls: <b>A 1<\/b> would overlap/);
    assert.equal(stage.find("p.problem").querySelector("b"), null);
  });

  it("add a row with what is typed, and take places back", async () => {
    await open();
    model.plan.drawing.use("row");
    await stage.drawn();
    assert.match(stage.text, /Click one end of the row's front/);
    for (const place of [[-20, 0], [-20, 10], [-25, 3]] as const) model.plan.drawing.add(place);
    await stage.drawn();
    assert.match(stage.text, /Count; 4 by the pitch/);
    await type("count", "5");
    await press("Take back a place");
    assert.equal(stage.button("Add row").disabled, true);
    model.plan.drawing.add([-25.5, 3]);
    await stage.drawn();
    await press("Add 5 stalls");
    assert.deepEqual(store.steps, [{ do: "add_row", front: [[-20, 0], [-20, 10]], far: [-25.5, 3], count: 5, kind: "" }]);
  });

  it("add an area without stalls by its corners and a name", async () => {
    await open();
    model.plan.drawing.use("area");
    for (const place of [[0, 0], [0, 9], [9, 9]] as const) model.plan.drawing.add(place);
    await stage.drawn();
    await type("area", "Island");
    await submit("area");
    assert.deepEqual(store.steps, [{ do: "forbid", outline: [[0, 0], [0, 9], [9, 9]], name: "Island" }]);
  });

  it("draw private ground as such an area, and say so of it", async () => {
    await open();
    model.plan.drawing.use("area");
    for (const place of [[0, 0], [0, 9], [9, 9]] as const) model.plan.drawing.add(place);
    await stage.drawn();
    stage.input("[name=private]").checked = true;
    await submit("area");
    assert.deepEqual(store.steps, [{ do: "forbid", outline: [[0, 0], [0, 9], [9, 9]], name: "", private: true }]);
    model.plan.plan.zones = [{ id: "z", name: "Garden", outline: [[0, 0], [0, 9], [9, 9]], kind: "private_ground" }];
    model.plan.drawAgain();
    await stage.drawn();
    assert.match(stage.text, /Garden · private ground/);
  });

  it("draw a zone by its corners, a name and a kind, and erase it", async () => {
    await open();
    model.plan.drawing.use("zone");
    await stage.drawn();
    assert.match(stage.text, /Click corners around stalls that are counted together/);
    for (const place of [[0, 0], [0, 9], [9, 9]] as const) model.plan.drawing.add(place);
    await stage.drawn();
    await type("kind", "disabled");
    assert.equal(stage.input("[name=area]").required, true);
    await type("area", "East");
    await submit("area");
    await answered();
    await stage.drawn();
    const drawn = { do: "draw_zone", outline: [[0, 0], [0, 9], [9, 9]], name: "East", kind: "disabled" };
    assert.deepEqual(store.steps, [drawn]);
    assert.match(stage.find("section section").textContent, /Zones\s+East · Disabled/);
    await press("Remove the zone East");
    await answered();
    await stage.drawn();
    assert.deepEqual([store.steps[1], model.plan.plan.named.length], [{ do: "erase_zone", zone: "zone-0" }, 0]);
  });

  it("keep the corners of a zone whose name another one has", async () => {
    await open();
    model.plan.drawing.use("zone");
    const draw = async (name: string): Promise<void> => {
      for (const place of [[0, 0], [0, 9], [9, 9]] as const) model.plan.drawing.add(place);
      await stage.drawn();
      await type("area", name);
      await submit("area");
      await answered();
      await stage.drawn();
    };
    await draw("East");
    assert.equal(model.plan.drawing.places.length, 0);
    await draw("East");
    assert.equal(model.plan.drawing.places.length, 3);
    await type("area", "West");
    await submit("area");
    assert.equal(model.plan.drawing.places.length, 0);
  });

  it("undo and redo by Ctrl+Z, Ctrl+Shift+Z and Ctrl+Y, and not while somebody types", async () => {
    await open();
    model.plan.do({ do: "remove", stalls: ["A 1"] });
    await answered();
    const key = async (name: string, shiftKey: boolean, target: EventTarget = document.body): Promise<void> => {
      const event = new KeyboardEvent("keydown", { key: name, shiftKey, ctrlKey: true, cancelable: true });
      Object.defineProperty(event, "target", { value: target });
      undoByKey(event, model);
      await answered();
    };
    const paths = (): string[] => store.asked.slice(2).map(([path]) => path);
    await key("z", false, stage.input("[name=why]"));
    assert.deepEqual(paths(), []);
    await key("z", false);
    await key("Z", true);
    await key("z", false);
    await key("y", false);
    assert.deepEqual(paths(), ["plan/undo", "plan/redo", "plan/undo", "plan/redo"]);
  });

  it("have tools that say which one is used", async () => {
    await open();
    const tools = new Stage(new PlanTools(), model);
    await tools.drawn();
    assert.equal(tools.button("Undo").disabled, true);
    await tools.press("Add row");
    assert.deepEqual([model.plan.drawing.tool, tools.button("Add row").getAttribute("aria-pressed"), tools.button("Choose").getAttribute("aria-pressed")], ["row", "true", "false"]);
    assert.equal(model.leave(), true);
    assert.equal(model.plan.drawing.tool, "choose");
  });

  it("close the edit with a reason", async () => {
    await open();
    await press("Confirm all");
    await type("why", "repainted");
    await submit("why");
    assert.deepEqual([store.asked.at(-1)?.[1].why, model.plan.open, model.toasts.shown?.text], ["repainted", false, "The plan is closed as version 2 of the layout."]);
  });
});
