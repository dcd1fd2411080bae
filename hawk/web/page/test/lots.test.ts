import "./dom.ts";
import assert from "node:assert/strict";
import { afterEach, beforeEach, describe, it } from "node:test";
import { LotsList } from "../src/ui/lots.ts";
import { answer as answerOf, list, refusal } from "./api.ts";
import { possible, welcome } from "./make.ts";
import { flying } from "./rig.ts";
import { Stage, words } from "./stage.ts";

const HTML = "<b onclick='alert(1)'>North</b>";
const LOTS = [
  { id: "a", name: HTML, time_zone: "Europe/Amsterdam", stalls: 144, survey_count: 2, last_survey: { id: "n", ended: "2026-05-04T23:00:00Z" } },
  { id: "b", name: "South", time_zone: "UTC", stalls: 1, survey_count: 1, last_survey: null },
];
const LISTED = {
  lots: list(...LOTS),
  surveys: list({ id: "s", ended: "2026-05-05T12:00:00Z", candidates: ["b"] }),
  changes: list(),
};

describe("the lots", () => {
  const before = globalThis.fetch;
  let sent: [string, unknown][];
  let answer: () => Response;

  beforeEach(() => {
    sent = [];
    answer = () => Response.json({ seq: 1 });
    globalThis.fetch = (address, options) => {
      if (options?.method !== "POST") return Promise.resolve(answerOf(address as string, LISTED));
      sent.push([address as string, JSON.parse(options.body as string)]);
      return Promise.resolve(answer());
    };
  });

  afterEach(() => {
    globalThis.fetch = before;
  });

  const shown = async (): Promise<Stage<LotsList>> => {
    const stage = new Stage(new LotsList(), flying({ State: "Idle", Armed: false }).operator);
    await stage.drawn();
    return stage;
  };
  const press = async (stage: Stage<LotsList>, label: string): Promise<void> => {
    const found = [...stage.part.querySelectorAll("button")].find((button) => words(button) === label);
    assert.ok(found, label);
    found.click();
    await stage.drawn();
  };

  it("are reported to the page each time they are read: its bar names the lot that a flight has found", async () => {
    let heard = 0;
    const hear = (): number => (heard += 1);
    document.addEventListener("lots-listed", hear);
    await shown();
    document.removeEventListener("lots-listed", hear);
    assert.ok(heard > 0);
  });

  it("are not asked for while another view is shown, and are when it is left", async () => {
    const asked: unknown[] = [];
    const stage = await shown();
    const { fetch } = globalThis;
    globalThis.fetch = (address, options) => (asked.push(address), fetch(address, options));
    const fly = document.createElement("main");
    fly.className = "away";
    document.body.replaceChildren(fly);
    fly.append(stage.part);
    const { model } = stage.part;
    model.flight.note("info", "A survey was stored.", "2026-05-05T12:00:00Z");
    model.dispatchEvent(new Event("change"));
    await stage.drawn();
    assert.equal(asked.length, 0, String(asked));
    fly.className = "";
    model.dispatchEvent(new Event("change"));
    await stage.drawn();
    assert.ok(asked.includes("api/v1/changes"), String(asked));
  });

  it("are listed with stalls, surveys and the last day; HTML in a name is text", async () => {
    const stage = await shown();
    const rows = [...stage.part.querySelectorAll("li")].map((row) => words(row));
    assert.match(rows[0] ?? "", /144 stalls · 2 surveys · last seen 5 May 2026 · Amsterdam time/);
    assert.match(rows[1] ?? "", /South1 stall · 1 survey/);
    assert.equal(stage.part.querySelector("li b")?.textContent, HTML);
    assert.equal(stage.part.querySelectorAll("li b b").length, 0);
  });

  it("are thirty at most: a person searches among more, and only those that are shown are asked for proposals", async () => {
    const { fetch } = globalThis;
    const many = list(...Array.from({ length: 45 }, (_, k) => ({ ...LOTS[1], id: `lot-${k}`, name: `Étage ${k}` })));
    const asked: string[] = [];
    globalThis.fetch = (address, options) => {
      if ((address as string).includes("proposals")) asked.push(address as string);
      return (address as string).includes("/lots?") ? Promise.resolve(Response.json(many)) : fetch(address, options);
    };
    const stage = await shown();
    const rows = (): number => stage.part.querySelectorAll("ul > li").length;
    assert.deepEqual([rows(), asked.length], [30, 30]);
    assert.ok(words(stage.part).includes("30 of 45 lots"));
    const search = stage.part.querySelector<HTMLInputElement>("input[type=search]");
    assert.ok(search);
    search.value = "etage 44";
    search.dispatchEvent(new Event("input"));
    await stage.drawn();
    assert.equal(rows(), 1);
    assert.ok(asked.at(-1)?.includes("lot-44"));
  });

  it("without a stall say how many sections they have", async () => {
    globalThis.fetch = (address) => Promise.resolve(answerOf(address as string, { ...LISTED, lots: list({ ...LOTS[1], stalls: 0, sections: 3 }) }));
    const stage = await shown();
    assert.match(stage.text, /South *3 sections · 1 survey/);
  });

  it("lead to the newest survey, where there is one", async () => {
    const stage = await shown();
    const links = [...stage.part.querySelectorAll("a")].map((link) => link.getAttribute("href"));
    assert.deepEqual(links, ["#/lots", "#/lots/a/n"]);
  });

  it("are renamed", async () => {
    const stage = await shown();
    await press(stage, "Name and clock");
    const field = stage.part.querySelector("input");
    assert.ok(field);
    assert.equal(field.value, HTML);
    field.value = "North Street";
    await press(stage, "Save");
    assert.deepEqual(sent, [["api/v1/lots/a/name", { name: "North Street" }]]);
    assert.equal(stage.part.querySelector("form"), null);
  });

  it("have another clock where a person says so, or that of their place again", async () => {
    const stage = await shown();
    for (const zone of ["America/Toronto", ""]) {
      await press(stage, "Name and clock");
      const clocks = stage.part.querySelector("select");
      assert.ok(clocks);
      assert.equal(clocks.value, "Europe/Amsterdam");
      clocks.value = zone;
      await press(stage, "Save");
    }
    assert.deepEqual(sent, [["api/v1/lots/a/time-zone", { time_zone: "America/Toronto" }], ["api/v1/lots/a/time-zone", { time_zone: null }]]);
  });

  it("say why a name is refused, and keep the field", async () => {
    answer = () => refusal(422, "is empty: write one or more letters", { field: "name" });
    const stage = await shown();
    await press(stage, "Name and clock");
    stage.part.querySelector("input")!.value = "";
    await press(stage, "Save");
    assert.match(words(stage.find("[role=alert]")), /name: is empty: write one or more letters/);
    assert.notEqual(stage.part.querySelector("form"), null);
  });

  it("answer which one a survey means: a candidate or a new one", async () => {
    const stage = await shown();
    assert.match(words(stage.find(".which")), /Which lot is it\?Survey of 2026-05-05/);
    await press(stage, "South");
    await press(stage, "A new lot");
    assert.deepEqual(sent, [
      ["api/v1/surveys/s/move", { lot: "b" }],
      ["api/v1/surveys/s/move", { lot: null }],
    ]);
  });

  it("have their plans corrected on the map, which comes in sight", async () => {
    const stage = await shown();
    const opened: string[] = [];
    const panels: unknown[] = [];
    stage.part.model.editPlan = (lot) => opened.push(lot);
    stage.part.addEventListener("open-panel", (event) => panels.push((event as CustomEvent).detail));
    await stage.press(`Correct the plan: ${HTML}`);
    assert.deepEqual([opened, panels], [["a"], ["map"]]);
  });

  it("keep their buttons when another lot comes before them", async () => {
    const stage = await shown();
    const south = stage.button("Correct the plan: South");
    const more = { ...LISTED, lots: list({ id: "c", name: "Another", time_zone: "UTC", stalls: 9, survey_count: 1, last_survey: null }, ...LOTS) };
    globalThis.fetch = (address) => Promise.resolve(answerOf(address as string, more));
    stage.find("ul").dispatchEvent(new CustomEvent("lot-changed"));
    await stage.drawn();
    assert.equal(stage.part.querySelectorAll("li").length, 3);
    assert.equal(south.getAttribute("aria-label"), "Correct the plan: South");
  });

  it("are changed by operators only", async () => {
    const rig = flying({ State: "Idle", Armed: false });
    rig.server.last.say(welcome({ Role: "viewer" }));
    const stage = new Stage(new LotsList(), rig.operator);
    await stage.drawn();
    assert.deepEqual([stage.has("li"), stage.has("li button")], [true, false]);
  });

  describe("in one flight", () => {
    const choosing = async (): Promise<{ rig: ReturnType<typeof flying>; stage: Stage<LotsList> }> => {
      const rig = flying({ State: "Idle", Armed: false, Options: possible("Survey Again") });
      const stage = new Stage(new LotsList(), rig.operator);
      await stage.drawn();
      return { rig, stage };
    };
    const check = async (stage: Stage<LotsList>, name: string): Promise<void> => {
      stage.find(`input[aria-label="${name} in a flight over several lots"]`).click();
      await stage.drawn();
    };

    it("are the ones that are checked, from two on", async () => {
      const { rig, stage } = await choosing();
      await check(stage, "South");
      assert.doesNotMatch(stage.text, /in one flight/);
      stage.part.querySelectorAll<HTMLInputElement>("li input")[0]!.click();
      await stage.drawn();
      await press(stage, "Survey 2 lots again in one flight");
      assert.deepEqual([rig.sent().at(-1)?.Type, rig.sent().at(-1)?.Lots, rig.sent().at(-1)?.Due], ["Survey Again", ["a", "b"], undefined]);
      await rig.answer(true);
      await stage.drawn();
      assert.equal(stage.part.querySelectorAll("input:checked").length, 0);
    });

    it("stay checked when the drone refuses", async () => {
      const { rig, stage } = await choosing();
      for (const input of stage.part.querySelectorAll<HTMLInputElement>("li input")) input.click();
      await stage.drawn();
      await press(stage, "Survey 2 lots again in one flight");
      await rig.answer(false, "Lots: North and South overlap by 400 m²: merge them, or survey them one by one.");
      await stage.drawn();
      assert.match(stage.text, /Survey 2 lots again in one flight/);
    });

    it("are all that are due", async () => {
      const { rig, stage } = await choosing();
      await press(stage, "Survey all that are due");
      assert.deepEqual([rig.sent().at(-1)?.Due, rig.sent().at(-1)?.Lots], [true, undefined]);
    });

    it("are not chosen where no survey can be asked for", async () => {
      const stage = await shown();
      assert.equal(stage.has("li input"), false);
      assert.doesNotMatch(stage.text, /due/);
    });
  });

  it("are left out while there are none", async () => {
    globalThis.fetch = () => Promise.resolve(new Response("", { status: 404 }));
    const stage = await shown();
    assert.equal(stage.part.querySelector("section"), null);
  });
});
