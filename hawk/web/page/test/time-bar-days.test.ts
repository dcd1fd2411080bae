import "./dom.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import type { SurveyUse } from "../src/api.ts";
import { dayOf, daysOf, fitting, hoursOf, midnightsOf } from "../src/views/time-bar-days.ts";

describe("the days of the bar", () => {
  const at = (time: string): SurveyUse => ({ id: time, at: time }) as SurveyUse;
  const MONDAY = Date.UTC(2026, 4, 4);

  it("are a day, a calendar week or a month, and three days where it is narrow", () => {
    const days = (span: "day" | "week" | "month", isNarrow = false): string[] => midnightsOf(Date.UTC(2026, 4, 6, 12), span, isNarrow).map(dayOf);
    assert.deepEqual(days("day"), ["2026-05-06"]);
    assert.deepEqual([days("week")[0], days("week").length, days("week").at(-1)], ["2026-05-04", 7, "2026-05-10"]);
    assert.deepEqual([days("month")[0], days("month").length], ["2026-05-01", 31]);
    assert.equal(days("week", true).length, 3);
    assert.ok(days("week", true).includes("2026-05-06"));
  });

  it("join ticks nearer than 12 pixels, with their number and their mean share", () => {
    const surveys = [at("2026-05-04T10:00:00Z"), at("2026-05-04T10:30:00Z"), at("2026-05-04T12:00:00Z")];
    const shares = new Map([[surveys[0]?.id, 0.2], [surveys[1]?.id, 0.6]]);
    const [day] = daysOf(surveys, [MONDAY], "UTC", hoursOf([]), 240, ({ id }) => shares.get(id) ?? null);
    assert.deepEqual(day?.ticks.map(({ clock, ids, share: part }) => [clock, ids.length, part]), [["10:00", 2, 0.4], ["12:00", 1, null]]);
    const [wide] = daysOf(surveys, [MONDAY], "UTC", hoursOf([]), 1200, () => null);
    assert.equal(wide?.ticks.length, 3);
  });

  it("leave room for the number of a tick, however many it stands for", () => {
    const every3 = Array.from({ length: 200 }, (_, k) => at(new Date(MONDAY + 7 * 3_600_000 + k * 180_000).toISOString()));
    const [day] = daysOf(every3, [MONDAY], "UTC", hoursOf([]), 240, () => null);
    const ticks = day?.ticks ?? [];
    assert.ok(ticks.length > 5);
    ticks.slice(1).forEach(({ left }, k) => assert.ok(left - ticks[k]!.left >= 7 * String(ticks[k]!.ids.length).length + 4, `${k}`));
  });

  it("have the hours of all that is shown", () => {
    assert.deepEqual(hoursOf([]), [7, 19]);
    assert.deepEqual(hoursOf([MONDAY + 5.5 * 3_600_000, MONDAY + 22.2 * 3_600_000]), [5, 23]);
  });

  it("say beside each other what is chosen, and leave out other words without room", () => {
    const caption = (left: number, text: string, tone: "on" | "") => ({ left, text, tone });
    const found = fitting([caption(395, "after 10:02", "on"), caption(380, "before 08:02", "on"), caption(390, "15:02 deleted", "")], 400);
    assert.deepEqual(found.map(({ text }) => text), ["after 10:02", "before 08:02"]);
    assert.ok(found[1]!.left + 90 < found[0]!.left, "the earlier one is left of it");
  });
});
