import "./dom.ts";
import "./no-drawing.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { ActionBar } from "../src/ui/action-bar.ts";
import { GlanceLine } from "../src/ui/glance-line.ts";
import { StallsTab } from "../src/ui/stalls-tab.ts";
import { stateWords } from "../src/words/glance.ts";
import { userError } from "../src/words/user-error.ts";
import { heartbeat, mapUpdate, stall, view } from "./make.ts";
import { flying } from "./rig.ts";
import { Stage } from "./stage.ts";

const { FlightTab } = await import("../src/ui/flight-tab.ts");

/** The specification's heartbeat (18.4.5), each number another. */
const SPECIFIED = {
  State: "Autonomous Move",
  "Ardupilot State": "BRAKE",
  "Relative Altitude": 31,
  Armed: true,
  Latitude: 43.25,
  Longitude: -79.75,
  "Local Position X": 12,
  "Local Position Y": -7,
  "Battery Percentage": 81,
  "Battery Time Left": null,
  "User Error": 0,
  "Health Status": 0,
  "Height Above Ground": 26,
  Voltage: 15.5,
} as const;

/** Name and value of each fact that a person reads. */
async function facts(): Promise<Map<string, string>> {
  const stage = new Stage(new FlightTab(), flying(SPECIFIED).operator);
  await stage.drawn();
  const pairs = [...stage.part.querySelectorAll("dl.pairs > div")];
  return new Map(pairs.map((pair) => [pair.querySelector("dt")?.textContent.trim() ?? "", pair.querySelector("dd")?.textContent.trim() ?? ""]));
}

describe("each value of the specification's heartbeat", () => {
  it("is shown as itself in the flight's table", async () => {
    const shown = await facts();
    assert.equal(shown.get("Autopilot"), "BRAKE");
    assert.equal(shown.get("Place"), "43.25000° N, 79.75000° W");
    assert.equal(shown.get("From where it was armed"), "7 m W, 12 m N");
    assert.equal(shown.get("Height above ground"), "26 m");
    assert.equal(shown.get("Battery voltage"), "15.5 V");
  });

  it("is shown as itself at a glance", async () => {
    const stage = new Stage(new GlanceLine(), flying(SPECIFIED).operator);
    await stage.drawn();
    assert.match(stage.text, /31 m/);
    assert.match(stage.text, /81 %/);
    assert.doesNotMatch(stage.text, /26 m|15\.5/);
    assert.match(stage.text, /Moving/);
  });

  it("has the stalls of the map in their table", async () => {
    const stage = new Stage(new StallsTab(), flying({ ...SPECIFIED, Free: 1, "Occupancy Map": mapUpdate({ Stalls: [stall(7)] }) }).operator);
    await stage.drawn();
    assert.match(stage.text, /7/);
  });

  it("says in the bar whether it is armed", async () => {
    const bar = async (Armed: boolean): Promise<string> => {
      const stage = new Stage(new ActionBar(), flying({ ...SPECIFIED, Armed }).operator);
      await stage.drawn();
      return stage.text;
    };
    assert.match(await bar(true), /Already armed/);
    assert.doesNotMatch(await bar(false), /Already armed/);
  });

  it("asks for attention for a user error and for bad health, and shows the error's words", () => {
    const error = heartbeat({ ...SPECIFIED, "User Error": 1, "User Error Text": "Outside the lot." });
    assert.equal(userError(error), "Outside the lot.");
    assert.equal(userError(heartbeat(SPECIFIED)), null);
    assert.equal(stateWords(view({ heartbeat: error })).tone, "warn");
    assert.equal(stateWords(view({ heartbeat: heartbeat({ ...SPECIFIED, "Health Status": 1 }) })).tone, "warn");
    assert.notEqual(stateWords(view({ heartbeat: heartbeat(SPECIFIED) })).tone, "warn");
  });
});
