import "./dom.ts";
import assert from "node:assert/strict";
import { afterEach, beforeEach, describe, it } from "node:test";
import type { PlanPreview } from "../src/api.ts";
import type { Operator } from "../src/state/operator.ts";
import { PlanPanel } from "../src/ui/plan-panel.ts";
import { refusal } from "./api.ts";
import { settle } from "./fakes.ts";
import { PlanStore } from "./plan-store.ts";
import { flying } from "./rig.ts";
import { Stage } from "./stage.ts";

const SHAPE = { id: "n1", north: 0, east: 0, angle: 0, width: 2.5, length: 5, label: "1", former: "", kind: "" };
const PREVIEW: Partial<PlanPreview> = {
  token: "t1",
  file: "plan.dxf",
  placed: { by: "", on: "", is_certain: true, doubt: "", north: 0, east: 0, turn: 0, residual: 0, accuracy: null },
  begin: [SHAPE, SHAPE],
  stay: [SHAPE],
  end: [],
  sections: [],
  same_sections: 0,
  same: 4,
  left_out: [{ name: "<b>node 7</b>", reason: "is a point: draw it" }],
  left_out_count: 1,
  notes: ["roads: width: is missing"],
  clashes: [],
  clash_count: 0,
  layers: [{ name: "STALLS", outlines: 7 }],
};

async function answered(): Promise<void> {
  for (let round = 0; round < 20; round += 1) await settle();
}

