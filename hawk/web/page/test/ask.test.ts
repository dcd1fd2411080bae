import "./dom.ts";
import "./no-drawing.ts";
import assert from "node:assert/strict";
import { afterEach, beforeEach, describe, it } from "node:test";
import type { AskedUse, Cell, Estimate } from "../src/api.ts";
import { placeOf } from "../src/route/place.ts";
import { Route } from "../src/route/route.ts";
import { Guest } from "../src/shell/guest.ts";
import { TopBar } from "../src/shell/top-bar.ts";
import { LateViews } from "../src/shell/views.ts";
import { amountOf, answerWords, behindWords, daysWords, hoursWords, mostOf, periodWords, rangeOf, shadeOf } from "../src/views/ask-words.ts";
import "../src/parts/figures.ts";
import "../src/parts/maps.ts";
import { LotViews } from "../src/views/lot-views.ts";
import { commandOf, daysOf, daysText, hoursOf, hoursShown, hoursText, runs, switchedPart } from "../src/views/question.ts";
import { refusal } from "./api.ts";
import { settle } from "./fakes.ts";
import { inFrench } from "./french.ts";
import { words } from "./stage.ts";

const LOT = "00000000-0000-4000-8000-000000000001";
const ONE = "00000000-0000-4000-8000-00000000000a";
const NONE: Estimate = { value: null, low: null, high: null, surveys: 0 };
const NAMES = ["Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday", "Sunday"] as const;

function estimate(value: number, surveys: number): Estimate {
  return { value, low: value - 0.1, high: value + 0.05, surveys };
}

function timesStalls({ value, low, high, surveys }: Estimate): Estimate {
  return { value: value && 25 * value, low: low && 25 * low, high: high && 25 * high, surveys };
}

/** The answer to a question, of a lot that was flown on Monday at 8 and 10, and on Saturday at 10. */
function answer(days: number[], hours: number[], more: Partial<AskedUse> = {}): AskedUse {
  const flown = new Map([["0 8", estimate(0.86, 2)], ["0 10", estimate(0.95, 2)], ["5 10", estimate(0.4, 1)]]);
  const cells = NAMES.flatMap((weekday, day) =>
    Array.from({ length: 24 }, (_, hour): Cell => {
      const found = flown.get(`${day} ${hour}`);
      return { weekday, hour, is_asked: days.includes(day) && hours.includes(hour), days: found ? 1 : 0, occupancy: found ?? NONE, accumulation: timesStalls(found ?? NONE) };
    }),
  );
  const asked = cells.filter((cell) => cell.is_asked && cell.days > 0);
  return {
    lot: LOT, name: "Market Street", clock: "America/Toronto", interval: 0.9,
    asked: { weekdays: days.map((day) => NAMES[day]!), hours, rows: ["B"], zones: [], kinds: [], sections: [] },
    unit: "stalls", places: null, stalls: 25, days: 1, hours: asked.length, occupancy: asked.length > 0 ? estimate(0.9, 4) : NONE, accumulation: asked.length > 0 ? { value: 22.5, low: 21.8, high: 23.2, surveys: 4 } : NONE,
    fullest: asked[1] ?? asked[0] ?? null, emptiest: asked[0] ?? null, cells,
    others: [{ row: "A", stalls: 24, occupancy: estimate(0.3, 4) }, { row: "C", stalls: 3, occupancy: NONE }],
    surveys: asked.length > 0 ? [{ survey: ONE, at: "2026-05-04T08:20", occupancy: estimate(0.9, 1), accumulation: timesStalls(estimate(0.9, 1)) }] : [], left_out: [], ...more,
  };
}

