import "./dom.ts";
import "./no-drawing.ts";
import assert from "node:assert/strict";
import { afterEach, beforeEach, describe, it } from "node:test";
import type { Changed, ListedSection, SectionChange, SectionLook, SurveyUse } from "../src/api.ts";
import { Route } from "../src/route/route.ts";
import "../src/parts/figures.ts";
import "../src/parts/maps.ts";
import { LotViews } from "../src/views/lot-views.ts";
import type { SurveyMap } from "../src/views/survey-map.ts";
import { changeWords, parkedInAll, trend } from "../src/words/section.ts";
import { surveyMap } from "./api.ts";
import { settle } from "./fakes.ts";
import { inFrench } from "./french.ts";
import { words } from "./stage.ts";

const LOT = "00000000-0000-4000-8000-000000000001";
const [ONE, TWO] = ["00000000-0000-4000-8000-00000000000a", "00000000-0000-4000-8000-00000000000b"];
const [ELM, OAK] = ["00000000-0000-4000-8000-0000000000e1", "00000000-0000-4000-8000-0000000000e2"];
const NONE = { value: null, low: null, high: null, surveys: 0 };
const PLACE = { north: 0, east: 0, turn: 0 };

function survey(id: string, ended: string): SurveyUse {
  return { id, kind: "flown", layout: null, accuracy: null, left_out: "", placed: "unregistered", free: 0, taken: 0, unknown: 0, found: 0, blurred: null, simulated: false, program: "0.4.0", source: "", source_name: "", limits: [], at: ended, began: ended, ended, occupancy: NONE, left_out_code: "" };
}

function section(id: string, name: string, parked: number | null, capacity: number | null): ListedSection {
  const look: SectionLook | null = parked === null ? null : { survey: TWO, section: id, name, observed: "2026-05-04T12:00:00Z", source: "vehicles", parked, least: parked, most: parked + 1, capacity, occupancy: null, room: 1, hidden_share: 0, seen_share: 1 };
  return { id, name, outline: [], ground: [[0, 10], [0, 10.0004], [0.00002, 10.0004], [0.00002, 10]], kind: "parallel", length_m: 44, capacity, is_capacity_given: true, note: "", look };
}

function change(id: string, name: string, before: number | null, after: number | null, isChanged: boolean | null, capacity: number | null = 8): SectionChange {
  const counts = (parked: number | null): SectionChange["before"] => (parked === null ? null : { parked, least: parked, most: parked + 1 });
  return { id, name, capacity, before: counts(before), after: counts(after), is_changed: isChanged };
}

const CHANGED: Changed = { compared: 0, unknown: 0, matched: 0, begin: [], gone: [], free: NONE, came: NONE, left: NONE, stalls: [], sections: [change(ELM, "Elm", 3, 6, true), change(OAK, "Oak", 2, null, null)] };

describe("the change of a section", () => {
  it("is more, fewer or the same, surely or not, and words with its places", async () => {
    const all = [change(ELM, "Elm", 3, 6, true), change(ELM, "Elm", 3, 4, false), change(ELM, "Elm", 4, 3, false), change(ELM, "Elm", 9, 0, true), change(ELM, "Elm", 3, 3, false), change(ELM, "Elm", null, 3, null)];
    assert.deepEqual(all.map(trend), ["surely-more", "more", "fewer", "surely-fewer", "same", "unseen"]);
    assert.deepEqual([all[0]!, all[5]!, change(ELM, "Elm", 1, 2, false, null)].map(changeWords), ["3, then 6 of 8 parked", "not seen", "1, then 2 vehicles"]);
    await inFrench(() => assert.equal(changeWords(all[0]!), "3, puis 6 garés sur 8"));
  });

  it("is summed up over the sections that were seen, without places where one has none", () => {
    assert.deepEqual(parkedInAll([{ parked: 3, capacity: 8 }, null, { parked: 2, capacity: 4 }]), { parked: 5, capacity: 12 });
    assert.deepEqual(parkedInAll([{ parked: 3, capacity: 8 }, { parked: 2, capacity: null }]), { parked: 5, capacity: null });
    assert.equal(parkedInAll([null]), null);
  });
});

