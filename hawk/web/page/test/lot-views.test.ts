import "./dom.ts";
import "./no-drawing.ts";
import assert from "node:assert/strict";
import { afterEach, beforeEach, describe, it, mock } from "node:test";
import { heatClass, moment, share } from "../src/views/figures.ts";
import type { Changed, SurveyUse } from "../src/api.ts";
import { LotSource } from "../src/views/link.ts";
import type { Feature } from "../src/views/survey-source.ts";
import { readAll } from "../src/link/api.ts";
import { firstPart, firstReads } from "../src/route/first-reads.ts";
import { Route } from "../src/route/route.ts";
import "../src/parts/figures.ts";
import "../src/parts/maps.ts";
import { LotViews } from "../src/views/lot-views.ts";
import type { SurveyMap } from "../src/views/survey-map.ts";
import { headline, interval, notCompared } from "../src/views/compare-words.ts";
import type { TimeBar } from "../src/views/time-bar.ts";
import { notes } from "../src/views/surveys-view.ts";
import { surveyMap } from "./api.ts";
import { settle } from "./fakes.ts";
import { inFrench } from "./french.ts";
import { words } from "./stage.ts";

const LOT = "00000000-0000-4000-8000-000000000001";
const ONE = "00000000-0000-4000-8000-00000000000a";
const TWO = "00000000-0000-4000-8000-00000000000b";
const STALL = "00000000-0000-4000-8000-0000000000ff";
const HALF_ID = "00000000-0000-4000-8000-0000000000ee";
const HTML = "<b onclick='alert(1)'>North</b>";
const NONE = { value: null, low: null, high: null, surveys: 0 };
const HALF = { value: 0.5, low: 0.4, high: 0.6, surveys: 1 };

function survey(id: string, ended: string, more: Partial<SurveyUse> = {}): SurveyUse {
  return { id, kind: "flown", layout: 1, accuracy: null, left_out: "", placed: "registered", free: 1, taken: 1, unknown: 0, found: 2, blurred: null, simulated: false, program: "0.3.0", source: "", source_name: "", limits: [], at: ended, began: ended, ended, occupancy: HALF, left_out_code: "", ...more };
}

/** A stall of some metres at metres east of a place. */
function stall(id: string, label: string, east: number, state: string): Feature {
  const at = (x: number, y: number): [number, number] => [10 + (east + x) / 111_132.95, y / 111_132.95];
  return { id, geometry: { type: "Polygon", coordinates: [[at(0, 0), at(0, 5), at(2, 5), at(2, 0), at(0, 0)]] }, properties: { amenity: "parking_space", ref: label, state } };
}

const BETWEEN: Changed = {
  sections: [], compared: 2, unknown: 1, matched: 0, gone: [],
  begin: [{ id: ONE, label: "D 23" }],
  free: { value: -1, low: -1.4, high: -0.6, surveys: 2 }, came: { value: 1, low: 1, high: 2, surveys: 2 }, left: { value: 0, low: 0, high: 0, surveys: 2 },
  stalls: [{ id: STALL, label: "A 1", former: ONE, before: "free", after: "taken", chance: 0.98 }, { id: TWO, label: "A 2", former: TWO, before: "taken", after: "unknown", chance: null }],
};
const DRAWN = surveyMap(stall(STALL, "A 1", 0, "free"), stall(TWO, "A 2", 3, "taken"));

describe("figures in words", () => {
  it("have their interval, or are not shown", () => {
    assert.equal(share(HALF), "50.0 % (40.0 to 60.0 %)");
    assert.equal(share(NONE), "–");
  });

  it("are coloured by fifths, and not at all without a look", () => {
    assert.deepEqual([null, 0, 0.2, 0.99, 1].map(heatClass), [-1, 0, 1, 4, 4]);
    assert.equal(moment("never"), "–");
  });
});

describe("a survey that no figure uses", () => {
  it("says why, in French too", async () => {
    const row = survey(ONE, "2026-05-04T10:00:00Z", { left_out_code: "no_time", simulated: true });
    assert.equal(notes(row), "Simulated · Its time is not certain");
    await inFrench(() => assert.equal(notes(row), "Simulé · Son heure n’est pas certaine"));
  });
});

describe("a survey by pictures", () => {
  const row = survey(ONE, "2026-05-04T10:00:00Z", { source: "orthophoto", source_name: "north.tif", limits: ["coarse", "partly"] });

  it("names its source and what limits it, in French too", async () => {
    assert.equal(notes(row), "From an orthophoto (north.tif) · Its pictures are coarse: fewer stalls are found · A part of the lot was not seen");
    await inFrench(() => assert.equal(notes({ ...row, limits: ["by_gps", "stretched"], source: "film" }), "D’après un film (north.tif) · Ses images sont là où leurs fichiers le disent\u00A0: les places peuvent être décalées de quelques mètres · Sa carte peut être tournée ou étirée\u00A0: les places à ses bouts peuvent être décalées de quelques mètres"));
  });
});