describe("days and hours of a question", () => {
  it("are read and written alike, over the week's end too", () => {
    assert.deepEqual(daysOf("mon-fri"), [0, 1, 2, 3, 4]);
    assert.deepEqual(daysOf("sat-mon,wed"), [0, 2, 5, 6]);
    assert.deepEqual(hoursOf("7-9,16"), [7, 8, 16]);
    for (const text of ["", "mon-fri", "mon,wed-thu,sun"]) assert.equal(daysText(daysOf(text)), text);
    for (const text of ["", "7-11", "0-2,16,20-24"]) assert.equal(hoursText(hoursOf(text)), text);
  });

  it("are all where they cannot be read", () => {
    for (const text of ["someday", "mon-", "-"]) assert.equal(daysOf(text).length, 7, text);
    for (const text of ["25", "9-8", "7-30", "7-"]) assert.equal(hoursOf(text).length, 24, text);
    assert.deepEqual(runs([3, 1, 2, 7, 7]), [[1, 3], [7, 7]]);
  });

  it("are words, in French too", async () => {
    assert.deepEqual([daysWords("mon-fri,sun"), daysWords(""), hoursWords("7-11,16"), hoursWords("")], ["Mon–Fri, Sun", "every day", "7–11, 16–17", "any hour"]);
    await inFrench(() => assert.deepEqual([daysWords("mon-fri"), hoursWords("7-11")], ["lun.–ven.", "7 et 11 h"]));
  });

  it("have a period: a month, days, or every survey", () => {
    const of = (from: string, to: string): unknown => Object.values(periodWords({ from, to }));
    assert.deepEqual(of("2026-02-01", "2026-02-28"), ["month", "February 2026"]);
    assert.deepEqual(of("2026-05-04", "2026-05-31"), ["days", "4 May 2026 to 31 May 2026"]);
    assert.deepEqual(of("", ""), ["all", "all surveys"]);
    assert.deepEqual(of("2026-13-45", ""), ["days", "2026-13-45 on"], "what is no day stands as it was written");
  });

  it("are a line for a terminal, in which a name is one word", () => {
    const place = placeOf(`#/report/${LOT}?part=row.B&part=zone.Joe's+%24(rm)&days=mon-fri&hours=7-11&from=2026-05-01`);
    assert.equal(commandOf("North lot", place), `hawk-drone stats 'North lot' --row B --zone 'Joe'\\''s $(rm)' --weekday mon-fri --hour 7-11 --from 2026-05-01`);
  });
});

describe("an answer in words", () => {
  it("says stalls, the fullest and the emptiest hour, what stands behind it, and when nobody flew", async () => {
    const found = answer([0, 1], [7, 8, 9, 10]);
    assert.equal(answerWords(found), "22 to 23 of 25 stalls are taken on average. Fullest on Mondays at 10:00 (95 %), emptiest on Mondays at 8:00 (86 %).");
    assert.equal(behindWords(found), "From 4 surveys on 1 day, 4 May 2026, Toronto time. Nobody flew at 7 or 9.");
    await inFrench(() => assert.match(behindWords(found), /D’après 4 relevés sur 1 jour, 4 mai 2026, heure\u00a0: Toronto\. Personne n’a volé à 7 ou 9\./));
  });

  it("names no fullest hour where only one was flown", () => {
    assert.equal(answerWords(answer([0], [8])), "22 to 23 of 25 stalls are taken on average.");
  });

  it("counts vehicles of the places of sections, or alone", async () => {
    const number = { value: 3.5, low: 3, high: 5.25, surveys: 4 };
    const counted = answer([0], [8], { unit: "places", places: 4, stalls: 0, accumulation: number, occupancy: { value: 0.875, low: 0.75, high: 1.3125, surveys: 4 } });
    assert.equal(answerWords(counted), "3.5 vehicles (3.0 to 5.3) are parked on 4 places on average.");
    assert.deepEqual([amountOf(counted), rangeOf(counted)], ["88 %", "75 to 131 %"]);
    const alone = { ...counted, unit: "vehicles" as const, places: null, occupancy: NONE };
    assert.equal(answerWords(alone), "3.5 vehicles (3.0 to 5.3) are parked on average. Nobody said how many places there are.");
    assert.deepEqual([amountOf(alone), rangeOf(alone), shadeOf(alone, alone)], ["3.5", "3.0 to 5.3", 3.5 / mostOf(alone)]);
    await inFrench(() => assert.equal(answerWords(counted), "3,5 véhicules (3,0 à 5,3) sont garés sur 4 places en moyenne."));
  });

  it("asks for sections or for stalls, never for both", () => {
    assert.deepEqual(switchedPart(["row.A", "zone.West"], "section.Elm Street"), ["section.Elm Street"]);
    assert.deepEqual(switchedPart(["section.Elm Street"], "section.Yard"), ["section.Elm Street", "section.Yard"]);
    assert.deepEqual(switchedPart(["section.Elm Street"], "row.A"), ["row.A"]);
    assert.deepEqual(switchedPart(["row.A", "row.B"], "row.A"), ["row.B"]);
  });

  it("shows the hours that were flown or asked", () => {
    assert.deepEqual(hoursShown(answer([0], [8])), [7, 18]);
    assert.deepEqual(hoursShown(answer([0], [5, 22])), [5, 22]);
  });
});