describe("a lot of sections alone", () => {
  const before = globalThis.fetch;
  let answers: Record<string, unknown>;
  let views: LotViews;
  let hash: string;

  beforeEach(() => {
    answers = {
      "/statistics/surveys": { lot: LOT, name: "Elm Street", clock: "UTC", interval: 0.9, before: null, after: null, surveys: [survey(TWO, "2026-05-04T12:00:00Z"), survey(ONE, "2026-05-04T10:00:00Z")] },
      "/map": surveyMap(),
      "/ground": { place: PLACE, datum: [0, 10], tiles: [] },
      "/sections": { survey: TWO, sections: [section(ELM, "Elm", 6, 8), section(OAK, "Oak", null, 8)] },
      "/statistics/between": CHANGED,
      "/statistics/stalls": { surveys_in_period: 2, ids: [], labels: [], surveys: [], share: [], low: [], high: [] },
      "/changes": { next: null, items: [] },
      "/recordings": { next: null, items: [] },
      "/due": { items: [] },
      "api/v1/surveys": { next: null, items: [] },
    };
    globalThis.fetch = (address) => {
      const path = (address as string).split("?")[0]!;
      const found = Object.entries(answers).filter(([end]) => path.endsWith(end)).sort(([one], [other]) => other.length - one.length)[0];
      return Promise.resolve(found ? Response.json(found[1]) : Response.json({ field: "lot", detail: "is gone" }, { status: 404 }));
    };
  });

  afterEach(() => {
    document.body.replaceChildren(); // its maps end
    globalThis.fetch = before;
  });

  async function drawn(): Promise<void> {
    for (let k = 0; k < 16; k++) {
      await settle();
      await views.updateComplete;
    }
  }

  async function open(at: string): Promise<void> {
    hash = at;
    const route = new Route({ hash: () => hash, write: (next: string) => (hash = next) }, "");
    views = Object.assign(new LotViews(), { route, access: { lots: [{ id: LOT, name: "Elm Street" }], unlisted: "", token: null, mayChange: true } });
    document.body.replaceChildren(views);
    await drawn();
  }

  it("says in Lots the vehicles of its sections, no free stalls", async () => {
    await open(`#/lots/${LOT}`);
    assert.match(words(views), /6 of 8 parked/);
    assert.doesNotMatch(words(views), /0 free|of 0/);
    assert.match(words(views), /Elm *6 of 8 parked *6–7 *1 *Oak *not seen/);
  });

  it("is compared by its sections, on both maps and in the list", async () => {
    await open(`#/compare/${LOT}`);
    const map = views.querySelector<SurveyMap>("hawk-survey-map")!;
    assert.deepEqual([map.sections.length, map.changes?.length], [2, 2]);
    assert.deepEqual(map.cards.map(({ detail }) => detail), ["5 of 16 parked", "6 of 8 parked"]);
    assert.match(words(views), /3, then 6 of 8 parked/);
    assert.match(words(views), /Elm *3 \(3 to 4\) *6 \(6 to 7\) *differs *Oak *2 \(2 to 3\) *–/);
    assert.doesNotMatch(words(views), /Nothing to compare|No stall changed/);
    [...views.querySelectorAll("button")].find((each) => words(each) === "Elm")?.click();
    await drawn();
    assert.match(hash, new RegExp(`section=${ELM}`));
    const card = views.querySelector("[data-section]")!;
    assert.match(words(card), /Section Elm *3, then 6 of 8 parked *before: 3 \(3 to 4\) *after: 6 \(6 to 7\) *differs/i);
  });

  it("shows its sections over its surveys in place of stalls", async () => {
    await open(`#/lots/${LOT}?show=stalls`);
    assert.equal(views.querySelectorAll("hawk-survey-map").length, 1, words(views));
    assert.match(words(views), /Elm *6 of 8 parked/);
    assert.doesNotMatch(words(views), /No survey counts/);
  });

  it("says that nothing counts where no survey saw a section", async () => {
    answers["/statistics/stalls"] = { ...(answers["/statistics/stalls"] as object), surveys_in_period: 0 };
    await open(`#/lots/${LOT}?show=stalls`);
    assert.equal(views.querySelectorAll("hawk-survey-map, table.sections").length, 0);
  });
});