describe("a survey that was flown over a long time", () => {
  it("says so, though figures use it", () => {
    assert.equal(notes(survey(ONE, "2026-05-04T11:00:00Z", { began: "2026-05-04T10:00:00Z" })), "It lasted 60 min: cars came and went meanwhile");
    assert.equal(notes(survey(ONE, "2026-05-04T11:00:00Z", { began: "2026-05-04T10:40:00Z" })), "");
  });
});

describe("a survey of which only blurred pictures show some stalls", () => {
  it("says how many", async () => {
    const row = survey(ONE, "2026-05-04T10:00:00Z", { blurred: 1 });
    assert.equal(notes(row), "Seen only blurred: 1 of 2 stalls");
    assert.equal(notes({ ...row, blurred: 0 }), "");
    await inFrench(() => assert.equal(notes(row), "Places vues floues seulement\u00a0: 1 sur 2"));
  });
});

describe("what several parts of the page ask for", () => {
  const before = globalThis.fetch;
  afterEach(() => {
    globalThis.fetch = before;
  });

  it("is asked again after half a minute, and after a failure", async () => {
    let [now, count, works] = [0, 0, true];
    globalThis.fetch = () => {
      count += 1;
      return Promise.resolve(works ? Response.json(DRAWN) : new Response("busy", { status: 500 }));
    };
    const source = new LotSource("lots/1", true, () => now);
    await Promise.all([source.map(ONE), source.map(ONE)]);
    assert.equal(count, 1);
    [now, works] = [30_000, false];
    await assert.rejects(source.map(ONE), /busy/);
    works = true;
    await source.map(ONE);
    assert.equal(count, 3);
  });

  it("is a whole list, part by part", async () => {
    const asked: string[] = [];
    globalThis.fetch = (address) => {
      asked.push(address as string);
      return Promise.resolve(Response.json(asked.length === 1 ? { items: [1, 2], next: "2" } : { items: [3], next: null }));
    };
    assert.deepEqual(await readAll("lots"), [1, 2, 3]);
    assert.deepEqual(asked, ["api/v1/lots?limit=1000", "api/v1/lots?limit=1000&after=2"]);
  });
});