describe("Report", () => {
  const before = globalThis.fetch;
  let reads: string[];
  let hash: string;
  let route: Route;
  let views: LotViews;
  /** In place of the answer that is made of the question. */
  let found: AskedUse | null;

  beforeEach(() => {
    reads = [];
    found = null;
    globalThis.fetch = (address) => {
      reads.push(address as string);
      const [path = "", search = ""] = (address as string).split("?");
      const given = new URLSearchParams(search);
      if (path.endsWith("/ask")) return Promise.resolve(given.get("row") === "Z" ? refusal(400, "the lot has none that is called 'Z'", { field: "row" }) : Response.json(found ?? answer(daysOf(given.get("weekday") ?? ""), hoursOf(given.get("hour") ?? ""))));
      if (path.endsWith("/statistics")) return Promise.resolve(Response.json({ parts: given.get("by") === "row" ? [{ name: "A" }, { name: "B" }] : [] }));
      if (path.endsWith("/report.pdf")) return Promise.resolve(refusal(501, "install hawk-drone[report]"));
      if (path.endsWith("/report.xlsx")) return Promise.resolve(new Response("12345", { headers: { "Content-Disposition": 'attachment; filename="Market Street.xlsx"' } }));
      return Promise.resolve(Response.json({ lot: LOT, name: "Market Street", clock: "America/Toronto", surveys: [{ id: ONE, at: "2026-05-04T12:20:00Z", left_out_code: "", occupancy: estimate(0.5, 1) }] }));
    };
  });

  afterEach(() => {
    globalThis.fetch = before;
  });

  async function drawn(): Promise<void> {
    for (let k = 0; k < 6; k++) {
      await settle();
      await views.updateComplete;
    }
  }

  async function open(search: string): Promise<void> {
    hash = `#/report/${LOT}?${search}`;
    route = new Route({ hash: () => hash, write: (next) => (hash = next) });
    views = Object.assign(new LotViews(), { route, access: { lots: [{ id: LOT, name: "Market Street" }], unlisted: "", token: null, mayChange: true } });
    document.body.replaceChildren(views);
    await drawn();
  }

  async function press(label: string): Promise<void> {
    const found = [...views.querySelectorAll<HTMLElement>("button, .picks input")].find((each) => each.getAttribute("aria-label") === label || words(each) === label);
    assert.ok(found, `${label}: ${words(views)}`);
    found.click();
    if (found instanceof HTMLInputElement) found.dispatchEvent(new Event("change", { bubbles: true }));
    await drawn();
  }

  const cell = (day: number, hour: number): HTMLElement => views.querySelector<HTMLElement>(`[data-day="${day}"][data-hour="${hour}"]`)!;

  it("asks what its address says, as a sentence with its answer, and figures of the asked hours with the whole", async () => {
    await open("part=row.B&days=mon-fri&hours=7-11&from=2026-05-01&to=2026-05-31");
    assert.ok(reads.includes(`api/v1/lots/${LOT}/statistics/ask?row=B&weekday=mon-fri&hour=7-11&from=2026-05-01&to=2026-05-31`), reads.join("\n"));
    assert.match(words(views.querySelector(".question p")!), /How full is Row B on Mon–Fri between 7–11 in May 2026\s*\?/);
    assert.match(words(views.querySelector(".answer")!), /90 % taken80 to 95 %, 9 times in 10/);
    const rows = [...views.querySelectorAll(".figures tr")].map(words);
    assert.deepEqual(rows.slice(1), ["Mon8:00–9:00286 %76 to 91 %", "Mon10:00–11:00295 %85 to 100 %", "All, each survey once490 %80 to 95 %"]);
    assert.match(words(views), /Other rows, same hours: A 30 % hawk-drone stats 'Market Street' --row B/);
  });

  it("says why there is no answer: nobody flew then, no survey counts, or the lot has none", async () => {
    const none = { value: null, low: null, high: null, surveys: 0 };
    const empty = { ...answer([0], [8]), occupancy: none, accumulation: none, surveys: [], fullest: null, emptiest: null };
    for (const [search, leftOut, said] of [["days=mon", 0, /Nobody flew then/], ["days=mon", 2, /No survey of then counts\. *2 surveys of this period are left out/], ["", 0, /This lot has no survey:/]] as const) {
      found = { ...empty, left_out: Array.from({ length: leftOut }, () => ({ survey: ONE, ended: "2026-05-04T12:20:00Z", why: "" })) };
      await open(search);
      assert.match(words(views.querySelector(".answer")!), said);
    }
  });

  it("says each hour of the week to a screen reader: share, surveys and interval, or that nobody flew", async () => {
    await open("part=row.B&days=mon-fri&hours=7-11");
    assert.equal(views.querySelectorAll("[role=row]").length, 8);
    assert.equal(cell(0, 8).getAttribute("aria-label"), "Monday 8:00–9:00: 86 %, 2 surveys, 76 to 91 %");
    assert.equal(cell(0, 9).getAttribute("aria-label"), "Monday 9:00–10:00: nobody flew");
    assert.deepEqual([cell(0, 8), cell(5, 10)].map((each) => each.getAttribute("aria-selected")), ["true", "false"]);
    assert.equal(views.querySelectorAll("[role=gridcell][tabindex='0']").length, 1, "the Tab key comes to one of them");
    await press("24 hours");
    assert.equal(views.querySelectorAll("[role=gridcell]").length, 168);
  });

  it("asks the hour that is pressed, the hours of a drag, and those that the keys chose", async () => {
    await open("part=row.B");
    const at = (name: string, target: Element): boolean => target.dispatchEvent(new PointerEvent(name, { bubbles: true, button: 0, pointerType: "mouse" }));
    at("pointerdown", cell(0, 8));
    at("pointerup", cell(0, 8));
    await drawn();
    assert.match(hash, /days=mon&hours=8$/);
    document.elementFromPoint = () => cell(2, 10);
    at("pointerdown", cell(0, 8));
    at("pointermove", cell(2, 10));
    at("pointerup", cell(2, 10));
    await drawn();
    assert.match(hash, /days=mon-wed&hours=8-11$/);
    cell(5, 10).dispatchEvent(new Event("focus"));
    await drawn();
    for (const [key, shiftKey] of [["ArrowDown", false], ["ArrowUp", true], ["ArrowRight", true], ["Enter", false]] as const) {
      views.querySelector(".heat")!.dispatchEvent(new KeyboardEvent("keydown", { key, shiftKey, bubbles: true }));
      await drawn();
    }
    assert.match(hash, /days=sat-sun&hours=10-12$/);
    await press("The whole week");
    assert.match(hash, /\?part=row\.B$/);
  });

  it("is chosen word by word: rows, days, hours, a month", async () => {
    await open("");
    await press("Part of the lot: the whole lot");
    await press("B");
    assert.match(hash, /part=row\.B$/);
    await press("Done");
    await press("Days of the week: every day");
    await press("Mon–Fri");
    await press("Wednesday");
    assert.match(hash, /days=mon-tue%2Cthu-fri/);
    await press("Done");
    await press("Hours of the day: any hour");
    await press("7–11");
    await press("7:00–8:00");
    assert.match(hash, /hours=8-11/);
    await press("Done");
    await press("Period: all surveys");
    await press("May 2026, 1 survey");
    assert.match(hash, /from=2026-05-01&to=2026-05-31/);
    views.querySelector(".picks")!.dispatchEvent(new KeyboardEvent("keydown", { key: "Escape", bubbles: true }));
    await drawn();
    assert.equal(views.querySelector(".picks"), null);
  });

  it("says why there is no answer, and when nobody flew", async () => {
    await open("part=row.Z");
    assert.match(words(views.querySelector("[role=alert]")!), /The lot has no row, zone or kind of this name/);
    await inFrench(async () => {
      await open("part=row.Z&show=document");
      assert.doesNotMatch(words(views), /the lot has none/);
    });
    await open("part=row.Z");
    views.querySelector<HTMLButtonElement>("[role=alert] button")!.click();
    await drawn();
    assert.match(words(views.querySelector(".question")!), /How full is Row A/, "the rows that there are, are offered");
    await open("part=row.B&days=sun");
    assert.match(words(views.querySelector(".answer")!), /Nobody flew then\.Choose other hours/);
  });

  it("is printed as the drone writes it, and downloaded; a refused PDF says what to do", async () => {
    globalThis.URL.createObjectURL = () => "blob:report";
    globalThis.URL.revokeObjectURL = () => undefined;
    await open("part=row.B&days=mon-fri&hours=7-11&show=document");
    const frame = views.querySelector("iframe")!;
    assert.match(frame.getAttribute("src")!, new RegExp(`^api/v1/lots/${LOT}/report\\.html\\?row=B&weekday=mon-fri&hour=7-11&language=en&paper=(a4|letter)$`));
    assert.equal(frame.getAttribute("sandbox"), "allow-same-origin allow-modals", "nothing in it runs");
    await press("PDF");
    assert.match(words(views.querySelector("[role=status]")!), /PDF: install hawk-drone\[report\]\s*Print it by the browser instead\./);
    await press("Workbook");
    assert.match(words(views), /Market Street\.xlsx is saved, 5 B\./);
    await press("The question");
    assert.match(hash, /hours=7-11$/);
  });
});

