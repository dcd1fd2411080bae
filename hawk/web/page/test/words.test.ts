import assert from "node:assert/strict";
import { describe, it } from "node:test";
import type { Heartbeat } from "../src/protocol.ts";
import * as format from "../src/words/format.ts";
import { glanceValues, seenPercent, stateWords } from "../src/words/glance.ts";
import { healthSummary, partName } from "../src/words/health.ts";
import { heightsProblem } from "../src/words/heights.ts";
import { stallDetail } from "../src/words/stall.ts";
import { heartbeat, view, welcome } from "./make.ts";

describe("numbers", () => {
  it("carry units, and a dash stands for what is not known", () => {
    assert.equal(format.height(null, "metres"), "–");
    assert.equal(format.height(-0.04, "metres"), "0.0 m");
    assert.equal(format.height(9.94, "metres"), "9.9 m");
    assert.equal(format.height(9.97, "metres"), "10 m");
    assert.equal(format.distance(4.26, "metres"), "4.3 m");
    assert.equal(format.distance(38.4, "metres"), "38 m");
    assert.equal(format.speed(null, "metres"), "–");
    assert.equal(format.wind(5.23, 1.5 * Math.PI, "metres"), "5.2 m/s from the west");
    assert.equal(format.wind(null, null, "metres"), "–");
    assert.equal(format.speed(-0.04, "metres"), "0.0 m/s");
    assert.equal(format.percent(88.6), "89 %");
    assert.equal(format.area(312, "metres"), "312 m²");
    assert.equal(format.area(12_300, "metres"), "1.23 ha");
    assert.equal(format.area(31_400, "metres"), "3.1 ha");
  });

  it("never round time up that is left", () => {
    assert.equal(format.timeLeft(119), "119 s");
    assert.equal(format.timeLeft(179), "2 min");
    assert.equal(format.timeLeft(-3), "0 s");
  });

  it("give spans in the unit that fits", () => {
    assert.equal(format.duration(89), "89 s");
    assert.equal(format.duration(90), "2 min");
    assert.equal(format.longDuration(312), "5 min 12 s");
    assert.equal(format.age(0.24), "0.2 s");
    assert.equal(format.age(6.9), "6 s");
  });

  it("give places", () => {
    assert.equal(format.place(48.137, -11.5), "48.13700° N, 11.50000° W");
    assert.equal(format.place(null, 1), "–");
    assert.equal(format.offset(-59, 60, "metres"), "60 m E, 59 m S");
    assert.equal(format.direction(-1, -1), "south-west");
    assert.equal(format.direction(1, 0.05), "north");
    assert.equal(format.clock("nonsense"), "–");
  });
});

