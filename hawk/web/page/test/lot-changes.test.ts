import "./no-drawing.ts";
import assert from "node:assert/strict";
import { afterEach, beforeEach, describe, it } from "node:test";
import { shownChanges } from "../src/map/fence-shown.ts";
import { LotsList } from "../src/ui/lots.ts";
import { LocalPlane } from "../src/fence/plane.ts";
import type { Operator } from "../src/state/operator.ts";
import { answer, list } from "./api.ts";
import { welcome } from "./make.ts";
import { flying } from "./rig.ts";
import { Stage, words } from "./stage.ts";

const CORNERS = [[52, 5], [52, 5.0001], [52.0001, 5.0001], [52.0001, 5]];
const LISTED = {
  lots: list({ id: "a", name: "North", time_zone: "UTC", stalls: 60, survey_count: 2, last_survey: { id: "s", ended: "2026-05-05T12:00:00Z" } }),
  surveys: list(),
  changes: list(),
};
const CHANGES = {
  lot: "a",
  surveys: [
    {
      survey: "s",
      ended: "2026-05-05T12:00:00Z",
      begin: [{ id: 7, corners: CORNERS }, { id: 8, corners: CORNERS }],
      end: [{ id: "x", label: "B 1", is_confirmed: true, corners: CORNERS }],
    },
  ],
  drones: [] as unknown[],
  same: [] as unknown[],
  doubtful: [{ survey: "d", ended: "2026-05-06T12:00:00Z", why: "two places fit alike", places: 2 }],
};
const PLACES = { known: [[0, 0, 0, 2.5, 5]], places: [{ stalls: [[0, 0, 0, 2.5, 5]] }, { stalls: [[0, 2.5, 0, 2.5, 5]] }] };

function viewing(): Operator {
  const rig = flying({ State: "Idle", Armed: false });
  rig.server.last.say(welcome({ Role: "viewer", Login: true }));
  return rig.operator;
}

describe("what surveys propose for a lot", () => {
  const before = globalThis.fetch;
  let sent: [string, unknown][];
  let changes: unknown;

  beforeEach(() => {
    sent = [];
    changes = CHANGES;
    globalThis.fetch = (address, options) => {
      const asked = address as string;
      if (options?.method === "POST") {
        sent.push([asked, JSON.parse(options.body as string)]);
        changes = { ...CHANGES, surveys: [], doubtful: [] };
        return Promise.resolve(Response.json({ seq: 1 }));
      }
      return Promise.resolve(answer(asked, { ...LISTED, "lots/a/proposals": changes, "surveys/d/places": PLACES }));
    };
  });

  afterEach(() => {
    globalThis.fetch = before;
  });

  const shown = async (): Promise<Stage<LotsList>> => {
    const stage = new Stage(new LotsList(), flying({ State: "Idle", Armed: false }).operator);
    for (let round = 0; round < 4; round += 1) await stage.drawn();
    return stage;
  };

  it("is said in numbers, and shown on the map with a legend in words", async () => {
    const stage = await shown();
    assert.match(stage.text, /2 stalls begin, 1 stall endsSurvey of 2026-05-05/);
    await stage.press("Show on the map");
    assert.equal(stage.part.model.lotChanges?.begin.length, 2);
    assert.deepEqual(stage.part.model.lotChanges.end[0]?.[0], { Latitude: 52, Longitude: 5 });
    assert.match(stage.text, /begins\s*ends/);
    await stage.press("Show on the map");
    assert.equal(stage.part.model.lotChanges, null);
  });

  it("of a drone is said by its name, shown on the map, and taken over or dropped as a whole", async () => {
    const stall = { id: "n", label: "C 1", corners: CORNERS };
    const ofDrone = { drone: "Drone 2", base: "b", begin: [stall, stall], end: [stall], change: [stall], areas: ["Kerb"] };
    for (const [button, address] of [["Take over", "take-over"], ["Drop", "drop"]] as const) {
      sent = [];
      changes = { ...CHANGES, surveys: [], doubtful: [], drones: [ofDrone] };
      const stage = await shown();
      assert.match(stage.text, /2 stalls added, 1 stall removed, 1 stall changed, zones and sections: Kerb/);
      assert.match(stage.text, /By the operator of Drone 2, while the plan was changed here/);
      await stage.press("Show on the map");
      assert.deepEqual([stage.part.model.lotChanges?.begin.length, stage.part.model.lotChanges?.end.length], [3, 1]);
      await stage.press(button);
      assert.deepEqual(sent, [[`api/v1/lots/a/${address}`, { drone: "Drone 2", base: "b" }]]);
    }
  });

  it("names a lot on the same ground, which is merged into this one", async () => {
    changes = { ...CHANGES, surveys: [], doubtful: [], same: [{ lot: "b", name: "Lot 1", share: 0.81 }] };
    const stage = await shown();
    assert.match(stage.text, /Lot 1 is on the ground of this lot81\s?% of the smaller one/);
    await stage.press("Merge into this lot");
    assert.deepEqual(sent, [["api/v1/lots/a/merge", { with: "b" }]]);
  });

  it("lies on the map where it lies on Earth", async () => {
    const stage = await shown();
    await stage.press("Show on the map");
    const plane = new LocalPlane({ Latitude: 52, Longitude: 5 });
    const [stall] = shownChanges(stage.part.model.lotChanges, plane)?.begin ?? [];
    assert.deepEqual(stall?.map(({ North, East }) => [Math.round(North) + 0, Math.round(East) + 0]), [[0, 0], [0, 7], [11, 7], [11, 0]]);
    const [atDesk] = shownChanges(stage.part.model.lotChanges, null)?.begin ?? [];
    assert.deepEqual(atDesk?.[0], { North: 0, East: 0 });
    assert.equal(shownChanges(null, null), null);
  });

  it("is taken over without the confirmed stalls, unless they are ticked", async () => {
    const stage = await shown();
    await stage.press("Take over");
    assert.deepEqual(sent, [["api/v1/lots/a/take-over", { survey: "s", begin: "all", end: "all" }]]);
    assert.doesNotMatch(stage.text, /begin/);
  });

  it("ends confirmed stalls by name where they are ticked", async () => {
    const stage = await shown();
    assert.match(stage.text, /End the confirmed one too/);
    stage.input("input[type=checkbox]").click();
    await stage.press("Take over");
    assert.deepEqual(sent, [["api/v1/lots/a/take-over", { survey: "s", begin: "all", end: ["x"] }]]);
  });

  it("is dropped, and leaves the map", async () => {
    const stage = await shown();
    await stage.press("Show on the map");
    await stage.press("Drop");
    assert.deepEqual(sent, [["api/v1/lots/a/drop", { survey: "s", begin: "all", end: "all" }]]);
    await stage.drawn();
    assert.equal(stage.part.model.lotChanges, null);
  });

  it("asks where a survey was, with a picture of each place", async () => {
    const stage = await shown();
    assert.match(words(stage.find("hawk-lot-doubt")), /Where was this survey\?Survey of 2026-05-06: two places fit alike/);
    assert.deepEqual([...stage.part.querySelectorAll("canvas")].map((each) => each.getAttribute("aria-label")), ["Place 1", "Place 2"]);
    await stage.press("Here: place 2");
    assert.deepEqual(sent, [["api/v1/surveys/d/place", { place: 1 }]]);
  });

  it("is only looked at by a viewer", async () => {
    const stage = new Stage(new LotsList(), viewing());
    for (let round = 0; round < 4; round += 1) await stage.drawn();
    assert.deepEqual(stage.enabled(), ["Show on the map"]);
  });
});
