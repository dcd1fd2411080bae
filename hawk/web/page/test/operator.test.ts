import assert from "node:assert/strict";
import { describe, it } from "node:test";
import type { MapChange } from "../src/state/map-store.ts";
import { STANDARD } from "../src/state/preferences.ts";
import { settle } from "./fakes.ts";
import { heartbeat, mapUpdate, stall, welcome } from "./make.ts";
import { flying } from "./rig.ts";

describe("the operator", () => {
  it("shows why a command was refused, until the next one is taken", async () => {
    const { operator, answer } = flying();
    void operator.command({ Type: "Autonomous Explore" }, "Explore");
    await answer(false, "No lot in sight.");
    assert.equal(operator.toasts.shown?.text, "Explore: No lot in sight.");
    assert.equal(operator.flight.lines[0]?.text, "Explore: No lot in sight.");
    void operator.command({ Type: "Hold" }, "Hold");
    await answer(true);
    assert.equal(operator.toasts.shown, null);
  });

  it("gives a sign of life only while in control", () => {
    const { operator, server, sent } = flying();
    operator.signOfLife();
    assert.deepEqual(sent(), [{ Type: "Heartbeat" }]);
    server.last.say(heartbeat({ "In Control": false }));
    operator.signOfLife();
    assert.equal(sent().length, 1);
  });

  it("drops a question when the state changes", () => {
    const { operator, server } = flying();
    operator.ask({ about: "move", target: { North: 1, East: 2 } });
    server.last.say(heartbeat());
    assert.notEqual(operator.question, null);
    server.last.say(heartbeat({ State: "Return To Launch" }));
    assert.equal(operator.question, null);
  });

  it("drops question and cut when the link is lost, and reports it once", () => {
    const { operator, timers } = flying();
    operator.ask({ about: "Land" });
    void operator.cut.begin();
    timers.advance(3000);
    operator.tick();
    operator.tick();
    assert.deepEqual([operator.question, operator.cut.current], [null, null]);
    assert.equal(operator.flight.lines.filter((line) => line.text === "Link lost.").length, 1);
  });

  it("keeps the last values over a new connection and takes the map again", () => {
    const { operator, server, timers } = flying();
    const changes: MapChange[] = [];
    operator.addEventListener("map", (event) => changes.push((event as CustomEvent<MapChange>).detail));
    server.last.say(heartbeat({ "Occupancy Map": mapUpdate({ Stalls: [stall(1)] }) }));
    server.last.break();
    timers.advance(300);
    assert.notEqual(operator.view().heartbeat, null);
    server.last.accept();
    server.last.say(welcome());
    server.last.say(heartbeat({ "Occupancy Map": mapUpdate({ Stalls: [stall(2)] }) }));
    assert.deepEqual(changes.map((change) => change.reset), [true, true]);
    assert.deepEqual([...operator.map.stalls.keys()], [2]);
  });

  it("ignores what it does not know", () => {
    const { operator, server } = flying();
    const before = operator.view().heartbeat;
    for (const strange of [{ Type: "Weather" }, 7, null]) server.last.say(strange);
    server.last.onmessage?.({ data: "{" } as MessageEvent);
    assert.equal(operator.view().heartbeat, before);
  });

  it("keeps preferences", () => {
    const { operator } = flying();
    operator.prefer({ leftHanded: true });
    assert.deepEqual(operator.preferences, { ...STANDARD, leftHanded: true });
  });
});

describe("cutting the motors", () => {
  async function ready(): Promise<ReturnType<typeof flying>> {
    const all = flying();
    void all.operator.cut.begin();
    all.server.last.say({ Type: "Kill Token", Id: all.sent().at(-1)?.Id, Token: "t".repeat(24), "Valid For": 10 });
    await settle();
    return all;
  }

  it("needs a token before it can be done", async () => {
    const { operator, sent } = flying();
    void operator.cut.begin();
    assert.equal(operator.cut.current?.step, "asking");
    await operator.cut.finish();
    assert.deepEqual(sent().map((each) => each.Type), ["Kill Request"]);
  });

  it("uses the token once", async () => {
    const { operator, sent } = await ready();
    assert.equal(operator.cut.current?.step, "ready");
    void operator.cut.finish();
    await operator.cut.finish();
    assert.deepEqual(sent().map((each) => each.Type), ["Kill Request", "Kill"]);
    assert.equal(sent()[1]?.Token, "t".repeat(24));
  });

  it("forgets the token when it is cancelled, too old, or the motors are off", async () => {
    const cancelled = await ready();
    cancelled.operator.cut.end();
    await cancelled.operator.cut.finish();
    assert.equal(cancelled.sent().length, 1);
    const old = await ready();
    for (let second = 0; second < 10; second += 1) {
      old.timers.advance(1000);
      old.server.last.say(heartbeat());
    }
    assert.match(old.operator.cut.current?.problem ?? "", /took too long/);
    await old.operator.cut.finish();
    assert.equal(old.sent().length, 1);
    const down = await ready();
    down.server.last.say(heartbeat({ Armed: false }));
    assert.equal(down.operator.cut.current, null);
  });

  it("shows why no token was given, and does not mix up two attempts", async () => {
    const { operator, server, sent, answer } = flying();
    void operator.cut.begin();
    await answer(false, "Someone else has control.");
    assert.equal(operator.cut.current?.problem, "Someone else has control.");
    operator.cut.end();
    void operator.cut.begin();
    const first = sent().at(-1)?.Id;
    operator.cut.end();
    void operator.cut.begin();
    server.last.say({ Type: "Kill Token", Id: first, Token: "x".repeat(24), "Valid For": 10 });
    await settle();
    assert.equal(operator.cut.current.step, "asking");
  });
});