describe("the state in words", () => {
  it("says that it looks for the drone before it was heard", () => {
    const words = stateWords(view({ heartbeat: null, silence: null, link: "connecting" }));
    assert.deepEqual([words.tone, words.title], ["warn", "Not connected"]);
  });

  it("says what it did when the link was lost, never what it does", () => {
    const words = stateWords(view({ heartbeat: heartbeat({ State: "Autonomous Explore" }), silence: 6.2 }));
    assert.deepEqual([words.tone, words.title, words.detail], ["warn", "No link", "was exploring 6 s ago"]);
  });

  it("counts the stalls of a lot whose size is not known, and says no share: it falls when more lot comes in sight", () => {
    const exploring = heartbeat({ State: "Autonomous Explore", Explored: 0.92, Free: 30, Taken: 13, Unknown: 1 });
    assert.equal(stateWords(view({ heartbeat: exploring })).detail, "44 stalls so far");
    const words = stateWords(view({ heartbeat: { ...exploring, "Survey Time Left": 130 } }));
    assert.deepEqual([words.detail, words.short], ["44 stalls so far, 2 min for what is in sight", "44 so far, 2 min in sight"]);
  });

  it("says how much was seen of an outline, and the time to the end", () => {
    const exploring = heartbeat({ State: "Autonomous Explore", Explored: 0.47, "Outline Area": 5000 });
    assert.equal(stateWords(view({ heartbeat: exploring })).detail, "47 % of the outline seen");
    const words = stateWords(view({ heartbeat: { ...exploring, "Survey Time Left": 200 } }));
    assert.deepEqual([words.detail, words.short], ["47 % of the outline seen, about 3 min to go", "47 % seen, 3 min to go"]);
  });

  it("asks for attention for failed checks, trouble, the pilot and a silent autopilot", () => {
    const check = { Name: "GPS", Passed: false, Value: "", Consequence: "", Remedy: "", "Remedy Command": null };
    const failed = stateWords(view({ heartbeat: heartbeat({ State: "Idle", Armed: false, Checks: [check] }) }));
    assert.deepEqual([failed.tone, failed.detail], ["warn", "1 check failed. Fix it to arm."]);
    assert.equal(stateWords(view({ heartbeat: heartbeat({ "Health Status": 1 }) })).tone, "warn");
    assert.equal(stateWords(view({ heartbeat: heartbeat({ "User Error": 2 }) })).tone, "warn");
    assert.equal(stateWords(view({ heartbeat: heartbeat({ State: "Manual" }) })).tone, "warn");
    assert.equal(stateWords(view({ heartbeat: heartbeat({ Connected: false }) })).title, "Autopilot silent");
    assert.equal(stateWords(view()).tone, "fine");
  });

  it("does not say that it is armed before it is", () => {
    assert.equal(stateWords(view({ heartbeat: heartbeat({ State: "Arm", Armed: false }) })).title, "Arming");
    assert.equal(stateWords(view({ heartbeat: heartbeat({ State: "Arm", Armed: true }) })).title, "Armed");
  });

  it("does not call a lot unseen in which stalls were found", () => {
    assert.equal(seenPercent(heartbeat({ State: "Hover", Explored: 0, Free: 3 })), null);
    assert.equal(seenPercent(heartbeat({ State: "Autonomous Explore", Explored: 0 })), 0);
    assert.equal(seenPercent(heartbeat({ State: "Hover", Explored: 0.467 })), 47);
  });

  it("does not claim that the motors are off before the drone says so", () => {
    const words = (state: "sending" | "not confirmed") => stateWords(view({ heartbeat: heartbeat({ "Kill State": state }) }));
    assert.equal(words("sending").title, "Cutting motors");
    assert.equal(words("not confirmed").title, "Cut not confirmed");
    assert.equal(stateWords(view({ heartbeat: heartbeat({ State: "Idle", Armed: false, Killed: true }) })).title, "Motors cut");
  });

  it("shows a fall in red, with place and time, and calls it no cut", () => {
    const motors = { Name: "Motors", Passed: false, Value: "off in the air at 17.7 m, near 43.265000, -79.920000, 2026-01-02 10:00:00 UTC", "Remedy Command": "Clear Kill" };
    const fell = heartbeat({ State: "Idle", Armed: false, Killed: true, Fallen: true, Checks: [{ Consequence: "", Remedy: "", ...motors } as Heartbeat["Checks"][number]] });
    const words = stateWords(view({ heartbeat: fell, landedAt: "2026-01-02T10:00:00" }));
    assert.deepEqual([words.tone, words.title], ["alarm", "Motors off in the air"]);
    assert.match(words.detail, /17\.7 m, near 43\.265000, -79\.920000, 2026-01-02 10:00:00 UTC\. Look at the drone/);
    assert.doesNotMatch(words.detail, /cut/i);
  });

  it("says since when it is down", () => {
    const words = stateWords(view({ heartbeat: heartbeat({ State: "Idle", Armed: false }), landedAt: "2026-01-02T10:00:00" }));
    assert.deepEqual([words.tone, words.title, words.detail], ["idle", "Landed", "Motors off since 10:00:00"]);
  });
});