describe("the report over several lots", () => {
  it("is the drone's document of these lots, with their period, and leads back to all of them", async () => {
    let hash = `#/lots/${LOT}?show=document&lots=${LOT}&lots=${ONE}&from=2026-05-04`;
    const route = new Route({ hash: () => hash, write: (next) => (hash = next) });
    const views = Object.assign(new LotViews(), { route, access: { lots: [LOT, ONE].map((id) => ({ id, name: id, time_zone: "UTC", stalls: 1, survey_count: 0, due: null, last_survey: null, place: [52, 5] })), unlisted: "", token: null, mayChange: true, operator: null } });
    document.body.replaceChildren(views);
    await settle();
    await views.updateComplete;
    assert.match(views.querySelector("iframe")!.getAttribute("src")!, new RegExp(`^api/v1/report\\.html\\?lot=${LOT}&lot=${ONE}&from=2026-05-04&language=en&paper=`));
    [...views.querySelectorAll("button")].find((each) => words(each) === "All lots")!.click();
    assert.match(hash, /show=all$/, "the lots of the document are no part of another place");
  });
});

describe("whose clock it is", () => {
  it("stands once in the bar, with the newest survey's day by it", async () => {
    const lot = { id: LOT, name: "Market Street", time_zone: "America/Toronto", survey_count: 15, last_survey: { id: ONE, ended: "2026-05-11T14:02:00Z" } };
    for (const [place, said] of [[`#/lots/${LOT}`, "Mon 11 May · Toronto time"], [`#/report/${LOT}`, "15 surveys · Toronto time"]] as const) {
      const route = new Route({ hash: () => place, write: () => undefined });
      const top = Object.assign(new TopBar(), { route, place: route.place, views: ["lots"], lots: [lot] });
      document.body.replaceChildren(top);
      await top.updateComplete;
      assert.equal(words(top.querySelector(".lot .sub")!).replaceAll("\u202f", " "), said);
    }
  });
});

