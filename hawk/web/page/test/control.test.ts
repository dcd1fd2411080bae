import "./dom.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { type Speaker, Voice } from "../src/link/voice.ts";
import type { Heartbeat } from "../src/protocol.ts";
import { Operator } from "../src/state/operator.ts";
import { ActionBar } from "../src/ui/action-bar.ts";
import { ControlNotePart } from "../src/ui/control-note.ts";
import { banner } from "../src/words/banner.ts";
import { controlNote, doneByAnother } from "../src/words/control.ts";
import { stateWords } from "../src/words/glance.ts";
import { FakeServer, FakeStorage, FakeTimers, settle } from "./fakes.ts";
import { heartbeat, view, welcome } from "./make.ts";
import { flying } from "./rig.ts";
import { Stage } from "./stage.ts";

const MINE: Partial<Heartbeat> = { Controller: "Ana", "Own Name": "Ana", "In Control": true };
const GROUNDED: Partial<Heartbeat> = { State: "Idle", Armed: false, Landed: "ON_GROUND" };
const WATCHING: Partial<Heartbeat> = { Controller: "Ana", "Own Name": "Ben", "In Control": false };

describe("the question for control", () => {
  it("is put to the one in control, with a countdown, and answered by a press", async () => {
    const rig = flying(MINE);
    const stage = new Stage(new ControlNotePart(), rig.operator);
    await stage.drawn();
    assert.equal(stage.text, "");
    rig.hear({ "Control Asked By": "Ben", "Control Free In": 20 });
    await stage.drawn();
    assert.match(stage.text, /Ben asks for control\. Without an answer Ben can take control in 20 s\./);
    rig.timers.advance(1500);
    rig.operator.tick();
    await stage.drawn();
    assert.match(stage.text, /in 19 s/);
    await stage.press("Keep");
    assert.deepEqual(rig.sent().at(-1)?.Action, "Keep");
    await stage.press("Give");
    assert.deepEqual(rig.sent().at(-1)?.Action, "Give");
  });

  it("counts in seconds of this page when the drone's clock is faster", () => {
    const now = heartbeat({ ...MINE, "Control Asked By": "Ben", "Control Free In": 20 });
    assert.match(controlNote(view({ heartbeat: now, welcome: welcome({ Speed: 4 }), silence: 0 }), false)?.text ?? "", /in 5 s/);
  });

  it("is seen by the one who asks, who can take control only when the time is over", async () => {
    const rig = flying(WATCHING);
    const stage = new Stage(new ControlNotePart(), rig.operator);
    void rig.operator.takeControl();
    assert.equal(rig.sent().at(-1)?.Action, "Ask");
    rig.hear({ "Control Asked By": "Ben", "Control Free In": 12.3 });
    await stage.drawn();
    assert.match(stage.text, /Ana was asked for control\. Without an answer you can take control in 13 s\./);
    assert.deepEqual(stage.enabled(), ["Withdraw"]);
    rig.hear({ "Control Asked By": "Ben", "Control Free In": 0 });
    await stage.drawn();
    await stage.press("Take control now");
    assert.equal(rig.sent().at(-1)?.Action, "Request");
    await stage.press("Withdraw");
    assert.equal(rig.sent().at(-1)?.Action, "Withdraw");
  });

  it("is not shown to others, nor without a link", () => {
    const other = heartbeat({ ...WATCHING, "Own Name": "Cleo", "Control Asked By": "Ben", "Control Free In": 3 });
    assert.equal(controlNote(view({ heartbeat: other }), false), null);
    const asked = heartbeat({ ...MINE, "Control Asked By": "Ben", "Control Free In": 3 });
    assert.equal(controlNote(view({ heartbeat: asked, silence: 5 }), false), null);
  });

  it("requests control that is free or that of a lost operator without asking anybody", () => {
    for (const changes of [{ Controller: null }, { "Controller Lost": true }]) {
      const rig = flying({ ...WATCHING, ...changes });
      void rig.operator.takeControl();
      assert.equal(rig.sent().at(-1)?.Action, "Request");
    }
  });

  it("shows the one who asked that control is kept, and each side when it went over", () => {
    const asking = flying(WATCHING);
    asking.hear({ "Control Kept": true });
    assert.equal(asking.operator.toasts.shown?.text, "Ana keeps control.");
    asking.hear({ "In Control": true, Controller: "Ben" });
    assert.equal(asking.operator.toasts.shown.text, "You have control.");
    const giving = flying(MINE);
    giving.hear({ "In Control": false, Controller: "Ben" });
    assert.equal(giving.operator.toasts.shown?.text, "Ben has control.");
    const late = flying(MINE);
    late.hear({ "In Control": false, Controller: "Ben", "Control Taken By": "Ben" });
    assert.equal(late.operator.toasts.shown?.text, "Ben took control: you were lost, or did not answer.");
  });
});

