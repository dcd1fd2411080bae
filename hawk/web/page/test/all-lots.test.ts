import "./no-drawing.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import type { LotPlaces } from "../src/api.ts";
import { LocalPlane } from "../src/fence/plane.ts";
import { type LotPlace, lotsOf } from "../src/link/lot-places.ts";
import { AllLotsView } from "../src/views/all-lots-view.ts";
import type { LotOrder } from "../src/route/place.ts";
import { firstLots, lotsFound, marksOf, takenShare } from "../src/views/all-lots.ts";
import { words } from "./stage.ts";

type Last = NonNullable<LotPlace["last_survey"]>;

function lot(name: string, last: Partial<Last> | null, due: string | null = null, place: LotPlace["place"] = [52, 5]): LotPlace {
  const seen = { id: name, free: 0, taken: 0, unknown: 0, drone: null, ended: "2026-05-04T10:00:00Z", ...last };
  return { id: name, name, time_zone: "UTC", stalls: 40, survey_count: 1, last_survey: last === null ? null : seen, due, place };
}

const LOTS = [
  lot("Lot 10", { free: 30, taken: 10, ended: "2026-05-06T10:00:00Z" }),
  lot("Étoile North", { free: 1, taken: 9, ended: "2026-05-05T10:00:00Z" }, null, [52.01, 5]),
  lot("Lot 2", { free: 5, taken: 5 }),
  lot("New", null),
];
const names = (lots: readonly LotPlace[]): string[] => lots.map(({ name }) => name);

const found = (lots: readonly LotPlace[], wanted: string, order: LotOrder): LotPlace[] => firstLots(lotsFound(lots, wanted), order, 100);

describe("all lots", () => {
  it("are found by words of their names, without accents and in any order", () => {
    assert.deepEqual(names(found(LOTS, "north  ETOILE", "name")), ["Étoile North"]);
    assert.deepEqual(names(found(LOTS, "lot", "name")), ["Lot 2", "Lot 10"]);
    assert.deepEqual(found(LOTS, "south", "name"), []);
  });

  it("stand by name, the fullest first, or the longest not seen first", () => {
    assert.deepEqual(names(found(LOTS, "", "name")), ["Étoile North", "Lot 2", "Lot 10", "New"]);
    assert.deepEqual(names(found(LOTS, "", "free")), ["Étoile North", "Lot 2", "Lot 10", "New"]);
    assert.deepEqual(names(found(LOTS, "", "seen")), ["New", "Lot 2", "Étoile North", "Lot 10"]);
    assert.deepEqual(names(LOTS), ["Lot 10", "Étoile North", "Lot 2", "New"], "the list that was given stays as it is");
  });

  it("are the first ones of many in their order", () => {
    const many = Array.from({ length: 1000 }, (_, k) => lot(`Lot ${(k * 389) % 1000}`, null));
    for (const most of [1, 7, 1000, 2000]) {
      const wanted = Array.from({ length: Math.min(most, 1000) }, (_, k) => `Lot ${k}`);
      assert.deepEqual(names(firstLots(many, "name", most)), wanted);
    }
    assert.deepEqual(names(firstLots(many, "seen", 2)), ["Lot 0", "Lot 1"]);
    assert.deepEqual(firstLots([], "name", 5), []);
  });

  it("are found by the drone of their newest survey, and stand by it or the one that is due first", () => {
    const some = [
      lot("North", { drone: "Drone 10" }, "2026-05-08T08:00:00Z"),
      lot("East", { drone: "Drone 2" }),
      lot("South", { drone: null }, "2026-05-07T08:00:00Z"),
      lot("New", null),
    ];
    assert.deepEqual(names(found(some, "drone 2", "name")), ["East"]);
    assert.deepEqual(names(found(some, "", "due")), ["South", "North", "East", "New"]);
    assert.deepEqual(names(found(some, "", "drone")), ["New", "South", "East", "North"]);
  });

  it("are as full as the stalls with a known state say", () => {
    assert.deepEqual(LOTS.map(takenShare), [0.25, 0.9, 0.5, null]);
    assert.equal(takenShare(lot("unclear", { free: 0, taken: 0, unknown: 12 })), null);
  });

  it("are reported as they were found, up to fifty", async () => {
    const many = Array.from({ length: 51 }, (_, k) => lot(`Lot ${k}`, {}));
    const view = Object.assign(new AllLotsView(), { lots: many });
    const gone: unknown[] = [];
    view.addEventListener("archive-go", (event) => gone.push((event as CustomEvent).detail));
    document.body.replaceChildren(view);
    await view.updateComplete;
    const button = (): HTMLButtonElement => [...view.querySelectorAll("button")].find((each) => words(each).startsWith("Report of"))!;
    assert.equal(button().disabled, true);
    assert.ok(words(view).includes("A report has 50 lots at most: search for fewer."));
    const search = view.querySelector<HTMLInputElement>("input[type=search]")!;
    search.value = "lot 1";
    search.dispatchEvent(new Event("input"));
    await view.updateComplete;
    assert.equal(words(button()), "Report of 14 lots");
    button().click();
    assert.deepEqual(gone.splice(0, 1), [{ search: "lot 1", order: "" }], "the address has it: back leads to the same list");
    assert.deepEqual(gone, [{ show: "document", lots: [1, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 21, 31, 41].map((k) => `Lot ${k}`) }]);
    view.place = { search: "lot 50", order: "seen" };
    await view.updateComplete;
    assert.deepEqual([search.value, view.querySelectorAll("tbody tr").length, view.querySelector("select")!.value], ["lot 50", 1, "seen"]);
    view.remove();
  });

  it("lie on the map in their places, also one that nobody flew over", () => {
    const marks = marksOf(LOTS, new LocalPlane({ Latitude: 52, Longitude: 5 }), ({ stalls }) => `${stalls}`);
    assert.deepEqual(marks.map(({ id }) => id), ["Lot 10", "Étoile North", "Lot 2", "New"]);
    const [, north] = marks[1]?.place ?? [0, 0];
    assert.ok(Math.abs(north - 1112.6) < 1, `${north}`);
    assert.deepEqual([marks[0]?.taken, marks[0]?.words()], [0.25, "40"]);
    assert.equal(marks[3]?.taken, null);
  });

  it("are read from one answer with a list for each value", () => {
    const all: LotPlaces = {
      ids: ["a", "b"], names: ["North", "New"], latitudes: [52, 52.5], longitudes: [5, 5.5], time_zones: ["Europe/Amsterdam", "UTC"],
      stalls: [40, 0], survey_counts: [3, 0], due: ["2026-05-08T08:00:00Z", null], surveys: ["s", null], ended: ["2026-05-07T08:00:00Z", null],
      free: [0, null], taken: [39, null], unknown: [1, null], drones: [null, null],
    };
    const last = { id: "s", ended: "2026-05-07T08:00:00Z", free: 0, taken: 39, unknown: 1, drone: null };
    assert.deepEqual(lotsOf(all), [
      { id: "a", name: "North", time_zone: "Europe/Amsterdam", stalls: 40, survey_count: 3, due: "2026-05-08T08:00:00Z", place: [52, 5], last_survey: last },
      { id: "b", name: "New", time_zone: "UTC", stalls: 0, survey_count: 0, due: null, place: [52.5, 5.5], last_survey: null },
    ]);
  });
});
