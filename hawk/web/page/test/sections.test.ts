import "./dom.ts";
import "./no-drawing.ts";
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { afterEach, beforeEach, describe, it } from "node:test";
import type { ListedSection, SectionLook } from "../src/api.ts";
import { stripOf } from "../src/plan/strip.ts";
import type { Side, Spot } from "../src/plan/values.ts";
import type { Operator } from "../src/state/operator.ts";
import { PlanPanel } from "../src/ui/plan-panel.ts";
import "../src/ui/plan-section.ts";
import { fullness, parkedWords, sectionLines } from "../src/words/section.ts";
import { settle } from "./fakes.ts";
import { inFrench } from "./french.ts";
import { PlanStore } from "./plan-store.ts";
import { flying } from "./rig.ts";
import { Stage } from "./stage.ts";

const KERB = [[0, 0], [0, 44]] as const;
/** Strips that the store's test has too: tests/unit/lots/plan/test_sections.py. */
const STRIPS = JSON.parse(readFileSync(new URL("./strips.json", import.meta.url), "utf8")) as { line: Spot[]; width: number; side: Side; ring: Spot[] }[];

function look(parked: number, capacity: number | null, more: Partial<SectionLook> = {}): SectionLook {
  const occupancy = capacity === null ? null : parked / capacity;
  return { survey: "s", section: "e", name: "Elm", observed: "2026-05-04T08:20:00Z", source: "vehicles", parked, least: parked, most: parked + 1, capacity, occupancy, room: 1, hidden_share: 0, seen_share: 1, ...more };
}

describe("what is said of a section", () => {
  it("is how many are parked of its places, in words when it is full or over-full", async () => {
    assert.deepEqual([look(3, 8), look(8, 8), look(9, 8), look(1, null), look(2, null), null].map(parkedWords), ["3 of 8 parked", "8 of 8 parked, full", "9 of 8 parked, over-full", "1 vehicle", "2 vehicles", "not seen"]);
    assert.deepEqual([look(3, 8), look(8, 8), look(9, 8), look(1, null), null].map(fullness), ["room", "full", "over", "alone", "unseen"]);
    await inFrench(() => assert.equal(parkedWords(look(9, 8)), "9 garés sur 8, plus que plein"));
  });

  it("is the interval, the room, what was hidden, and who said the places", () => {
    const section: ListedSection = { id: "e", name: "Elm", outline: [], ground: [], kind: "parallel", length_m: 44, capacity: 8, is_capacity_given: true, note: "permit", look: look(3, 8, { hidden_share: 0.12, seen_share: 0.9, source: "stalls" }) };
    assert.deepEqual(sectionLines(section), ["3 to 4, 9 times in 10.", "Room for 1 more.", "12 % is hidden. 10 % was not seen. Taken stalls are counted: no vehicles are known.", "8 places, as a person says", "along the kerb", "permit"]);
    assert.deepEqual(sectionLines({ ...section, look: null, capacity: null, kind: "", note: "" }), ["nobody says how many places", "in any direction"]);
  });
});

describe("the strip along a line", () => {
  it("lies on the side that is asked, with mitred corners", () => {
    for (const { line, width, side, ring } of STRIPS) {
      assert.deepEqual(stripOf(line, width, side).map(([north, east]) => [Number(north.toFixed(6)) + 0, Number(east.toFixed(6)) + 0]), ring);
    }
    assert.deepEqual([stripOf([[0, 0]], 2, "left"), stripOf([[0, 0], [0, 0]], 2, "left")], [[], []]);
  });
});

describe("the form of a section", () => {
  const before = globalThis.fetch;
  let store: PlanStore;
  let model: Operator;
  let stage: Stage<PlanPanel>;

  async function drawn(): Promise<void> {
    for (let round = 0; round < 20; round += 1) await settle();
    await stage.drawn();
    await settle();
    await stage.drawn();
  }

  beforeEach(async () => {
    store = new PlanStore(["A 1"]);
    globalThis.fetch = store.fetch;
    model = flying().operator;
    model.prefer({ name: "Ann" });
    model.editPlan("lot");
    stage = new Stage(new PlanPanel(), model);
    await drawn();
    model.plan.drawing.use("section");
    await drawn();
  });

  afterEach(() => {
    model.plan.leave();
    globalThis.fetch = before;
  });

  const form = (which: string): HTMLFormElement => stage.find(`hawk-plan-section ${which}form`) as HTMLFormElement;
  const type = (which: string, values: Record<string, string>): void => {
    for (const [name, value] of Object.entries(values)) {
      const field = form(which).querySelector<HTMLInputElement>(`[name=${name}]`);
      assert.ok(field, name);
      field.value = value;
      field.dispatchEvent(new Event("change"));
    }
  };
  const submit = async (which: string): Promise<void> => {
    form(which).dispatchEvent(new Event("submit", { cancelable: true }));
    await drawn();
  };

  it("draws a strip by a line, a side and a width, changes what is said of it, and removes it", async () => {
    for (const place of KERB) model.plan.drawing.add(place);
    type("", { side: "left", width: "3" });
    await drawn();
    assert.deepEqual(model.plan.drawing.strip, [[0, 0], [0, 44], [3, 44], [3, 0]]);
    type("", { name: "Elm Street", kind: "across", note: "permit" });
    await submit("");
    type("details ", { capacity: "12" });
    await submit("details ");
    await stage.press("Remove the section Elm Street");
    await drawn();
    const said = { name: "Elm Street", kind: "across", note: "permit" };
    assert.deepEqual(store.steps, [
      { do: "draw_section", ...said, capacity: null, line: [[0, 0], [0, 44]], side: "left", width: 3 },
      { do: "change_section", section: "section-0", ...said, capacity: 12 },
      { do: "remove_section", section: "section-0" },
    ]);
    assert.deepEqual([model.plan.drawing.places, model.plan.plan.sections], [[], []]);
  });

  it("draws an area, and keeps its corners where another one has the name", async () => {
    type("", { shape: "area" });
    for (const name of ["Yard", "Yard"]) {
      for (const place of [[0, 0], [0, 9], [9, 9]] as const) model.plan.drawing.add(place);
      type("", { name, capacity: "5" });
      await submit("");
    }
    assert.deepEqual(store.steps[0], { do: "draw_section", name: "Yard", kind: "parallel", note: "", capacity: 5, outline: [[0, 0], [0, 9], [9, 9]] });
    assert.equal(model.plan.drawing.places.length, 3);
  });

  it("says which field is wrong, and asks for nothing", async () => {
    for (const place of KERB) model.plan.drawing.add(place);
    type("", { name: "Elm Street", capacity: "some" });
    await submit("");
    assert.match(stage.text, /Places; empty: by the length: give a number/);
    type("", { width: "0" });
    await drawn();
    assert.match(stage.text, /Width, m: give a number/);
    assert.deepEqual([store.steps, model.plan.drawing.width], [[], 2.5]);
  });
});