describe("lots over time", () => {
  const before = globalThis.fetch;
  let sent: [string, unknown][];
  let reads: string[];
  /** With their parameters. */
  let asked: string[];
  let answers: Record<string, unknown>;
  let hash: string;
  let archive: LotViews;
  let route: Route;

  beforeEach(() => {
    sent = [];
    reads = [];
    asked = [];
    hash = "";
    answers = {
      "/statistics/surveys": { lot: LOT, name: "North", clock: "UTC", interval: 0.9, before: null, after: null, surveys: [survey(TWO, "2026-05-04T12:00:00Z"), survey(ONE, "2026-05-04T10:00:00Z", { left_out_code: "unregistered", occupancy: NONE })] },
      "/map": DRAWN,
      "/shares": { shares: [{ id: ONE, who: "Ada", made: "2026-05-04T10:00:00Z", ends: "2026-06-03T10:00:00Z", open: true }] },
      "/changes": { next: null, items: [] },
      "/recordings": { next: null, items: [{ name: "20260504T100000Z.mcap", bytes: 2_000_000, began: "2026-05-04T10:00:00Z", seconds: 90, survey: ONE, lot: { name: HTML }, keep: false, under_way: false }] },
      "/observations": { next: null, items: [{ survey: ONE, label: "A 1", observed: "2026-05-04T10:00:00Z", state: "taken", taken_probability: 0.97 }] },
      "/statistics/stalls": { surveys_in_period: 2, ids: [STALL, TWO], labels: ["A 1", "A 2"], surveys: [2, 0], share: [0.5, null], low: [0.2, null], high: [0.8, null] },
      "/statistics/between": BETWEEN,
      "/due": { items: [] },
      "api/v1/surveys": { next: null, items: [] },
    };
    globalThis.fetch = (address, options) => {
      const path = (address as string).split("?")[0]!;
      if (options?.method === "POST") {
        sent.push([path, JSON.parse(options.body as string)]);
        return Promise.resolve(Response.json({ seq: 7, token: "secret", ends: "2026-06-03T10:00:00Z" }));
      }
      reads.push(path);
      asked.push(address as string);
      const found = Object.entries(answers)
        .filter(([end]) => path.endsWith(end))
        .sort(([one], [other]) => other.length - one.length)[0];
      return Promise.resolve(found ? Response.json(found[1]) : Response.json({ field: "lot", detail: "is gone" }, { status: 404 }));
    };
  });

  afterEach(() => {
    globalThis.fetch = before;
  });

  async function open(at: string, { token = null as string | null, operator = true, lots = [{ id: LOT, name: HTML }] } = {}): Promise<void> {
    hash = at;
    route = new Route({ hash: () => hash, write: (next: string) => (hash = next) }, token ?? "");
    archive = Object.assign(new LotViews(), { route, access: { lots, unlisted: "", token, mayChange: operator } });
    document.body.replaceChildren(archive);
    await drawn();
  }

  async function go(view: "lots" | "report" | "recordings"): Promise<void> {
    route.go({ view, show: "" });
    await drawn();
  }

  /** The words of the first button that begins so. */
  function label(begin: string): string {
    return [...archive.querySelectorAll("button")].map((each) => words(each)).find((each) => each.startsWith(begin)) ?? "";
  }

  async function drawn(): Promise<void> {
    for (let k = 0; k < 6; k++) {
      await settle();
      await archive.updateComplete;
    }
  }

  it("asks first for what was asked for while the page was read: nothing twice, and nothing in vain", async () => {
    answers["/ground"] = { datum: [0, 10], place: { north: 0, east: 0, turn: 0 }, cells: 256, cell_m: 0.1, tiles: [[0, 0]] };
    for (const address of [`#/lots/${LOT}/${ONE}`, `#/lots/${LOT}`, `#/compare/${LOT}/${ONE}/${TWO}`, `#/compare/${LOT}`, `#/report/${LOT}`, `#/recordings/${LOT}`, "#/recordings"]) {
      asked = [];
      await open(address);
      const soon = firstReads(address).filter((path) => path !== "lots/places" && !path.endsWith("/ground/whole")); // the bar's, and the map's
      assert.ok(soon.length > 0, address);
      for (const path of soon) assert.equal(asked.filter((each) => each === `api/v1/${path}`).length, 1, `${path} of ${address}: ${asked.join(" ")}`);
    }
    assert.deepEqual(firstReads(`#/report/${LOT}?days=mon-fri`), ["lots/places"]);
    assert.deepEqual([firstReads(""), firstReads(`#/fly/${LOT}`), firstReads("#/lots/<b>")], [[], [], ["lots/places"]]);
    const shared = "shared/secret/statistics";
    assert.deepEqual(firstReads("#secret"), [`${shared}/surveys?newest=8`]);
    assert.deepEqual(firstReads(`#secret/lots/${LOT}/${ONE}`), [`shared/secret/surveys/${ONE}/map`, `${shared}/surveys?survey=${ONE}`, `${shared}/surveys?newest=8`], "a link shows no picture");
    assert.deepEqual(firstReads(`#secret/report/${LOT}`), [`${shared}/ask`, `${shared}/surveys?newest=8`]);
  });

  it("asks first for the part in which the view is", () => {
    const parts = { fly: ["", `#/fly/${LOT}`, "#/unknown"], maps: ["#secret", `#/lots/${LOT}/${ONE}`, `#/compare/${LOT}`, `#/lots/${LOT}?show=stalls`, "#/recordings/one/20260504T101500Z.mcap"], figures: [`#/report/${LOT}`, `#secret/report/${LOT}`, "#/recordings", `#/lots/${LOT}?show=links`, `#/lots/${LOT}?show=arrivals`] };
    for (const [part, addresses] of Object.entries(parts)) for (const address of addresses) assert.equal(firstPart(address), part, address);
  });

  async function press(label: string): Promise<void> {
    const all = [...archive.querySelectorAll("button")];
    const found = all.find((each) => words(each) === label || each.getAttribute("aria-label") === label);
    assert.ok(found, `${label}: ${words(archive)}`);
    found.click();
    await drawn();
  }

  it("list the surveys of a lot", async () => {
    await open(`#/lots/${LOT}`);
    const rows = [...archive.querySelectorAll("tbody tr")].map((row) => words(row));
    const named = [...archive.querySelectorAll<HTMLElement>(".cards tbody tr:first-child td[data-column]")].map((cell) => cell.dataset.column);
    assert.deepEqual(named, ["Free", "Taken", "Unclear", "Occupancy"], "on a phone each value says its column");
    assert.match(rows[0]!, /50\.0 % \(40\.0 to 60\.0 %\)/);
    assert.match(rows[1]!, /–Its place on the lot is not certain/);
  });

  it("say how many stalls the flight found where the plan has others", async () => {
    answers["/statistics/surveys"] = { ...(answers["/statistics/surveys"] as object), surveys: [survey(TWO, "2026-05-04T12:00:00Z", { found: 5 })] };
    await open(`#/lots/${LOT}/${TWO}`);
    assert.match(words(archive), /The flight itself found 5 stalls\. Counts are of the 2 of the lot's plan\./);
  });

  it("show one survey with a warning where no figure uses it, delete it, and undo that", async () => {
    await open(`#/lots/${LOT}/${ONE}`);
    assert.match(words(archive), /No figure uses this survey\. Its place on the lot is not certain\./);
    assert.deepEqual(archive.querySelector<SurveyMap>("hawk-survey-map")?.source?.stalls.map(({ label, state }) => [label, state]), [["A 1", "free"], ["A 2", "taken"]]);
    const button = [...archive.querySelectorAll("button")].find((each) => words(each) === "Delete survey")!;
    for (let twice = 0; twice < 2; twice++) {
      button.click();
      await drawn();
    }
    assert.deepEqual([sent, words(button)], [[], "Delete survey"], "a double click deletes nothing");
    await press("Delete survey");
    assert.deepEqual(sent, [], "it asks once more");
    await press("Delete this survey");
    await press("Undo");
    assert.deepEqual(sent, [[`api/v1/surveys/${ONE}/delete`, {}], ["api/v1/changes/7/undo", {}]]);
  });

  it("undo a change of days ago from the list; one that cannot be undone, or was, has no button", async () => {
    const change = { seq: 5, kind: "delete", lot: LOT, surveys: [ONE], who: HTML, made: "2026-05-01T10:00:00Z", undone: null, kept: null };
    answers["/changes"] = { next: null, items: [change, { ...change, seq: 4, kind: "name", kept: "the lot was named again" }, { ...change, seq: 3, undone: "2026-05-02T10:00:00Z" }] };
    await open(`#/lots/${LOT}`);
    assert.match(words(archive.querySelector(".changes")!), /Survey deleted[^]*Lot named[^]*undone/);
    const buttons = [...archive.querySelectorAll<HTMLButtonElement>(".changes button")];
    assert.equal(buttons.length, 1);
    buttons[0]?.click();
    await drawn();
    assert.deepEqual(sent, [["api/v1/changes/5/undo", {}]]);
    assert.equal(archive.querySelector(".changes b"), null, "a name's HTML is text");
  });

  it("offer a viewer nothing that changes", async () => {
    await open(`#/lots/${LOT}/${TWO}`, { operator: false });
    assert.doesNotMatch(words(archive), /Delete/);
    await press("Links");
    assert.doesNotMatch(words(archive), /Make a link|Take back/);
    await go("recordings");
    assert.equal(archive.querySelector<HTMLInputElement>("input[type=checkbox]")?.disabled, true);
    assert.doesNotMatch(words(archive), /Delete/);
  });

  it("compare two surveys by list and by swipe", async () => {
    answers["/statistics/surveys"] = { ...(answers["/statistics/surveys"] as object), surveys: [survey(TWO, "2026-05-04T12:00:00Z"), survey(ONE, "2026-05-04T10:00:00Z")] };
    await open(`#/compare/${LOT}`);
    const map = archive.querySelector<SurveyMap>("hawk-survey-map")!;
    assert.deepEqual([map.querySelectorAll(".ol").length, map.by, map.at, [...map.marked]], [2, "swipe", 0.5, [STALL, ONE, TWO]]);
    assert.match(words(archive), /1 fewer free of the 2 seen in both/);
    assert.match(words(archive), /0 to 2 fewer, 9 times in 10\. 1 became taken, 0 became free, 1 became unclear\./);
    assert.match(words(archive), /1 stall is unclear in one of them: not counted\. *D 23 is new since: not compared\./);
    assert.match(words(archive), /Row A, 2 changes *A 1 *\?? *free, now taken *A 2 *\?? *taken, now unclear/);
    await press(label("A 1"));
    assert.match(hash, new RegExp(`stall=${STALL}`));
    await press("Side by side");
    assert.match(hash, /by=side/);
  });

  it("move the line between two surveys by keys, and say where it is", async () => {
    answers["/statistics/surveys"] = { ...(answers["/statistics/surveys"] as object), surveys: [survey(TWO, "2026-05-04T12:00:00Z"), survey(ONE, "2026-05-04T10:00:00Z")] };
    await open(`#/compare/${LOT}?at=.5`);
    const handle = (): HTMLElement => archive.querySelector<HTMLElement>("[role=slider]")!;
    for (const key of ["ArrowRight", "PageDown", "x"]) {
      handle().dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true }));
      await drawn();
    }
    assert.match(hash, /at=\.42/);
    assert.match(handle().getAttribute("aria-valuetext") ?? "", /^58 % of the map shows Mon 4 May.* 12:00, the rest Mon 4 May.* 10:00$/);
    handle().dispatchEvent(new KeyboardEvent("keydown", { key: "End", bubbles: true }));
    await drawn();
    assert.equal(archive.querySelector<HTMLElement>(".date.second")?.hidden, true, "no room for its card");
  });

  it("list what changed by the labels that the map shows, in their order", async () => {
    answers["/statistics/surveys"] = { ...(answers["/statistics/surveys"] as object), surveys: [survey(TWO, "2026-05-04T12:00:00Z"), survey(ONE, "2026-05-04T10:00:00Z")] };
    answers["/statistics/between"] = { ...BETWEEN, stalls: BETWEEN.stalls.map((each, k) => ({ ...each, label: `Z ${9 - k}` })).reverse() };
    await open(`#/compare/${LOT}`);
    assert.deepEqual([...archive.querySelectorAll(".changed b")].map(words), ["A 1", "A 2"]);
  });

  it("list the first changes before the map is drawn, and all of them once the browser has time", async () => {
    const idle: (() => void)[] = [];
    Object.assign(globalThis, { requestIdleCallback: (work: () => void) => idle.push(work) });
    answers["/statistics/surveys"] = { ...(answers["/statistics/surveys"] as object), surveys: [survey(TWO, "2026-05-04T12:00:00Z"), survey(ONE, "2026-05-04T10:00:00Z")] };
    answers["/statistics/between"] = { ...BETWEEN, stalls: Array.from({ length: 60 }, (_, k) => ({ ...BETWEEN.stalls[0]!, id: `stall ${k}`, label: `${k < 30 ? "A" : "B"} ${k}` })) };
    try {
      await open(`#/compare/${LOT}`);
      const count = (): number => archive.querySelectorAll(".changed li").length;
      assert.deepEqual([count(), words(archive.querySelectorAll("h3")[1]!)], [40, "Row B, 30 changes"]);
      assert.equal(asked.some((path) => path.includes("/due")), false, "the time bar waits, too");
      for (const work of idle) work();
      await drawn();
      assert.deepEqual([count(), asked.some((path) => path.includes("/due"))], [60, true]);
    } finally {
      Reflect.deleteProperty(globalThis, "requestIdleCallback");
    }
  });

  it("call no map drawn without a survey on it", async () => {
    answers["/map"] = undefined;
    for (const address of [`#/lots/${LOT}/${ONE}`, `#/compare/${LOT}/${ONE}/${TWO}`]) {
      await open(address);
      assert.equal(archive.querySelector<HTMLElement>("hawk-survey-map")!.dataset.drawn, undefined, address);
    }
  });

  it("compare what the bar chooses, the earlier one before, and never one with itself", async () => {
    answers["/statistics/surveys"] = { ...(answers["/statistics/surveys"] as object), surveys: [survey(TWO, "2026-05-04T12:00:00Z"), survey(ONE, "2026-05-04T10:00:00Z"), survey(STALL, "2026-05-04T14:00:00Z")] };
    await open(`#/compare/${LOT}/${STALL}/${TWO}`);
    assert.match(hash, new RegExp(`/${TWO}/${STALL}$`), "they were exchanged");
    await press(label("Before"));
    const bar = archive.querySelector("hawk-time-bar")!;
    bar.dispatchEvent(new CustomEvent("survey", { detail: STALL }));
    assert.match(hash, new RegExp(`/${TWO}/${STALL}$`));
    bar.dispatchEvent(new CustomEvent("survey", { detail: ONE }));
    assert.match(hash, new RegExp(`/${ONE}/${STALL}$`));
  });

  it("keep the map while another survey is asked for", async () => {
    const all = (answers["/statistics/surveys"] as { surveys: SurveyUse[] }).surveys;
    answers["/statistics/surveys"] = { ...(answers["/statistics/surveys"] as object), surveys: [...all, survey(STALL, "2026-05-04T09:00:00Z")].map((row) => ({ ...row, left_out_code: "" })) };
    await open(`#/compare/${LOT}`);
    const map = archive.querySelector("hawk-survey-map");
    route.go({ before: STALL, after: TWO });
    await archive.updateComplete;
    await settle();
    assert.equal(archive.querySelector("hawk-survey-map"), map);
    await drawn();
    assert.equal(archive.querySelector("hawk-survey-map"), map);
    assert.match(words(archive), /Before *Mon 4 May, 09:00/);
    answers["/statistics/surveys"] = { ...(answers["/statistics/surveys"] as object), surveys: [] };
    route.go({ before: HALF_ID, after: TWO });
    await drawn();
    assert.match(words(archive), /The survey Before of this address is not there/);
  });

  it("show on the bar what was deleted and what is due, and bring a survey back", async () => {
    answers["/changes"] = { next: null, items: [{ seq: 5, kind: "delete", lot: LOT, surveys: [STALL], who: "Ann", made: "2026-05-05T10:00:00Z", undone: null, kept: null }] };
    answers["api/v1/surveys"] = { next: null, items: [{ id: STALL, ended: "2026-05-05T09:00:00Z" }, { id: ONE, ended: "2026-05-06T09:00:00Z" }] };
    answers["/due"] = { items: ["2026-05-07T15:00:00Z"] };
    await open(`#/lots/${LOT}/${TWO}`);
    assert.deepEqual([...archive.querySelectorAll(".tick.deleted")].map((each) => each.getAttribute("aria-label")), ["09:00 deleted. Bring back"]);
    assert.equal(archive.querySelectorAll(".tick.due").length, 1);
    answers["/due"] = { items: [] }; // it was flown meanwhile, or was due for too long
    const now = Date.now() + 300_000;
    const clock = mock.method(Date, "now", () => now);
    archive.querySelector<TimeBar>("hawk-time-bar")!.requestUpdate();
    await drawn();
    clock.mock.restore();
    assert.equal(archive.querySelectorAll(".tick.due").length, 0);
    assert.equal(archive.querySelectorAll("li.none").length, 5, "a day that has a deleted survey was flown, one that comes was not");
    await press("09:00 deleted. Bring back");
    await press("Bring back");
    assert.deepEqual(sent, [["api/v1/changes/5/undo", {}]]);
  });

  it("say that the survey of an address is gone, and show the newest one", async () => {
    await open(`#/lots/${LOT}/${TWO}`);
    assert.doesNotMatch(words(archive), /not there/);
    route.go({ survey: STALL });
    await drawn();
    assert.match(words(archive), /The survey of this address is not there: it was deleted, or moved\. The newest one is shown\. Survey of 2026-05-04 12:00/);
  });

  it("bring the only survey back when it was deleted", async () => {
    answers["/statistics/surveys"] = { ...(answers["/statistics/surveys"] as object), surveys: [] };
    answers["/changes"] = { next: null, items: [{ seq: 5, kind: "delete", lot: LOT, surveys: [ONE], who: "Ann", made: "2026-05-05T10:00:00Z", undone: null, kept: null }] };
    await open(`#/lots/${LOT}`);
    assert.match(words(archive), /This lot has no survey:/);
    await press("Undo: Survey deleted, 2026-05-05 10:00");
    assert.deepEqual(sent, [["api/v1/changes/5/undo", {}]]);
    answers["api/v1/surveys"] = { next: null, items: [{ id: ONE, ended: "2026-05-04T10:00:00Z" }] };
    await open(`#/lots/${LOT}`);
    assert.match(words(archive), /Survey deleted \(2026-05-04 10:00\) *2026-05-05 10:00/, "one deleted survey differs from another");
  });

  it("are shown by the lot's clock, as changes are, and by the moment of their observations, also across midnight", async () => {
    answers["/statistics/surveys"] = { ...(answers["/statistics/surveys"] as object), clock: "America/Toronto", surveys: [survey(TWO, "2026-05-05T04:03:00Z", { at: "2026-05-05T03:55:00Z" })] };
    answers["/changes"] = { next: null, items: [{ seq: 5, kind: "name", lot: LOT, surveys: [], who: "Ann", made: "2026-05-05T10:00:00Z", undone: null, kept: null }] };
    await open(`#/lots/${LOT}/${TWO}`);
    assert.match(words(archive), /Survey of 2026-05-04 23:55.*Lot named *2026-05-05 06:00/);
    await press("Day");
    assert.deepEqual([...archive.querySelectorAll("button.tick")].map((each) => each.getAttribute("aria-label")?.slice(0, 5)), ["23:55"]);
  });

  it("fill the bar by what is asked, and pale what does not count", async () => {
    await open(`#/lots/${LOT}/${TWO}`);
    const bar = archive.querySelector<TimeBar>("hawk-time-bar")!;
    Object.assign(bar, { marked: new Set([TWO]), shares: new Map([[TWO, 0.25]]) });
    await drawn();
    const ticks = [...bar.querySelectorAll<HTMLElement>("button.tick")].map((tick) => [tick.dataset.surveys, tick.classList.contains("pale"), tick.style.getPropertyValue("--full"), tick.title]);
    assert.deepEqual(ticks, [[ONE, true, "0%", "10:00, no figure uses it"], [TWO, false, "25%", "12:00, Occupancy 25 %"]]);
  });

  it("play the recording of a survey, where there is one", async () => {
    answers["/recordings"] = { next: null, items: [{ name: "20260504T115000Z.mcap", bytes: 1, began: "2026-05-04T11:50:00Z", seconds: 900, survey: null, lot: { id: LOT, name: "North", survey: TWO }, keep: false, under_way: false }] };
    await open(`#/lots/${LOT}/${ONE}`);
    const play = (): HTMLButtonElement => [...archive.querySelectorAll<HTMLButtonElement>(".steps button")].find((each) => each.ariaLabel === "Play the flight" || each.getAttribute("aria-label") === "Play the flight")!;
    assert.equal(play().disabled, true, "it was not recorded");
    route.go({ survey: TWO });
    await drawn();
    assert.equal(play().disabled, false);
    archive.querySelector(".tick.on")?.dispatchEvent(new KeyboardEvent("keydown", { key: "Enter", bubbles: true, cancelable: true }));
    await drawn();
    assert.match(hash, new RegExp(`^#/recordings/${LOT}/20260504T115000Z.mcap$`));
  });

  it("go from survey to survey by arrows, beyond the days that are shown", async () => {
    answers["/statistics/surveys"] = { ...(answers["/statistics/surveys"] as object), surveys: [survey(TWO, "2026-05-04T12:00:00Z"), survey(ONE, "2026-05-04T10:00:00Z")], before: { id: STALL, at: "2026-04-01T10:00:00Z" }, after: null };
    await open(`#/lots/${LOT}/${TWO}`);
    const key = async (name: string): Promise<void> => {
      archive.querySelector(".tick.on")?.dispatchEvent(new KeyboardEvent("keydown", { key: name, bubbles: true, cancelable: true }));
      await drawn();
    };
    await key("ArrowLeft");
    assert.match(hash, new RegExp(`${ONE}$`));
    assert.equal((document.activeElement as HTMLElement).dataset.surveys, ONE, "the focus goes with it");
    assert.ok(asked.filter((each) => each.includes("statistics/surveys")).every((each) => /\?(newest|survey|from)=/.test(each)), "never all surveys of the store");
    await key("ArrowLeft");
    assert.match(hash, new RegExp(`${STALL}$`));
  });

  it("need two surveys that count to compare", async () => {
    await open(`#/compare/${LOT}`);
    assert.match(words(archive), /Two surveys that count are needed/);
  });

  it("show a stall's share and its last looks", async () => {
    await open(`#/lots/${LOT}?show=stalls&stall=${STALL}`);
    assert.match(words(archive), /surveys that saw it in which it was taken: 50\.0 % \(20\.0 to 80\.0 %\)/);
    assert.match(words(archive), /taken · probability of taken 97 %/);
    const map = archive.querySelector<SurveyMap>("hawk-survey-map");
    assert.ok(map?.source);
    assert.deepEqual(map.source.stalls.map(({ label, state, heat }) => [label, state, heat]), [["A 1", "free", 2], ["A 2", "unknown", undefined]], "who was never seen has no colour");
    assert.match(map.known, /50\.0 % \(20\.0 to 80\.0 %\)/);
    await press("A 2");
    assert.match(hash, new RegExp(`stall=${TWO}`));
  });

  it("show stalls by the labels of the list, which are those of the present plan", async () => {
    answers["/statistics/stalls"] = { ...(answers["/statistics/stalls"] as object), labels: ["P 9", "P 10"] };
    await open(`#/lots/${LOT}?show=stalls`);
    const map = archive.querySelector<SurveyMap>("hawk-survey-map")!.source!;
    assert.deepEqual(map.stalls.map(({ label }) => label), ["P 9", "P 10"]);
    assert.deepEqual(map.rows.map(({ row }) => row), ["P"]);
  });

  it("say what of their address is left out", async () => {
    await open(`#/lots/${LOT}/${TWO}?stall=7`);
    assert.match(words(archive), /The address names what is no place of this page, and it is left out: stall=7/);
  });

  it("make a link that is shown once, and take one back", async () => {
    await open(`#/lots/${LOT}?show=links`);
    assert.match(words(archive), /ends 2026-06-03 · Ada/);
    archive.querySelector("form")?.dispatchEvent(new Event("submit", { bubbles: true, cancelable: true }));
    await drawn();
    assert.match(archive.querySelector<HTMLInputElement>(".address")?.value ?? "", /\/shared#secret$/);
    await press("Take back");
    await press("Keep it"); // a double click ends here
    assert.equal(sent.length, 1);
    await press("Take back");
    await press("Take back");
    assert.deepEqual(sent, [[`api/v1/lots/${LOT}/shares`, { days: 30 }], [`api/v1/shares/${ONE}/take-back`, {}]]);
  });

  it("keep a recording at a press, and delete it at the second one", async () => {
    await open("#/recordings");
    assert.equal(archive.querySelectorAll("td b").length, 0);
    const box = archive.querySelector<HTMLInputElement>("input[type=checkbox]")!;
    box.checked = true;
    box.dispatchEvent(new Event("change", { bubbles: true }));
    await drawn();
    const delete_ = [...archive.querySelectorAll("button")].find((each) => words(each) === "Delete")!;
    for (let thrice = 0; thrice < 3; thrice++) {
      delete_.click();
      await drawn();
    }
    assert.equal(sent.length, 1, "a double click deletes nothing");
    await press("Delete for good");
    const place = "api/v1/recordings/20260504T100000Z.mcap";
    assert.deepEqual(sent, [[`${place}/keep`, { keep: true }], [`${place}/delete`, {}]]);
  });

  it("show a link's lot without recordings, links and files", async () => {
    await open(`#secret/lots//${TWO}`, { token: "secret" });
    assert.doesNotMatch(words(archive), /Recordings|Links|csv|Delete/);
    assert.equal(archive.querySelector<SurveyMap>("hawk-survey-map")?.source?.ground, null, "a link shows no picture");
    assert.ok(reads.every((path) => !path.endsWith("/ground")));
    await press("Surveys");
    assert.match(hash, /^#secret\/lots/);
  });

  it("ask once for what two views need, and again after a change", async () => {
    await open(`#/lots/${LOT}/${TWO}`);
    await press("Stalls");
    await go("report");
    await go("lots");
    assert.deepEqual(asked.filter((each, index) => /statistics|stalls/.test(each) && asked.indexOf(each) !== index), []);
    const before = asked.length;
    await press("Delete survey");
    await press("Delete this survey");
    assert.ok(asked.slice(before).some((each) => asked.indexOf(each) < before), "what is shown is asked for again");
    assert.deepEqual(reads.filter((path) => !path.startsWith("api/v1/")), []);
  });

  it("are drawn again in another language", async () => {
    await open(`#/lots/${LOT}/${TWO}`);
    assert.match(words(archive), /Survey of/);
    await inFrench(async () => {
      archive.spoken = "en";
      await drawn();
      archive.spoken = "fr";
      await drawn();
      assert.match(words(archive), /Relevé du/);
      assert.doesNotMatch(words(archive), /Survey of/);
    });
  });

  it("say in the drone's words why there is nothing", async () => {
    delete answers["/statistics/surveys"];
    await open(`#/lots/${LOT}`);
    assert.equal(words(archive.querySelector("[role=alert]")!), "lot: is gone");
  });
});

