import assert from "node:assert/strict";
import { describe, it } from "node:test";
import type { Heartbeat } from "../src/protocol.ts";
import { CELL } from "../src/state/tile-data.ts";
import { type Action, control, guidedActions, safetyActions } from "../src/words/actions.ts";
import { banner } from "../src/words/banner.ts";
import { consequence, contains, crosses, planMove } from "../src/words/move.ts";
import type { View } from "../src/words/view.ts";
import { heartbeat, impossible, possible, view, welcome } from "./make.ts";

function action(name: string, changes: Partial<View>): Action {
  const all = guidedActions(view(changes), false);
  const found = all.find((each) => each.name === name);
  assert.ok(found, `no ${name} among ${all.map((each) => each.name).join(", ")}`);
  return found;
}

const ground = { State: "Idle", Armed: false, Landed: "ON_GROUND", "Relative Altitude": 0 };

describe("actions", () => {
  it("say why they are not possible, in the drone's words without its full stop", () => {
    const off = { heartbeat: heartbeat({ ...ground, Options: [impossible("Takeoff", "Arm first.")] }) };
    assert.deepEqual([action("takeoff", off).kind, action("takeoff", off).note], ["impossible", "Arm first"]);
  });

  it("are not possible when the drone does not offer them", () => {
    assert.equal(action("explore", { heartbeat: heartbeat() }).kind, "impossible");
  });

  it("are all impossible without a link, whatever was possible before", () => {
    const options = possible("Arm", "Takeoff", "Autonomous Explore", "Autonomous Move", "Return To Launch", "Land", "Hold");
    for (const lost of [{ link: "waiting" as const }, { silence: 3 }]) {
      const changes = { heartbeat: heartbeat({ Options: options }), ...lost };
      for (const each of guidedActions(view(changes), false)) assert.equal(each.kind, "impossible", each.name);
      assert.equal(safetyActions(view(changes)).land.kind, "impossible");
    }
    assert.equal(action("home", { heartbeat: heartbeat({ Options: options }), silence: 3 }).note, "No link: does it itself");
  });

  it("show failed checks on Arm", () => {
    const check = { Name: "GPS", Passed: false, Value: "", Consequence: "", Remedy: "", "Remedy Command": null };
    const arm = action("arm", { heartbeat: heartbeat({ ...ground, Checks: [check, check], Options: [impossible("Arm", "GPS.")] }) });
    assert.deepEqual([arm.kind, arm.note], ["failed", "2 checks failed"]);
  });

  it("offer Disarm on the ground and Resume to the one whom a pilot relieved", () => {
    assert.equal(action("disarm", { heartbeat: heartbeat({ State: "Arm", Options: possible("Disarm") }) }).kind, "possible");
    assert.equal(action("resume", { heartbeat: heartbeat({ State: "Manual", Options: possible("Resume") }) }).kind, "possible");
  });

  it("run with their progress", () => {
    const exploring = heartbeat({ State: "Autonomous Explore", Explored: 0.473 });
    const known = action("explore", { heartbeat: { ...exploring, "Outline Area": 5000 } });
    assert.deepEqual([known.kind, known.note, known.progress], ["running", "Running, 47 %", 0.473]);
    const unknown = action("explore", { heartbeat: exploring });
    assert.deepEqual([unknown.kind, unknown.note, unknown.progress], ["running", "Running", null], "the share of what was found so far is no progress");
    const climbing = action("takeoff", { heartbeat: heartbeat({ State: "Takeoff", "Relative Altitude": 7 }) });
    assert.deepEqual([climbing.kind, climbing.progress], ["running", 0.2]);
  });

  it("show how long a round is, and the batteries that it takes from two on", () => {
    const round = heartbeat({ "Again Distance": 1240, "Survey Time Left": 380, Options: possible("Autonomous Explore") });
    assert.equal(action("explore", { heartbeat: round }).note, "Again, 1240 m, 6 min");
    assert.equal(action("explore", { heartbeat: { ...round, "Survey Batteries": 1 } }).note, "Again, 1240 m, 6 min");
    assert.equal(action("explore", { heartbeat: { ...round, "Survey Batteries": 3 } }).note, "Again, 1240 m, 6 min, 3 batteries");
  });

  it("show the distance home, and the time until it stands on the ground", () => {
    const away = heartbeat({ North: 30, East: 40, Options: possible("Return To Launch") });
    assert.equal(action("home", { heartbeat: away }).note, "50 m");
    assert.equal(action("home", { heartbeat: { ...away, "Time Home": 57.4 } }).note, "50 m, 57 s to the ground");
  });
});

