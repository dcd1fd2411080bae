import "./dom.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { ACCESS_ENDED, BACKOFF_MS } from "../src/link/reconnect.ts";
import { Operator } from "../src/state/operator.ts";
import { ActionBar } from "../src/ui/action-bar.ts";
import { GlanceLine } from "../src/ui/glance-line.ts";
import "../src/ui/heights-button.ts";
import { OwnName } from "../src/ui/own-name.ts";
import { SettingsTab } from "../src/ui/settings-tab.ts";
import { FakeServer, FakeStorage, FakeTimers } from "./fakes.ts";
import { heartbeat, possible, welcome } from "./make.ts";
import { flying, type Rig } from "./rig.ts";
import { Stage } from "./stage.ts";

const ALL = possible("Arm", "Takeoff", "Land", "Hold", "Return To Launch", "Kill Request", "Configure", "Set Fence");

function watching(changes: Parameters<typeof heartbeat>[0] = {}): Rig {
  const rig = flying({ "In Control": false, Controller: null, Options: ALL, ...changes });
  rig.server.last.say(welcome({ Role: "viewer", Login: true }));
  rig.hear({});
  return rig;
}

describe("the page of a viewer", () => {
  for (const [state, changes] of [
    ["free", { Controller: null }],
    ["held", { Controller: "Anna" }],
    ["lost", { Controller: "Anna", "Controller Lost": true }],
  ] as const) {
    it(`offers no command while control is ${state}`, async () => {
      const rig = watching(changes);
      const bar = new Stage(new ActionBar(), rig.operator);
      const glance = new Stage(new GlanceLine(), rig.operator);
      await bar.drawn();
      await glance.drawn();
      assert.match(bar.text, /You are watching as a viewer\./);
      assert.deepEqual(bar.enabled(), []);
      assert.doesNotMatch(glance.text, /Cut motors/);
      assert.deepEqual(rig.sent(), []);
    });
  }

  it("has settings without commands, and says why", async () => {
    const rig = watching();
    const settings = new Stage(new SettingsTab(), rig.operator);
    await settings.drawn();
    assert.match(settings.text, /You are watching as a viewer\./);
    assert.equal(settings.button("Change heights").disabled, true);
    assert.equal(settings.button("Edit fence").disabled, true);
    assert.match(settings.text, /Change heights\s*You are a viewer/);
  });

  it("neither asks for a name nor sends the one that the browser keeps", async () => {
    const rig = watching();
    const asks = new OwnName();
    asks.asks = true;
    const stage = new Stage(asks, rig.operator);
    await stage.drawn();
    assert.equal(stage.text, "");
    rig.operator.prefer({ name: "Anna" });
    rig.server.last.say(welcome({ Role: "viewer" }));
    assert.deepEqual(rig.sent(), []);
    rig.server.last.say(welcome());
    assert.deepEqual(rig.sent().map((each) => each.Type), ["Name"]);
  });
});

describe("the login", () => {
  function withLogin(): { operator: Operator; server: FakeServer; timers: FakeTimers; done: string[] } {
    const done: string[] = [];
    const server = new FakeServer();
    const timers = new FakeTimers();
    const operator = new Operator({
      commandUrl: "wss://drone/ws",
      open: server.open,
      timers,
      wallClock: () => timers.now(),
      storage: new FakeStorage(),
      session: new FakeStorage(),
      logIn: () => done.push("log in"),
      checkLogin: () => done.push("check"),
      logOut: () => done.push("log out"),
    });
    operator.connect();
    return { operator, server, timers, done };
  }

  it("is ended by a button, after control was given back", async () => {
    const { operator, server, done } = withLogin();
    server.last.accept();
    server.last.say(welcome({ Login: true }));
    server.last.say(heartbeat({ "In Control": true }));
    const stage = new Stage(new SettingsTab(), operator);
    await stage.drawn();
    assert.match(stage.text, /Logged in as operator/);
    assert.equal(stage.button("Log out").disabled, true);
    assert.match(stage.text, /Give back control first/);
    server.last.say(heartbeat({ "In Control": false, Controller: null }));
    await stage.drawn();
    await stage.press("Log out");
    assert.deepEqual(done, ["log out"]);
  });

  it("has no button where nothing is asked for", async () => {
    const stage = new Stage(new SettingsTab(), flying().operator);
    await stage.drawn();
    assert.doesNotMatch(stage.text, /Log out/);
  });

  it("is shown when the server ends it, and looked at when a connection is refused", () => {
    const { server, timers, done } = withLogin();
    server.last.break();
    assert.deepEqual(done, ["check"]);
    timers.advance(BACKOFF_MS[0]!);
    server.last.accept();
    server.last.break();
    assert.deepEqual(done, ["check"], "a connection that was open broke: the link, not the login");
    timers.advance(BACKOFF_MS[1]!);
    server.last.accept();
    server.last.onclose?.({ code: ACCESS_ENDED } as CloseEvent);
    assert.deepEqual(done, ["check", "log in"]);
  });
});