describe("a link", () => {
  const before = globalThis.fetch;
  afterEach(() => {
    globalThis.fetch = before;
  });

  async function guest(response: () => Response): Promise<Guest> {
    globalThis.fetch = () => Promise.resolve(response());
    const route = new Route({ hash: () => "#secret", write: () => undefined }, "secret");
    const made = Object.assign(new Guest(), { route, token: "secret", late: new LateViews(() => undefined, () => new Promise(() => undefined)) });
    document.body.replaceChildren(made);
    for (let k = 0; k < 4; k++) {
      await settle();
      await made.updateComplete;
    }
    return made;
  }

  it("that has ended says so in the reader's language, and leads nowhere", async () => {
    const ended = (): Response => refusal(404, "this link has ended, or was taken back", { field: "token" });
    const made = await guest(ended);
    assert.match(words(made), /This link has ended, or was taken back\. Ask the person/);
    assert.equal(made.querySelectorAll("nav a").length, 0);
    await inFrench(async () => assert.match(words(await guest(ended)), /Ce lien a pris fin ou a été repris/));
  });

  it("that ends while it is read says so once, in place of the view", async () => {
    const made = await guest(() => Response.json({ lot: LOT, name: "North", clock: "UTC", surveys: [] }));
    made.querySelector(".view")!.dispatchEvent(new CustomEvent("archive-ended", { detail: "It ended." }));
    await made.updateComplete;
    assert.match(words(made), /This link shows nothing *It ended\./);
    assert.doesNotMatch(words(made), /North/);
  });

  it("shows no view that would be empty: one survey cannot be compared", async () => {
    const with_ = (count: number) => () => Response.json({ lot: LOT, name: "North", clock: "UTC", surveys: Array.from({ length: count }, (_, k) => ({ id: String(k), at: "2026-05-11T14:02:00Z", ended: "2026-05-11T14:02:00Z", left_out_code: "" })) });
    const shown = async (count: number): Promise<string[]> => [...(await guest(with_(count))).querySelectorAll("nav a")].map(words);
    assert.deepEqual(await shown(0), ["Lots"]);
    assert.deepEqual(await shown(1), ["Lots", "Report"]);
    assert.deepEqual(await shown(2), ["Lots", "Compare", "Report"]);
  });
});