describe("giving back control", () => {
  it("asks first in the air, and says what the drone will do", async () => {
    const rig = flying({ ...MINE, State: "Hover" });
    const stage = new Stage(new ControlNotePart(), rig.operator);
    await rig.operator.releaseControl();
    await stage.drawn();
    assert.deepEqual(rig.sent(), []);
    assert.match(stage.text, /Give back control in the air\? It stops and holds for 30 s, then returns home and lands/);
    await stage.press("Keep control");
    assert.equal(stage.text, "");
    await rig.operator.releaseControl();
    await stage.drawn();
    await stage.press("Give back");
    assert.equal(rig.sent().at(-1)?.Action, "Release");
  });

  it("needs no question on the ground", () => {
    const rig = flying({ ...MINE, State: "Idle", Armed: false, Landed: "ON_GROUND" });
    void rig.operator.releaseControl();
    assert.equal(rig.sent().at(-1)?.Action, "Release");
  });

  it("is not reported as a lost operator", () => {
    const given = heartbeat({ State: "CommunicationLost", Controller: null, "In Control": false, "Return In": 20 });
    assert.equal(stateWords(view({ heartbeat: given })).title, "Nobody has control");
    assert.equal(banner(view({ heartbeat: given }))?.title, "Nobody has control");
    assert.match(banner(view({ heartbeat: given }))?.text ?? "", /In 20 s it returns home and lands\. Take control to go on\./);
    const lost = heartbeat({ State: "CommunicationLost", "Controller Lost": true, "In Control": false });
    assert.equal(stateWords(view({ heartbeat: lost })).title, "Operator lost");
    assert.equal(banner(view({ heartbeat: lost }))?.title, "The operator was lost");
  });
});

describe("what somebody else does", () => {
  it("is reported to the pilot by name, by eye and ear", () => {
    const heard: string[] = [];
    const { operator, server } = opened({ say: (text) => heard.push(text) });
    server.last.say(heartbeat({ ...MINE, State: "Autonomous Explore" }));
    server.last.say(heartbeat({ ...MINE, State: "Hover", "Asked By": "Eve" }));
    assert.equal(operator.toasts.shown?.text, "Stopped by Eve.");
    assert.equal(operator.flight.lines[0]?.text, "Stopped by Eve.");
    server.last.say(heartbeat({ ...MINE, State: "Hover", "Asked By": "Eve" }));
    server.last.say(heartbeat({ ...MINE, State: "Hover", "Asked By": "Eve", "Control Asked By": "Ben", "Control Free In": 20 }));
    assert.deepEqual(heard, ["Stopped by Eve.", "Ben asks for control."]);
  });

  it("is not what the pilot does, nor what the drone does by itself, nor what was before this page", () => {
    const explore = heartbeat({ ...MINE, State: "Autonomous Explore" });
    assert.equal(doneByAnother(explore, heartbeat({ ...MINE, State: "Hover", "Asked By": "Ana" })), null);
    assert.equal(doneByAnother(explore, heartbeat({ ...MINE, State: "Return To Launch", "Asked By": null })), null);
    assert.equal(doneByAnother(null, heartbeat({ ...MINE, State: "Hover", "Asked By": "Eve" })), null);
    assert.equal(doneByAnother(explore, heartbeat({ ...MINE, State: "Land", "Asked By": "Eve" })), "Landing, asked by Eve.");
  });
});

