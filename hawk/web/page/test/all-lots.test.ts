import "./no-drawing.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import type { ListedLot, Survey } from "../src/api.ts";
import { LocalPlane } from "../src/fence/plane.ts";
import { AllLotsView } from "../src/views/all-lots-view.ts";
import { lotsFound, marksOf, takenShare } from "../src/views/all-lots.ts";
import { words } from "./stage.ts";

function lot(name: string, last: Partial<Survey> | null, due: string | null = null): ListedLot {
  const seen = { free: 0, taken: 0, unknown: 0, drone: null, ended: "2026-05-04T10:00:00Z", datum: [52, 5], ...last } as Survey;
  return { id: name, name, time_zone: "UTC", stalls: 40, sections: 0, survey_count: 1, last_survey: last === null ? null : seen, due };
}

const LOTS = [
  lot("Lot 10", { free: 30, taken: 10, ended: "2026-05-06T10:00:00Z" }),
  lot("Étoile North", { free: 1, taken: 9, ended: "2026-05-05T10:00:00Z", datum: [52.01, 5] }),
  lot("Lot 2", { free: 5, taken: 5 }),
  lot("New", null),
];
const names = (lots: readonly ListedLot[]): string[] => lots.map(({ name }) => name);

describe("all lots", () => {
  it("are found by words of their names, without accents and in any order", () => {
    assert.deepEqual(names(lotsFound(LOTS, "north  ETOILE", "name")), ["Étoile North"]);
    assert.deepEqual(names(lotsFound(LOTS, "lot", "name")), ["Lot 2", "Lot 10"]);
    assert.deepEqual(lotsFound(LOTS, "south", "name"), []);
  });

  it("stand by name, the fullest first, or the longest not seen first", () => {
    assert.deepEqual(names(lotsFound(LOTS, "", "name")), ["Étoile North", "Lot 2", "Lot 10", "New"]);
    assert.deepEqual(names(lotsFound(LOTS, "", "free")), ["Étoile North", "Lot 2", "Lot 10", "New"]);
    assert.deepEqual(names(lotsFound(LOTS, "", "seen")), ["New", "Lot 2", "Étoile North", "Lot 10"]);
    assert.deepEqual(names(LOTS), ["Lot 10", "Étoile North", "Lot 2", "New"], "the list that was given stays as it is");
  });

  it("are found by the drone of their newest survey, and stand by it or the one that is due first", () => {
    const some = [
      lot("North", { drone: "Drone 10" }, "2026-05-08T08:00:00Z"),
      lot("East", { drone: "Drone 2" }),
      lot("South", { drone: null }, "2026-05-07T08:00:00Z"),
      lot("New", null),
    ];
    assert.deepEqual(names(lotsFound(some, "drone 2", "name")), ["East"]);
    assert.deepEqual(names(lotsFound(some, "", "due")), ["South", "North", "East", "New"]);
    assert.deepEqual(names(lotsFound(some, "", "drone")), ["New", "South", "East", "North"]);
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
    assert.deepEqual([button().disabled, button().title], [true, "A report has 50 lots at most: search for fewer."]);
    const search = view.querySelector<HTMLInputElement>("input[type=search]")!;
    search.value = "lot 1";
    search.dispatchEvent(new Event("input"));
    await view.updateComplete;
    assert.equal(words(button()), "Report of 14 lots");
    button().click();
    assert.deepEqual(gone, [{ show: "document", lots: [1, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 21, 31, 41].map((k) => `Lot ${k}`) }]);
    view.remove();
  });

  it("lie on the map where their newest surveys do; one that nobody flew over lies nowhere", () => {
    const marks = marksOf(LOTS, new LocalPlane({ Latitude: 52, Longitude: 5 }), ({ stalls }) => `${stalls}`);
    assert.deepEqual(marks.map(({ id }) => id), ["Lot 10", "Étoile North", "Lot 2"]);
    const [, north] = marks[1]?.place ?? [0, 0];
    assert.ok(Math.abs(north - 1112.6) < 1, `${north}`);
    assert.deepEqual([marks[0]?.taken, marks[0]?.words], [0.25, "40"]);
  });
});