describe("values at a glance", () => {
  const named = (changes: Parameters<typeof view>[0]) => Object.fromEntries(glanceValues(view(changes)).map((each) => [each.name, each]));

  it("are fresh with a good link", () => {
    const values = named({ heartbeat: heartbeat({ Free: 114, Taken: 40, Unknown: 5 }) });
    assert.deepEqual([values.free?.value, values.free?.label], ["114", "free stalls"]);
    assert.deepEqual([values.battery?.value, values.battery?.label, values.battery?.age], ["13 min", "until return, 89 %", ""]);
    assert.deepEqual([values.height?.value, values.height?.age], ["35 m", ""]);
    assert.deepEqual([values.link?.value, values.link?.label], ["0.2 s", "link, good"]);
  });

  it("turn stale within a second, the battery after three", () => {
    const values = named({ silence: 1.1 });
    assert.equal(values.height?.age, "1 s old");
    assert.equal(values.battery?.age, "");
    assert.equal(values.link?.trouble, true);
    assert.equal(named({ silence: 2.6 }).battery?.age, "3 s old");
  });

  it("turn stale when the drone's own values are old", () => {
    assert.equal(named({ heartbeat: heartbeat({ "Pose Age": 4 }) }).height?.age, "4 s old");
  });

  it("are dashes when they are not known, and never old then", () => {
    const unknown = heartbeat({ "Relative Altitude": null, "Battery Percentage": null, "Battery Time Left": null });
    const values = named({ heartbeat: unknown, silence: 60 });
    assert.deepEqual([values.height?.value, values.height?.age], ["–", ""]);
    assert.deepEqual([values.battery?.value, values.battery?.age], ["–", ""]);
    assert.deepEqual(glanceValues(view({ heartbeat: null, silence: null })).map((each) => each.value), ["–", "–", "–", "–"]);
  });

  it("show the battery in per cent when the time is not known", () => {
    const value = named({ heartbeat: heartbeat({ "Battery Time Left": null }) }).battery;
    assert.deepEqual([value?.value, value?.label], ["89 %", "battery"]);
  });

  it("say until when stalls were counted", () => {
    const values = named({ heartbeat: heartbeat({ Free: 1 }), silence: 6 });
    assert.equal(values.free?.label, "free, at 11:59:54");
    assert.deepEqual([values.link?.value, values.link?.label], ["6 s", "link lost"]);
  });
});

describe("other words", () => {
  it("name what is wrong with heights", () => {
    assert.equal(heightsProblem(15, 35, 60, 120, "metres"), "");
    assert.match(heightsProblem(Number.NaN, 35, 60, 120, "metres"), /^Never below/);
    assert.match(heightsProblem(15, 0, 60, 120, "metres"), /^Flies at: give a number/);
    assert.match(heightsProblem(40, 35, 60, 120, "metres"), /below the lowest/);
    assert.match(heightsProblem(15, 65, 60, 120, "metres"), /above the highest/);
    assert.match(heightsProblem(15, 35, 130, 120, "metres"), /fence ends at 120 m/);
    assert.equal(heightsProblem(15, 35, 130, null, "metres"), "");
  });

  it("say how sure a stall is", () => {
    const stall = { id: 1, north: 0, east: 0, angle: 0, width: 2, length: 5, state: "unknown" as const, taken: 0.38, seen: 4, lastSeen: 1, label: "1" };
    const at = new Date(2026, 0, 1, 14, 33, 25).getTime();
    assert.equal(stallDetail(stall, at), "Seen in 4 pictures only, last at 14:33:25.");
    assert.equal(stallDetail({ ...stall, state: "free", seen: 1 }, null), "Seen in 1 picture only.");
    assert.equal(stallDetail({ ...stall, state: "free", seen: 525 }, at), "Last seen at 14:33:25.");
    assert.equal(stallDetail({ ...stall, state: "free", seen: 525 }, null), "");
    assert.equal(stallDetail({ ...stall, state: "suggested", seen: 3 }, at), "No marks here. A car stood here in 3 passes.");
    assert.match(stallDetail({ ...stall, taken: 0.5, seen: 0 }, at), /^Not seen itself/);
  });

  it("name the parts", () => {
    const items = [
      { Name: "vision", Healthy: true, Reason: "" },
      { Name: "camera", Healthy: false, Reason: "no picture for 3 s" },
    ];
    assert.equal(healthSummary(items), "1 of 2 in trouble");
    assert.equal(healthSummary(items.slice(0, 1)), "all 1 working");
    assert.equal(partName(items[0]!), "Finding stalls");
    assert.equal(welcome().Simulation, false);
  });
});