describe("the change of free stalls in words", () => {
  it("has its interval rounded outward, or none", () => {
    const free = { value: -4, low: -6.6, high: -1.2, surveys: 2 };
    assert.equal(`${headline(free)}, ${interval(free, 0.9)}`, "4 fewer free, 1 to 7 fewer, 9 times in 10.");
    assert.equal(interval({ ...free, high: 0.3 }, 0.9), "7 fewer to 1 more, 9 times in 10.");
    assert.equal(headline({ ...free, value: 0 }), "As many free as before");
    assert.deepEqual([headline(NONE), interval(NONE, 0.9)], ["Nothing to compare", ""]);
  });

  it("names some stalls that are not compared, and counts the rest", () => {
    const gone = Array.from({ length: 8 }, (_, index) => ({ id: ONE, label: `B ${index + 1}` }));
    assert.deepEqual(notCompared({ ...BETWEEN, unknown: 0, begin: [], gone, matched: 2 }), [
      "B 1, B 2, B 3, B 4, B 5, B 6 and 2 others are gone since: not compared.",
      "2 stalls were drawn again in the plan: compared by their ground.",
    ]);
  });
});

describe("the flight's page", () => {
  it("is there without the views of lots, which are read when one is opened", async () => {
    const { readdirSync, readFileSync } = await import("node:fs");
    const { fileURLToPath } = await import("node:url");
    const root = fileURLToPath(new URL("../src/", import.meta.url));
    const files = readdirSync(root, { recursive: true, encoding: "utf8" }).filter((name) => name.endsWith(".ts") && !/^(views|replay|guest)\b/.test(name));
    assert.ok(files.length > 100);
    const found = files.filter((name) => /^import (?!type).*from "[./]+\/views\//m.test(readFileSync(root + name, "utf8")));
    assert.deepEqual(found, []);
  });
});
