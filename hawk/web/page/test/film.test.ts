import "./dom.ts";
import "./no-drawing.ts";
import assert from "node:assert/strict";
import { afterEach, beforeEach, describe, it } from "node:test";
import type { Film, Recording } from "../src/api.ts";
import { beginOf, clockAt, instantAt, lastAt, phasesOf, roundTimes, seenBy, seenWords, spanOf } from "../src/replay/film.ts";
import { expected, filmOnMap } from "../src/replay/film-map.ts";
import { FilmView } from "../src/replay/film-view.ts";
import { LotSource } from "../src/views/link.ts";
import type { SurveyMap } from "../src/views/survey-map.ts";
import { placeOf } from "../src/route/place.ts";
import type { Feature } from "../src/views/survey-source.ts";
import { settle } from "./fakes.ts";
import { inFrench } from "./french.ts";
import { words } from "./stage.ts";
import { surveyMap } from "./api.ts";

const NAME = "20260504T143000Z.mcap";
const LATER = "20260504T153000Z.mcap";
const LOT = "00000000-0000-4000-8000-000000000001";
const SURVEY = "00000000-0000-4000-8000-00000000000a";
const HTML = "<b onclick='alert(1)'>Armed</b>";
const SAID = { text: "Took off.", code: "took-off", values: {} };
/** Ten seconds, two pictures and two maps, from 14:30:00 UTC on. */
const FILM: Film = {
  name: NAME,
  program: "hawk-drone 0.4.0",
  began: "2026-05-04T14:30:00Z",
  seconds: 100,
  clock: [],
  problem: "",
  datum: [52, 5],
  phases: [{ at: 5, state: "Arm" }, { at: 10, state: "Takeoff" }, { at: 20, state: "Hover" }, { at: 20, state: "Autonomous Explore" }, { at: 80, state: "Land" }],
  messages: [{ at: 10, level: "info", text: "Took off.", details: "", sentences: [SAID] }, { at: 30, level: "warning", text: HTML, details: "", sentences: [] }],
  track: [[10, 0, 0, 0, 350], [20, 0, 0, 20, 350], [24, 12, 0, 20, 10]],
  battery: [[5, 99, 700], [30, 91, 720]],
  counts: [[5, 0, 0, 0], [25, 1, 1, 0]],
  homes: [[10, 0, 0]],
  footprints: [[20, 8, -8, 8, 8, -8, 8, -8, -8]],
  fences: [{ at: 5, ring: [[0, 0], [0, 9], [9, 9]], zones: [] }],
  plan: [],
  pictures: [12, 24, 28],
  maps: [22, 26],
};

/** A stall of some metres at metres east of the place where the drone stood. */
function stall(id: string, label: string, east: number, state: string): Feature {
  const at = (x: number, y: number): [number, number] => [5 + (east + x) / 68_677, 52 + y / 111_250];
  return { id, geometry: { type: "Polygon", coordinates: [[at(0, 0), at(0, 5), at(2, 5), at(2, 0), at(0, 0)]] }, properties: { amenity: "parking_space", ref: label, state } };
}

const STORED = surveyMap(stall("a", "A 1", 0, "free"), stall("b", "A 2", 3, "taken"), stall("c", "A 3", 60, "free"));
const RECORDED = [stall("1", "", 0.2, "free"), stall("2", "", 3.1, "taken")];

function recording(name: string, more: Partial<Recording> = {}): Recording {
  return { name, bytes: 186e6, began: "2026-05-04T14:30:00Z", seconds: 100, survey: "000001-x", lot: { id: LOT, name: "Market", time_zone: "America/Toronto", survey: SURVEY }, drone: null, keep: false, keep_end: "2026-06-03T14:30:00Z", under_way: false, ...more };
}