describe("Hold and Land", () => {
  it("Hold is refused by nothing but the ground and a closed socket", () => {
    const hold = (changes: Partial<View>): Action => safetyActions(view(changes)).hold;
    assert.equal(hold({}).kind, "possible");
    assert.equal(hold({ heartbeat: heartbeat({ State: "Manual", Options: [impossible("Hold", "Someone else flies.")] }) }).kind, "possible");
    assert.equal(hold({ heartbeat: heartbeat({ "In Control": false }) }).kind, "possible");
    assert.deepEqual([hold({ heartbeat: heartbeat(ground) }).kind, hold({ heartbeat: heartbeat(ground) }).note], ["impossible", "On the ground"]);
    assert.equal(hold({ link: "waiting" }).note, "No link");
    assert.equal(hold({ heartbeat: null }).kind, "impossible");
  });

  it("Land follows what the drone offers", () => {
    assert.equal(safetyActions(view({ heartbeat: heartbeat({ Options: possible("Land") }) })).land.kind, "possible");
    const landing = heartbeat({ State: "Land", Options: [impossible("Land", "Already landing.")] });
    assert.equal(safetyActions(view({ heartbeat: landing })).land.note, "Landing");
  });
});

describe("control", () => {
  it("is mine, someone else's, nobody's, or not known", () => {
    assert.equal(control(view()), "mine");
    assert.equal(control(view({ heartbeat: heartbeat({ "In Control": false }) })), "other");
    assert.equal(control(view({ heartbeat: heartbeat({ "In Control": false, Controller: null }) })), "free");
    const lost = { "In Control": false, "Controller Lost": true };
    assert.equal(control(view({ heartbeat: heartbeat(lost) })), "lost");
    assert.equal(control(view({ silence: 5 })), "unknown");
  });
});

