import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { DaemonClock } from "../src/state/daemon-clock.ts";
import { Picture } from "../src/state/picture.ts";
import { glanceValues, stateWords } from "../src/words/glance.ts";
import { OLD_S, type View } from "../src/words/view.ts";
import { heartbeat, view } from "./make.ts";
import { flying } from "./rig.ts";

describe("the age of the picture", () => {
  it("is the drone's, or this page's where that is more", () => {
    const clock = new DaemonClock();
    const picture = new Picture(clock);
    assert.equal(picture.age(10), null);
    picture.shown(63, 10);
    assert.equal(picture.age(12), 2);
    clock.add(12, 100);
    assert.equal(picture.age(12), 37);
    assert.equal(picture.age(27), 52);
  });

  it("is part of what the words depend on", () => {
    const { operator, timers, hear } = flying({ Time: 100 });
    operator.picture.shown(99.9, operator.seconds());
    assert.equal(stateWords(operator.view()).tone, "fine");
    for (let second = 1; second <= 3; second += 1) {
      timers.advance(1000);
      hear({ Time: 100 + second });
    }
    assert.equal(stateWords(operator.view()).tone, "warn");
    assert.match(stateWords(operator.view()).detail, /Picture 3 s old\./);
  });
});

describe("nothing older than 2 s is green", () => {
  const link = (changes: Partial<View>): { label: string; trouble: boolean } => {
    const found = glanceValues(view(changes)).find((each) => each.name === "link");
    assert.ok(found);
    return found;
  };

  it("neither with an old picture", () => {
    for (const State of ["Hover", "Autonomous Explore", "Autonomous Move", "Return To Launch", "Idle"]) {
      const drone = heartbeat({ State, Explored: 0.5 });
      assert.notEqual(stateWords(view({ heartbeat: drone, pictureAge: OLD_S + 0.1 })).tone, "fine", State);
      assert.notEqual(stateWords(view({ heartbeat: drone, pictureAge: OLD_S - 0.1 })).tone, "warn", State);
    }
  });

  it("nor with an old position, an old word of the autopilot or of the drone", () => {
    assert.equal(stateWords(view()).tone, "fine");
    assert.equal(stateWords(view({ heartbeat: heartbeat({ "Pose Age": 2.1 }) })).tone, "warn");
    assert.equal(stateWords(view({ heartbeat: heartbeat({ "Link Age": 2.1 }) })).tone, "warn");
    assert.equal(stateWords(view({ silence: 2.1 })).tone, "warn");
  });

  it("and the link is not good then", () => {
    assert.deepEqual([link({}).label, link({}).trouble], ["link, good", false]);
    const late = link({ heartbeat: heartbeat({ "Link Age": 2.1 }) });
    assert.deepEqual([late.label, late.trouble], ["autopilot, slow", true]);
  });

  it("nor the battery", () => {
    const battery = glanceValues(view({ heartbeat: heartbeat({ "Battery Age": 2.1 }) })).find((each) => each.name === "battery");
    assert.notEqual(battery?.age, "");
  });
});