describe("a film", () => {
  it("finds what was last at a time", () => {
    assert.deepEqual([-1, 2, 3.9, 4, 99].map((at) => lastAt([2, 4, 6], at)), [-1, 0, 0, 1, 2]);
    assert.equal(lastAt([], 5), -1);
    assert.deepEqual([0, 59.9, 187, -1].map(spanOf), ["0:00", "0:59", "3:07", "0:00"]);
  });

  it("speaks of the lot's clock, over leaps too, and of its own where it knows none", () => {
    assert.equal(clockAt(FILM, 141, "America/Toronto"), "10:32:21");
    assert.equal(clockAt({ ...FILM, clock: [[50, 3600]] }, 60, "UTC"), "15:31:00");
    assert.equal(clockAt({ ...FILM, began: null }, 141, "UTC"), "2:21");
    assert.deepEqual(roundTimes(FILM).map((at) => clockAt(FILM, at, "UTC")), ["14:30:00", "14:30:30", "14:31:00", "14:31:30"]);
  });

  it("has phases in people's words, and begins at the take-off", () => {
    assert.deepEqual(phasesOf(FILM).map(({ from, to, title }) => [from, to, title]), [[0, 5, "On the ground"], [5, 10, "Arming"], [10, 20, "Taking off"], [20, 80, "Exploring"], [80, 100, "Landing"]]);
    assert.equal(beginOf(FILM), 10);
    assert.equal(beginOf({ ...FILM, phases: [] }), 0);
  });

  it("knows drone, figures and fence of a moment, and nothing before they were known", () => {
    const now = instantAt(FILM, 22);
    assert.deepEqual([now.drone?.north, now.drone?.east, Math.round(now.drone!.yaw / (Math.PI / 180))], [6, 0, 360]);
    assert.deepEqual([now.height, now.fromHome, now.battery, now.left, now.free, now.fence.length, now.footprint.length], [20, 6, 99, 700, 0, 3, 4]);
    const first = instantAt(FILM, 1);
    assert.deepEqual([first.drone, first.height, first.battery, first.fromHome, first.footprint], [null, null, null, null, []]);
    assert.equal(seenWords(instantAt(FILM, 30), 98), "2 of 98 stalls seen at this moment");
    assert.equal(seenWords(instantAt(FILM, 30), 0), "2 stalls seen at this moment");
  });
});

describe("the map of a film", () => {
  const ground = { datum: [52, 5] as [number, number], place: { north: 0, east: 0, turn: 0 }, cells: 256, cell_m: 0.1, tiles: [] };

  it("shows what was known with the labels of the survey, and the rest as still to be found", () => {
    const outcome = { survey: SURVEY, map: STORED, ground };
    const found = filmOnMap(FILM, RECORDED, expected(FILM, outcome), outcome, seenBy(FILM, 22));
    assert.deepEqual(found!.shown.stalls.map(({ label, state }) => [label, state]), [["A 1", "free"], ["A 2", "taken"]]);
    assert.deepEqual(found!.unseen.map(({ label }) => label), ["A 3"]);
    assert.deepEqual([found!.shown.survey, found!.shown.ground?.datum], [SURVEY, [52, 5]]);
  });

  it("leaves the survey where the camera saw it, though the store has turned and moved it onto the lot", () => {
    const place = { north: 4, east: -3, turn: Math.PI / 2 };
    const [one] = expected(FILM, { survey: SURVEY, map: STORED, ground: { ...ground, place } });
    // (north 2.5, east 1) in the lot, less the shift (-1.5, 4), turned back a quarter
    assert.deepEqual([one!.north, one!.east].map((each) => Math.round(10 * each) / 10), [4, 1.5]);
  });

  it("is the plan's where nothing was stored, whose stalls that nobody looked at are still to be found", () => {
    const plan = [{ north: 2.5, east: 1, angle: 0, width: 2, length: 5, label: "B 7" }, { north: 2.5, east: 61, angle: 0, width: 2, length: 5, label: "B 9" }];
    const film = { ...FILM, plan };
    const found = filmOnMap(film, [stall("1", "", 0, "unknown"), stall("2", "", 60, "unknown"), stall("3", "", 90, "suggested")], expected(film, null), null, seenBy(film, 22));
    assert.deepEqual(found!.shown.stalls.map(({ label, state }) => [label, state]), [["B 7", "unknown"]]);
    assert.deepEqual(found!.unseen.map(({ label }) => label), ["B 9"]);
    assert.equal(filmOnMap({ ...film, datum: null }, [], [], null, []), null);
  });
});

describe("the recordings of a lot", () => {
  it("are not asked for by a role that is for some lots, or by a link", async () => {
    for (const [base, mayAsk] of [[`lots/${LOT}`, false], ["shared/token", true]] as const) {
      const source = new LotSource(base, mayAsk);
      assert.deepEqual([source.hasRecordings, await source.recordings()], [false, []]);
    }
  });
});