describe("the banner", () => {
  const exploring = heartbeat({ State: "Autonomous Explore" });

  it("is absent while all is well", () => {
    assert.equal(banner(view()), null);
    assert.equal(banner(view({ heartbeat: null, silence: null, link: "open" })), null);
  });

  it("offers to connect before the drone was heard", () => {
    const words = banner(view({ heartbeat: null, silence: null, link: "waiting", attempts: 1 }));
    assert.equal(words?.connect, true);
    assert.match(words.title, /Not connected/);
  });

  it("shows what the drone does by its settings and when", () => {
    const early = banner(view({ heartbeat: exploring, silence: 6 }));
    assert.match(early?.title ?? "", /No word from the drone for 6 s/);
    assert.match(early?.text ?? "", /By its settings it goes on until 12:00:04, then holds its place\. At 12:00:34 it returns home/);
    const holding = banner(view({ heartbeat: exploring, silence: 16 }));
    assert.match(holding?.text ?? "", /By its settings it now holds its place\. At 12:00:24 it returns home and lands/);
    assert.equal(holding?.timeline?.countdown, "24 s");
    const late = banner(view({ heartbeat: exploring, silence: 50 }));
    assert.match(late?.text ?? "", /By its settings it has been returning home since/);
    assert.equal(late?.timeline?.countdown, "");
  });

  it("counts in the simulation's time", () => {
    const welcome = { ...view().welcome!, Speed: 4 };
    const words = banner(view({ heartbeat: exploring, silence: 4, welcome }));
    assert.match(words?.text ?? "", /now holds its place/);
    assert.equal(words?.timeline?.countdown, "6 s");
  });

  it("has no countdown where the drone waits for nobody", () => {
    const of = (State: string, more = {}): string => {
      const words = banner(view({ heartbeat: heartbeat({ State, ...more }), silence: 5 }));
      assert.equal(words?.timeline, null);
      return words.text;
    };
    assert.match(of("Return To Launch"), /goes on home/);
    assert.match(of("Land"), /goes on landing/);
    assert.match(of("Manual"), /remote control when it was last heard/);
    assert.match(of("Idle", ground), /on the ground when it was last heard/);
    assert.match(of("Hover", { "In Control": false }), /Another operator had control/);
  });

  it("shows a lost operator, a silent autopilot and a cut that is not confirmed", () => {
    const lost = banner(view({ heartbeat: heartbeat({ State: "CommunicationLost", "Return In": 24, "In Control": false }) }));
    assert.match(lost?.text ?? "", /In 24 s it returns home and lands\. Take control to go on/);
    assert.match(banner(view({ heartbeat: heartbeat({ Connected: false }) }))?.title ?? "", /does not hear the autopilot/);
    const cut = banner(view({ heartbeat: heartbeat({ "Kill State": "not confirmed" }) }));
    assert.equal(cut?.tone, "bad");
  });

  it("is right too when the drone's computer stopped and the autopilot acts sooner", () => {
    const early = banner(view({ heartbeat: exploring, silence: 6 }));
    assert.match(early?.text ?? "", /If its computer stopped, the autopilot acts sooner by its own failsafe\. To take over/);
    assert.equal(early?.timeline?.marks.at(-1)?.label, "returns home at the latest in");
    assert.match(banner(view({ heartbeat: exploring, silence: 16 }))?.text ?? "", /the autopilot acts sooner by its own failsafe/);
    assert.match(banner(view({ heartbeat: exploring, silence: 50 }))?.text ?? "", /the autopilot acted sooner by its own failsafe/);
    const landing = banner(view({ heartbeat: heartbeat({ State: "Land" }), silence: 6 }));
    assert.match(landing?.text ?? "", /goes on landing\. If its computer stopped, the autopilot acts by its own failsafe/);
    const grounded = banner(view({ heartbeat: heartbeat(ground), silence: 6 }));
    assert.doesNotMatch(grounded?.text ?? "", /failsafe/);
  });
});

