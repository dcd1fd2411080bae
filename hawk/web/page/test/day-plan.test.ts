import "./dom.ts";
import assert from "node:assert/strict";
import { afterEach, beforeEach, describe, it } from "node:test";
import { LotsList } from "../src/ui/lots.ts";
import { answer as answerOf, list, refusal } from "./api.ts";
import { possible } from "./make.ts";
import { flying } from "./rig.ts";
import { inFrench } from "./french.ts";
import { Stage, words } from "./stage.ts";

const LOTS = ["North", "South", "West"].map((name, number) => ({ id: "abc"[number], name, time_zone: "Europe/Amsterdam", stalls: 9, survey_count: 1, last_survey: null }));
const RAIN = "0.2 mm of rain";
const NEEDED = "It needs 5 batteries; left: 2.";
const ROUND = { lots: [{ id: "a", name: "North" }, { id: "c", name: "West" }], due: "2026-05-04T10:00:00Z", start: "2026-05-04T12:00:00Z", end: "2026-05-04T12:24:00Z", seconds: 1440, batteries: 2, distance_m: 512, problem: "" };
const HOURS = ["10:00", "11:00"].map((time) => ({ at: `2026-05-04T${time}:00Z`, reasons: [RAIN] }));
const PLAN = {
  problems: ["schedule: no lot has the name or id Nort: write one of North."],
  rounds: [
    { ...ROUND, hours: [...HOURS, { at: ROUND.start, reasons: [] }] },
    { ...ROUND, lots: [{ id: "b", name: "South" }], start: null, end: null, batteries: 5, problem: NEEDED, hours: [] },
  ],
  sentences: [
    { text: RAIN, code: "rain-mm-of-rain", values: { rain: 0.2 } },
    { text: NEEDED, code: "it-needs-batteries-batteries-left-left", values: { batteries: 5, left: 2 } },
  ],
};

describe("the day's plan", () => {
  const before = globalThis.fetch;
  let sent: [string, unknown][];
  let answer: () => Response;

  beforeEach(() => {
    sent = [];
    answer = () => Response.json(PLAN);
    globalThis.fetch = (address, options) => {
      if (options?.method !== "POST") return Promise.resolve(answerOf(address as string, { lots: list(...LOTS), surveys: list(), changes: list() }));
      sent.push([address as string, JSON.parse(options.body as string)]);
      return Promise.resolve(answer());
    };
  });

  afterEach(() => {
    globalThis.fetch = before;
  });

  const shown = async (): Promise<{ rig: ReturnType<typeof flying>; stage: Stage<LotsList> }> => {
    const rig = flying({ State: "Idle", Armed: false, Utc: "2026-05-04T09:41:00+00:00", Options: possible("Survey Again") });
    const stage = new Stage(new LotsList(), rig.operator);
    await stage.drawn();
    return { rig, stage };
  };
  const plan = async (stage: Stage<LotsList>, values: Record<string, string> = {}): Promise<void> => {
    for (const [name, value] of Object.entries(values)) (stage.find(`.day-plan input[name="${name}"]`) as HTMLInputElement).value = value;
    stage.find(".day-plan form").dispatchEvent(new Event("submit", { cancelable: true }));
    await stage.drawn();
    await stage.drawn();
  };
  const rounds = (stage: Stage<LotsList>): string[] => [...stage.part.querySelectorAll(".day-plan li")].map((row) => words(row));

  it("asks with batteries and the weather of the fields, from this hour of the drone's clock on", async () => {
    const { stage } = await shown();
    await plan(stage, { batteries: "4", wind: "3", gust: "6.5", cloud: "40" });
    const hour = { begin: "2026-05-04T09:00:00.000Z", hours: 30, wind: 3, gust: 6.5, cloud: 40, rain: 0 };
    assert.deepEqual(sent, [["api/v1/day-plan", { batteries: 4, forecast: { made: "2026-05-04T09:41:00+00:00", hours: [hour] } }]]);
  });

  it("asks without a forecast while wind or gusts are missing", async () => {
    const { stage } = await shown();
    await plan(stage, { wind: "3" });
    assert.deepEqual(sent, [["api/v1/day-plan", { batteries: 1, forecast: null }]]);
  });

  it("says start, lots, need, and why a time or a round does not fit, on the lot's clock", async () => {
    const { stage } = await shown();
    await plan(stage);
    assert.match(stage.text, /no lot has the name or id Nort: write one of North/);
    const [first, second] = rounds(stage);
    assert.match(first ?? "", /14:00 to 14:24: North, West.*due 12:00 · Amsterdam time · 24 min, 512 m, batteries: 2.*Not at 12:00, 13:00: 0\.2 mm of rain/);
    assert.match(second ?? "", /No start: South.*It needs 5 batteries; left: 2\./);
    assert.equal(stage.part.querySelectorAll(".day-plan li button").length, 1);
  });

  it("puts a round into the choice of Survey again, and commands nothing", async () => {
    const { rig, stage } = await shown();
    await plan(stage);
    const commands = rig.sent().length;
    await stage.press("Choose for one flight: North, West");
    assert.deepEqual([...stage.part.querySelectorAll<HTMLInputElement>("li > input")].map((input) => input.checked), [true, false, true]);
    assert.match(stage.text, /Survey 2 lots again in one flight/);
    assert.equal(rig.sent().length, commands);
  });

  it("says what the drone refuses, and that nothing is due", async () => {
    const { stage } = await shown();
    answer = () => refusal(422, "must not be less than wind", { field: "forecast.hours[0].gust" });
    await plan(stage, { wind: "9", gust: "6" });
    assert.match(stage.text, /forecast\.hours\[0\]\.gust: must not be less than wind/);
    answer = () => Response.json({ problems: [], rounds: [], sentences: [] });
    await plan(stage, { gust: "10" });
    assert.match(stage.text, /No survey is due in the next 24 hours\./);
    assert.doesNotMatch(stage.text, /must not be less/);
  });

  it("speaks French, also what the drone says", () =>
    inFrench(async () => {
      const { stage } = await shown();
      await plan(stage);
      assert.match(stage.text, /Pas de départ : South.*Il faut 5 batteries ; il en reste 2\./);
      assert.match(stage.text, /Pas à 12:00, 13:00 :\s*0,2\s*mm de pluie/);
    }));

  it("is not there where no survey can be asked for", async () => {
    const stage = new Stage(new LotsList(), flying({ State: "Hover" }).operator);
    await stage.drawn();
    assert.equal(stage.has(".day-plan"), false);
  });
});