describe("a recording that is played", () => {
  const before = globalThis.fetch;
  let film: Film;
  let view: FilmView;
  let draw: ((passed: number) => void) | null;
  let went: Record<string, string>[];
  let refusal: { status: number; detail: string } | null;

  beforeEach(() => {
    [film, draw, went, refusal] = [FILM, null, [], null];
    globalThis.fetch = (address, options) => {
      assert.equal(options?.method, undefined, "a film only reads");
      const path = (address as string).replace("api/v1/", "");
      if (path === `recordings/${NAME}/film`) return Promise.resolve(refusal ? Response.json({ field: "", ...refusal }, { status: refusal.status }) : Response.json(film));
      if (path.startsWith(`recordings/${NAME}/film/maps/`)) return Promise.resolve(Response.json({ features: path.endsWith("/0") ? RECORDED.slice(0, 1) : RECORDED }));
      if (path.endsWith("/map")) return Promise.resolve(Response.json(STORED));
      if (path.includes("statistics/surveys")) return Promise.resolve(Response.json({ surveys: [], clock: "America/Toronto" }));
      return Promise.resolve(new Response("", { status: 404 }));
    };
  });

  afterEach(() => {
    view.remove();
    globalThis.fetch = before;
  });

  async function open(address = `#/recordings/${LOT}/${NAME}`, rows = [recording(NAME), recording(LATER)]): Promise<void> {
    view = new FilmView();
    view.every = (next) => {
      draw = next;
      return () => (draw = null);
    };
    const source = new LotSource(`lots/${LOT}`);
    Object.assign(view, { place: placeOf(address), recordings: rows, sourceOf: () => source });
    view.addEventListener("archive-go", (event) => {
      const change = (event as CustomEvent<Record<string, string>>).detail;
      went.push(change);
      view.place = { ...view.place, ...change };
    });
    document.body.replaceChildren(view);
    await drawn();
  }

  async function drawn(): Promise<void> {
    for (let k = 0; k < 8; k++) {
      await settle();
      await view.updateComplete;
    }
  }

  async function press(name: string): Promise<void> {
    const all = [...view.querySelectorAll("button")];
    const found = all.find((each) => each.getAttribute("aria-label") === name) ?? all.find((each) => words(each) === name);
    assert.ok(found, `${name}: ${words(view)}`);
    found.click();
    await drawn();
  }

  function key(name: string, target: Element = document.body): void {
    target.dispatchEvent(new document.defaultView!.KeyboardEvent("keydown", { key: name, bubbles: true }));
  }

  const step = (seconds: number): void => draw?.(seconds);
  const slider = (): HTMLInputElement => view.querySelector("input[type=range]")!;
  const picture = (): string | null => view.querySelector("img")?.getAttribute("src") ?? null;
  const map = (): SurveyMap => view.querySelector("hawk-survey-map")!;

  it("begins at the take-off, says that it is none live, and until when it is kept", async () => {
    await open();
    assert.equal(slider().getAttribute("aria-valuetext"), "10:30:10, 0:10");
    assert.match(words(view), /Recording, not live Market · 2026-05-04 10:30 · 1 min 40 s · 186 MB · kept until 2026-06-03 · Pale: not seen yet/);
    assert.equal(picture(), null, "no picture yet");
    assert.equal(map().scene.unseen.length, 3);
  });

  it("shows the moment of its address", async () => {
    await open(`#/recordings/${LOT}/${NAME}?t=30`);
    assert.equal(picture(), `api/v1/recordings/${NAME}/film/pictures/2`);
    assert.match(words(view), /Recorded, 10:30:28/);
    assert.match(words(view), /1free 1taken \?0unclear2 of 3 stalls seen at this moment/);
    assert.match(words(view), /91.%battery, 12 min until it must return 20.mheight 12.mfrom home/);
    assert.deepEqual(map().source?.stalls.map(({ label }) => label), ["A 1", "A 2"]);
    assert.equal(map().scene.trail.length, 3);
  });

  it("jumps to a message, which is text, and keeps the moment in the address", async () => {
    await open();
    await press("10:30:30");
    assert.equal(view.querySelectorAll("li b").length, 0);
    assert.equal(words(view.querySelector("li.on")!).includes(HTML), true);
    assert.deepEqual(went.at(-1), { t: "30" });
    await inFrench(async () => {
      view.revision += 1;
      await drawn();
      assert.match(words(view), /10:30:10 A décollé\.|10:30:10 Décollé\.|10:30:10 Décolle\./);
    });
  });

  it("plays at the speed that was chosen, pauses, ends at its end, and begins again", async () => {
    await open();
    const speed = view.querySelector("select")!;
    speed.value = "16";
    speed.dispatchEvent(new document.defaultView!.Event("change"));
    await press("Play");
    step(1);
    await drawn();
    assert.match(slider().getAttribute("aria-valuetext")!, /0:26$/);
    const ground = map().source;
    step(0.1);
    await drawn();
    assert.equal(map().source, ground, "the drone alone moves between two maps");
    await press("Pause");
    assert.equal(draw, null);
    assert.deepEqual(went.at(-1), { t: "27.6" });
    key(" ");
    for (let k = 0; k < 5; k++) step(1);
    await drawn();
    assert.match(slider().getAttribute("aria-valuetext")!, /1:40$/);
    assert.equal(draw, null);
    key(" ");
    await drawn();
    assert.match(slider().getAttribute("aria-valuetext")!, /0:00$/);
  });

  it("goes by arrow keys, but for those of a field", async () => {
    await open();
    key("ArrowRight");
    key("ArrowLeft", view.querySelector("select")!);
    key("ArrowLeft", view.querySelector(".ol")!);
    await drawn();
    assert.match(slider().getAttribute("aria-valuetext")!, /0:15$/);
  });

  it("asks for the next picture when the last one is there", async () => {
    await open(`#/recordings/${LOT}/${NAME}?t=13`);
    assert.equal(picture()?.at(-1), "0");
    slider().value = "29";
    slider().dispatchEvent(new document.defaultView!.Event("input"));
    await drawn();
    assert.equal(picture()?.at(-1), "0", "the one before is still asked for");
    view.querySelector("img")!.dispatchEvent(new document.defaultView!.Event("load"));
    await drawn();
    assert.equal(picture()?.at(-1), "2");
  });

  it("leads to the recording after, and to all of them", async () => {
    await open();
    assert.equal(view.querySelector<HTMLButtonElement>("[aria-label='The recording before']")!.disabled, true);
    await press("All recordings");
    assert.deepEqual(went.at(-1), { recording: "", t: "" });
    view.place = placeOf(`#/recordings/${LOT}/${NAME}`);
    await drawn();
    await press("The recording after");
    assert.deepEqual(went.at(-1), { recording: LATER, t: "" });
  });

  it("without a lot shows what it knows, by the browser's clock", async () => {
    await open(`#/recordings//${NAME}`, [recording(NAME, { lot: null, keep_end: null, keep: true })]);
    assert.equal(map().scene.unseen.length, 0);
    assert.match(words(view), /· kept ·/);
  });

  it("says where a recording is damaged, and why it cannot be shown", async () => {
    film = { ...FILM, problem: "the file has no end" };
    await open();
    assert.match(words(view), /damaged after 1:40: the file has no end/);
    view.remove();
    refusal = { status: 409, detail: "a recording is shown once the motors are off" };
    await open();
    assert.match(words(view), /All recordings ?a recording is shown once the motors are off/);
  });

  it("says that a recording is gone, also when it was deleted while it plays", async () => {
    let asked = 0;
    await open(`#/recordings/${LOT}/${NAME}?t=30`);
    view.addEventListener("archive-changed", () => {
      asked += 1;
      view.recordings = [recording(LATER)];
    });
    await press("Play");
    view.querySelector("img")!.dispatchEvent(new document.defaultView!.Event("error"));
    await drawn();
    assert.deepEqual([asked, draw], [1, null], "it does not play on");
    assert.match(words(view), /This recording is not there any more: it was deleted\./);
    view.remove();
    refusal = { status: 404, detail: "there is no recording with this name; GET /api/v1/recordings lists them" };
    await open(`#/recordings/${LOT}/${NAME}`, [recording(LATER)]);
    assert.match(words(view), /it was deleted/);
    assert.doesNotMatch(words(view), /GET/);
  });

  it("waits while the recording is being read", async () => {
    refusal = { status: 503, detail: "The recording is being read: ask again in some seconds." };
    await open();
    assert.match(words(view), /The recording is being read …/);
  });
});