describe("a move", () => {
  const fence = [
    { North: -50, East: -50 },
    { North: -50, East: 50 },
    { North: 50, East: 50 },
    { North: 50, East: -50 },
  ];
  const able = heartbeat({ Fence: fence, Options: possible("Autonomous Move", "Compulsive Move") });

  it("is described by distance, direction and height", () => {
    const plan = planMove(view({ heartbeat: able }), { North: 0, East: -38 }, CELL.lot);
    assert.equal(plan?.question, "Move 38 m west, staying at 35 m?");
    assert.equal(plan.pill, "38 m, 10 s");
    assert.equal(planMove(view({ heartbeat: able, welcome: null }), { North: 0, East: -38 }, CELL.lot)?.pill, "38 m");
  });

  it("climbs to the lowest height first", () => {
    const low = { ...able, "Relative Altitude": 8 };
    assert.equal(planMove(view({ heartbeat: low }), { North: 10, East: 0 }, CELL.lot)?.question, "Move 10 m north, climbing to 15 m?");
  });

  it("suggests the lot where there is lot, else anywhere inside the fence", () => {
    const suggested = (cell: number) => planMove(view({ heartbeat: able }), { North: 9, East: 0 }, cell)?.suggested;
    assert.equal(suggested(CELL.free), "Autonomous Move");
    assert.equal(suggested(CELL.unknown), "Compulsive Move");
    assert.equal(suggested(CELL.nonLot), "Compulsive Move");
  });

  it("is refused outside the fence, and inside the lot where none is", () => {
    const outside = planMove(view({ heartbeat: able }), { North: 60, East: 0 }, CELL.lot);
    assert.equal(outside?.suggested, null);
    assert.match(consequence(view({ heartbeat: able }), outside, "Compulsive Move"), /Outside the fence/);
    const grass = planMove(view({ heartbeat: able }), { North: 9, East: 0 }, CELL.nonLot);
    assert.deepEqual([grass?.choices[0]?.possible, grass?.choices[0]?.reason], [false, "Not a place inside the lot"]);
  });

  it("straight over a gap of the fence is refused, and around it is not", () => {
    const horseshoe = [
      { North: -20, East: -45 },
      { North: 40, East: -45 },
      { North: 40, East: -15 },
      { North: 10, East: -15 },
      { North: 10, East: 15 },
      { North: 40, East: 15 },
      { North: 40, East: 45 },
      { North: -20, East: 45 },
    ];
    const anywhere = (North: number, East: number, from = able) =>
      planMove(view({ heartbeat: { ...from, Fence: horseshoe } }), { North, East }, CELL.unknown)?.choices[1];
    assert.deepEqual([anywhere(30, -30)?.possible, anywhere(30, -30)?.reason], [false, "The straight path there leaves the fence"]);
    assert.equal(anywhere(0, -30)?.possible, true);
    const inTheArm = { ...able, North: 30, East: -30 };
    assert.equal(anywhere(30, 30, inTheArm)?.possible, false);
    assert.equal(anywhere(0, -30, inTheArm)?.possible, true);
    assert.equal(crosses(horseshoe, { North: 30, East: -30 }, { North: 30, East: 30 }), true);
  });

  it("over the lot shows its route's length, or why there is no route, in the bar's second line", () => {
    const now = view({ heartbeat: able });
    const known = { metres: 52, reason: "" };
    const plan = planMove(now, { North: 9, East: 0 }, CELL.lot, known);
    assert.ok(plan);
    assert.match(consequence(now, plan, "Autonomous Move", known), /52 m along the route/);
    assert.doesNotMatch(consequence(now, plan, "Compulsive Move", known), /along the route/);
    const none = planMove(now, { North: 9, East: 0 }, CELL.lot, { metres: null, reason: "X, Y: no route over the lot." });
    assert.deepEqual([none?.choices[0]?.possible, none?.choices[0]?.reason, none?.suggested], [false, "no route over the lot.", "Compulsive Move"]);
    const outside = planMove(now, { North: 60, East: 0 }, CELL.lot, known);
    assert.equal(outside?.refusal, "Outside the fence");
  });

  it("says what it ends, and needs to know where the drone is", () => {
    const exploring = view({ heartbeat: { ...able, State: "Autonomous Explore" } });
    const plan = planMove(exploring, { North: 9, East: 0 }, CELL.lot);
    assert.ok(plan);
    assert.match(consequence(exploring, plan, "Autonomous Move"), /Exploring stops/);
    assert.equal(planMove(view({ heartbeat: { ...able, North: null } }), { North: 9, East: 0 }, CELL.lot), null);
  });

  it("says what it costs of the battery, never rounded down, and nothing that is not known", () => {
    const charged = { ...able, "Battery Percentage": 80, "Battery Needed Home": 20, "Battery Time Left": 600 };
    const cost = (changes: Partial<Heartbeat>, speed: number | null): string => {
      const now = view({ heartbeat: { ...charged, ...changes }, welcome: speed === null ? null : welcome({ "Travel Speed": speed }) });
      const plan = planMove(now, { North: 45, East: 0 }, CELL.lot);
      assert.ok(plan);
      return consequence(now, plan, "Autonomous Move");
    };
    assert.match(cost({}, 3), /^15 s, about 2 % battery\./, "60 % last 600 s: 1.5 % for 15 s");
    assert.match(cost({ "Battery Time Left": null }, 3), /^15 s\. /);
    assert.doesNotMatch(cost({}, null), /battery/);
  });

  it("knows inside from outside of any polygon", () => {
    assert.equal(contains(fence, { North: 49, East: -49 }), true);
    assert.equal(contains(fence, { North: 51, East: 0 }), false);
    const notch = [...fence.slice(0, 3), { North: 0, East: 0 }, fence[3]!];
    assert.equal(contains(notch, { North: 40, East: 0 }), false);
    assert.equal(contains(notch, { North: -10, East: 0 }), true);
  });
});