describe("the import of a plan from a file", () => {
  const before = globalThis.fetch;
  let store: PlanStore;
  let model: Operator;
  let stage: Stage<PlanPanel>;
  /** Addresses and bodies of what was sent about imports, and the answers to it. */
  let sent: [address: string, body: unknown][];
  let answers: Response[];

  beforeEach(async () => {
    store = new PlanStore(["A 1", "A 2"]);
    sent = [];
    answers = [];
    globalThis.fetch = (address, options) => {
      if (!(address as string).includes("/plan/import")) return store.fetch(address, options);
      sent.push([address as string, options?.body]);
      const answer = answers.shift();
      return answer ? Promise.resolve(answer) : Promise.reject(new TypeError("no link"));
    };
    model = flying().operator;
    model.prefer({ name: "Ann" });
    model.editPlan("lot");
    await answered();
    stage = new Stage(new PlanPanel(), model);
    await stage.drawn();
  });

  afterEach(() => {
    model.plan.leave();
    globalThis.fetch = before;
  });

  const read = async (answer: Response | null): Promise<void> => {
    if (answer) answers.push(answer);
    await model.plan.incoming.read(new File(["x"], "plan.dxf"));
    await stage.drawn();
  };
  const press = async (name: string): Promise<void> => {
    await stage.press(name);
    await answered();
    await stage.drawn();
  };

  it("shows what would change, and what is left out as text", async () => {
    await read(Response.json(PREVIEW));
    assert.equal(sent[0]?.[0], "api/v1/lots/lot/plan/import?name=plan.dxf");
    assert.match(stage.text, /plan\.dxf\s*2 begin, 1 change, 4 are so already, 0 end\./);
    assert.match(stage.text, /1 feature is left out/);
    assert.match(stage.text, /<b>node 7<\/b>: is a point: draw it/);
    assert.equal(stage.part.querySelector("li b"), null);
    assert.equal(stage.input("datalist option").value, "STALLS");
  });

  it("says what happens to sections, and shows them on the map", async () => {
    const said = { former: "", kind: "parallel", length_m: 44, capacity: 8, is_capacity_given: true, note: "" } as const;
    const outline: [number, number][] = [[0, 0], [0, 44], [-2, 44]];
    const sections: PlanPreview["sections"] = [{ ...said, change: "begin", name: "Elm", outline }, { ...said, change: "end", name: "Oak", outline }];
    await read(Response.json({ ...PREVIEW, sections, same_sections: 3 }));
    assert.match(stage.text, /4 are so already, 0 end\. Sections: 1 begin, 0 change, 3 are so already, 1 end\./);
    await read(Response.json({ ...PREVIEW, begin: [], stay: [], same: 0, sections }));
    assert.match(stage.text, /plan\.dxf\s*Sections: 1 begin, 0 change, 0 are so already, 1 end\./);
  });

  it("takes the plan within the edit, as a step that can be undone", async () => {
    await read(Response.json(PREVIEW));
    const stall = { ...SHAPE, is_confirmed: true, is_named: true };
    answers.push(Response.json({ revision: 9, stalls: [stall], gone: [], zones: [], named_zones: [], sections: [], undo: 1, redo: 0 }));
    await press("Take the plan");
    assert.deepEqual(sent[1], ["api/v1/lots/lot/plan/import/t1/take", JSON.stringify({ edit: store.open?.edit, uncertain: false })]);
    assert.equal(model.plan.plan.get("n1")?.label, "1");
    assert.equal(model.plan.own?.undo, 1);
    assert.equal(model.plan.incoming.file, null);
  });

  it("says where it is not certain, and takes it so on ask", async () => {
    await read(Response.json({ ...PREVIEW, placed: { is_certain: false, doubt: "two places fit alike" } }));
    assert.match(stage.text, /It is not certain where the plan lies: two places fit alike/);
    answers.push(Response.json({ revision: 9, stalls: [], gone: [], zones: [], named_zones: [], sections: [], undo: 1, redo: 0 }));
    await press("Take it as it lies");
    assert.match(String(sent[1]?.[1]), /"uncertain":true/);
  });

  it("reads the file again with the choices, while a label is in question", async () => {
    await read(Response.json({ ...PREVIEW, clashes: [{ name: "features[3]", reason: "label 7: confirmed" }], clash_count: 139 }));
    assert.match(stage.text, /features\[3\]: label 7: confirmed/);
    assert.equal(stage.button("Take the plan").disabled, true);
    stage.input("[name=rename]").checked = true;
    stage.input("[name=layer]").value = " STALLS ";
    answers.push(Response.json(PREVIEW));
    stage.input("[name=layer]").closest("form")?.dispatchEvent(new Event("submit", { cancelable: true }));
    await answered();
    await stage.drawn();
    assert.equal(sent[1]?.[0], "api/v1/lots/lot/plan/import?rename=1&layer=STALLS&name=plan.dxf");
    assert.equal(stage.button("Take the plan").disabled, false);
  });

  it("says what is refused in one line with its count, above the button that takes the plan, and the list below", async () => {
    const clashes = Array.from({ length: 20 }, (_, number) => ({ name: `features[${number}]`, reason: "label 7: confirmed" }));
    await read(Response.json({ ...PREVIEW, clashes, clash_count: 139, left_out_count: 1 }));
    assert.match(stage.text, /Assumed: roads: width: is missing/);
    const [lines, list] = [[...stage.part.querySelectorAll(".imported .problem")], stage.find(".imported ul")];
    assert.deepEqual(
      lines.map((line) => line.textContent.trim()),
      ["1 feature is left out", "139 labels or names are refused: other stalls or sections keep them, or the file has them twice"],
    );
    const take = stage.button("Take the plan");
    for (const line of lines) assert.equal(line.compareDocumentPosition(take), 4);
    assert.equal(take.compareDocumentPosition(list), 4);
    assert.equal(list.closest("details")?.open, false);
    answers.push(Response.json(PREVIEW));
    await press("Put numbers behind them");
    assert.equal(sent[1]?.[0], "api/v1/lots/lot/plan/import?rename=1&name=plan.dxf");
    assert.equal(stage.button("Take the plan").disabled, false);
  });

  it("shows the store's words, and those of the page without an answer", async () => {
    await read(refusal(422, "of the drawing are not known", { field: "units" }));
    assert.match(stage.text, /units: of the drawing are not known/);
    await read(null);
    assert.match(stage.text, /The drone did not answer: the file could not be read/);
    await press("Cancel");
    assert.equal(model.plan.incoming.file, null);
    assert.match(stage.text, /No stall is chosen/);
  });

  it("is left by Escape before anything else is", async () => {
    await read(Response.json(PREVIEW));
    model.plan.choose(["A 1"]);
    assert.equal(model.plan.back(), true);
    assert.equal(model.plan.incoming.preview, null);
    assert.equal(model.plan.selection.size, 1);
  });
});