describe("sound", () => {
  class Utterance {
    lang = "";
    readonly text: string;
    constructor(text: string) {
      this.text = text;
    }
  }

  function speaker(spoken: string[]): Speaker {
    return {
      speechSynthesis: { cancel: () => undefined, speak: (words) => void spoken.push(words.text) },
      SpeechSynthesisUtterance: Utterance as unknown as NonNullable<Speaker["SpeechSynthesisUtterance"]>,
    };
  }

  it("comes after a gesture only, and only where it is wanted", () => {
    const spoken: string[] = [];
    let wanted = true;
    const voice = new Voice(speaker(spoken), () => wanted);
    voice.say("too early");
    voice.allow();
    voice.say("Stopped by Eve.");
    wanted = false;
    voice.say("not wanted");
    assert.deepEqual(spoken, ["Stopped by Eve."]);
  });

  it("is no error where the browser has none, or refuses it", () => {
    const broken: Speaker = {
      AudioContext: function absent() {
        throw new Error("no sound card");
      } as unknown as NonNullable<Speaker["AudioContext"]>,
      speechSynthesis: {
        cancel: () => undefined,
        speak: () => {
          throw new Error("not allowed");
        },
      },
      SpeechSynthesisUtterance: Utterance as unknown as NonNullable<Speaker["SpeechSynthesisUtterance"]>,
    };
    for (const each of [{}, broken]) {
      const voice = new Voice(each, () => true);
      assert.doesNotThrow(() => {
        voice.allow();
        voice.say("Stopped by Eve.");
      });
    }
  });
});

describe("the name", () => {
  it("is asked for in the bar of those who watch, kept, and sent again with each connection", async () => {
    const storage = new FakeStorage();
    const { operator, server, timers } = opened({ storage });
    server.last.say(heartbeat({ ...GROUNDED, ...WATCHING }));
    const stage = new Stage(new ActionBar(), operator);
    await stage.drawn();
    assert.deepEqual(server.last.sent, [], "no name is sent before one is given");
    stage.input("input[name=name]").value = " Ana ";
    stage.find("form").dispatchEvent(new Event("submit", { cancelable: true }));
    await stage.drawn();
    assert.equal(stage.has("input[name=name]"), false);
    assert.deepEqual(named(server), ["Ana"]);
    server.last.break();
    timers.advance(300);
    server.last.accept();
    server.last.say(welcome());
    assert.deepEqual(named(server), ["Ana"]);
    const again = opened({ storage });
    assert.equal(again.operator.preferences.name, "Ana");
    assert.deepEqual(named(again.server), ["Ana"]);
  });

  it("is asked of those who join in flight, and leaves the one who flies alone", async () => {
    const { operator, server } = opened({});
    server.last.say(heartbeat(WATCHING));
    const stage = new Stage(new ActionBar(), operator);
    await stage.drawn();
    assert.match(stage.text, /Your name/);
    server.last.say(heartbeat(MINE));
    await stage.drawn();
    assert.equal(stage.has("input[name=name]"), false, "the bar belongs to the flight");
  });

  it("is optional: left empty, nothing is sent", async () => {
    const { operator, server } = opened({});
    server.last.say(heartbeat({ ...GROUNDED, "In Control": false, Controller: null }));
    const stage = new Stage(new ActionBar(), operator);
    await stage.drawn();
    stage.find("form").dispatchEvent(new Event("submit", { cancelable: true }));
    await stage.press("Take control");
    assert.deepEqual(named(server), []);
  });

  it("shows why the drone refused it", async () => {
    const { operator, server } = opened({});
    server.last.say(heartbeat(GROUNDED));
    operator.rename("Operator 7");
    const id = (JSON.parse(server.last.sent.at(-1) ?? "{}") as { Id?: string }).Id;
    server.last.say({ Type: "Ack", Id: id, Accepted: false, Reason: "Name: choose another name" });
    await settle();
    assert.equal(operator.toasts.shown?.text, "Name: choose another name");
  });
});

function opened(changes: { say?: (text: string) => void; storage?: FakeStorage }): { operator: Operator; server: FakeServer; timers: FakeTimers } {
  const timers = new FakeTimers();
  const server = new FakeServer();
  const outside = { commandUrl: "ws://drone/ws", open: server.open, timers, wallClock: () => 1_000_000, storage: new FakeStorage(), session: new FakeStorage() };
  const operator = new Operator({ ...outside, ...changes });
  operator.connect();
  server.last.accept();
  server.last.say(welcome());
  return { operator, server, timers };
}

function named(server: FakeServer): unknown[] {
  const sent = server.last.sent.map((text) => JSON.parse(text) as { Type: string; Name?: unknown });
  return sent.filter((each) => each.Type === "Name").map((each) => each.Name);
}
