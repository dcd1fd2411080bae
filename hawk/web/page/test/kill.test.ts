import "./dom.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { GlanceLine } from "../src/ui/glance-line.ts";
import { KillDialog } from "../src/ui/kill-dialog.ts";
import { settle } from "./fakes.ts";
import { welcome } from "./make.ts";
import { flying, type Rig } from "./rig.ts";
import { Frames, Stage } from "./stage.ts";

const RED = "Keep pressed 1 s to cut";

interface Scene {
  rig: Rig;
  stage: Stage<KillDialog>;
  frames: Frames;
}

/** The first step was taken: the dialog asks the drone for its token. */
async function begun(): Promise<Scene> {
  const frames = new Frames();
  const rig = flying();
  const stage = new Stage(new KillDialog(), rig.operator);
  await stage.drawn();
  void rig.operator.cut.begin();
  await stage.drawn();
  return { rig, stage, frames };
}

async function ready(): Promise<Scene> {
  const scene = await begun();
  scene.rig.server.last.say({ Type: "Kill Token", Id: scene.rig.sent().at(-1)?.Id, Token: "secret", "Valid For": 10 });
  await settle();
  await scene.stage.drawn();
  return scene;
}

function press(stage: Stage<KillDialog>, type: string): void {
  stage.button(RED).dispatchEvent(new PointerEvent(type, { button: 0, bubbles: true }));
}

function kills(rig: Rig): unknown[] {
  return rig.sent().filter((each) => each.Type === "Kill").map((each) => each.Token);
}

describe("cutting the motors", () => {
  it("can begin unless someone else who is there has control", async () => {
    const rig = flying();
    const stage = new Stage(new GlanceLine(), rig.operator);
    await stage.drawn();
    for (const [changes, disabled] of [
      [{}, false],
      [{ "In Control": false }, true],
      [{ "In Control": false, "Controller Lost": true }, false],
      [{ "In Control": false, Controller: null }, false],
    ] as const) {
      rig.hear(changes);
      await stage.drawn();
      assert.equal(stage.button("Cut motors").disabled, disabled, JSON.stringify(changes));
    }
  });

  it("shows nothing before the first step", async () => {
    const stage = new Stage(new KillDialog(), flying().operator);
    await stage.drawn();
    assert.equal(stage.text, "");
  });

  it("asks for a token first, and cannot be done before it came", async () => {
    const { rig, stage } = await begun();
    assert.deepEqual(rig.sent().map((each) => each.Type), ["Kill Request"]);
    assert.equal(stage.button(RED).disabled, true);
    assert.match(stage.text, /The drone falls from 35 m at once/);
    assert.equal(document.activeElement, stage.button("Cancel"));
  });

  it("is done once the button was kept pressed for a second", async () => {
    const { rig, stage, frames } = await ready();
    assert.equal(stage.button(RED).disabled, false);
    press(stage, "pointerdown");
    frames.advance(600);
    assert.deepEqual(kills(rig), []);
    frames.advance(500);
    await stage.drawn();
    assert.deepEqual(kills(rig), ["secret"]);
    assert.equal(stage.text, "");
    frames.advance(5000);
    assert.deepEqual(kills(rig), ["secret"]);
  });

  for (const end of ["pointerup", "pointerleave", "pointercancel", "blur"]) {
    it(`is not done when the press ends early by ${end}`, async () => {
      const { rig, stage, frames } = await ready();
      press(stage, "pointerdown");
      frames.advance(900);
      press(stage, end);
      frames.advance(900);
      press(stage, "pointerdown");
      frames.advance(900);
      assert.deepEqual(kills(rig), []);
    });
  }

  it("counts a press of a second when the release comes before the next look at it", async () => {
    for (const [milliseconds, done] of [[900, []], [1000, ["secret"]]] as const) {
      const { rig, stage, frames } = await ready();
      press(stage, "pointerdown");
      frames.advance(800);
      frames.stall(milliseconds - 800);
      press(stage, "pointerup");
      frames.advance(2000);
      assert.deepEqual(kills(rig), done);
    }
  });

  it("counts on a screen that draws nothing, as long as the page follows", async () => {
    const { rig, stage, frames } = await ready();
    press(stage, "pointerdown");
    frames.advance(1100, false);
    assert.deepEqual(kills(rig), ["secret"]);
  });

  it("does not count what a busy page could not follow, and says so", async () => {
    for (const released of [true, false]) {
      const { rig, stage, frames } = await ready();
      press(stage, "pointerdown");
      frames.advance(200);
      frames.stall(1500);
      if (released) press(stage, "pointerup");
      frames.advance(2000);
      await stage.drawn();
      assert.deepEqual(kills(rig), []);
      assert.match(stage.text, /too busy to follow the press/);
      press(stage, "pointerdown");
      frames.advance(1100);
      assert.deepEqual(kills(rig), ["secret"], "pressed again");
    }
  });

  it("does not count a press that the page learns of too late", async () => {
    const { rig, stage, frames } = await ready();
    const down = new PointerEvent("pointerdown", { button: 0, bubbles: true });
    frames.stall(1500);
    stage.button(RED).dispatchEvent(down);
    frames.advance(2000);
    await stage.drawn();
    assert.deepEqual(kills(rig), []);
    assert.match(stage.text, /too busy to follow the press/);
  });

  it("takes the time of the release, not of its handling", async () => {
    const { rig, stage, frames } = await ready();
    press(stage, "pointerdown");
    frames.advance(900);
    const up = new PointerEvent("pointerup", { button: 0, bubbles: true });
    frames.stall(200);
    frames.run();
    assert.deepEqual(kills(rig), [], "what was let go meanwhile is still to be reported");
    stage.button(RED).dispatchEvent(up);
    frames.advance(2000);
    assert.deepEqual(kills(rig), []);
  });

  it("is not done by a key that was pressed for something else and repeats itself", async () => {
    const { rig, stage, frames } = await ready();
    for (let repeat = 0; repeat < 60; repeat += 1) {
      stage.button(RED).dispatchEvent(new KeyboardEvent("keydown", { key: "Enter", bubbles: true, repeat: true }));
      frames.advance(50);
    }
    assert.deepEqual(kills(rig), []);
  });

  it("is not done once the window lost the focus or is hidden: nobody would report the release", async () => {
    for (const leave of [() => window.dispatchEvent(new Event("blur")), () => document.dispatchEvent(new Event("visibilitychange"))]) {
      for (const down of [
        () => new PointerEvent("pointerdown", { button: 0, bubbles: true }),
        () => new KeyboardEvent("keydown", { key: "Enter", bubbles: true }),
      ]) {
        const { rig, stage, frames } = await ready();
        stage.button(RED).dispatchEvent(down());
        frames.advance(500);
        leave();
        frames.advance(2000);
        assert.deepEqual(kills(rig), []);
      }
    }
  });

  it("does not count a press that left the button, however long it was", async () => {
    for (const end of ["pointerleave", "pointercancel", "blur"]) {
      const { rig, stage, frames } = await ready();
      press(stage, "pointerdown");
      frames.stall(1500);
      press(stage, end);
      frames.advance(2000);
      assert.deepEqual(kills(rig), []);
    }
  });

  it("takes Enter and space, and no other button of the mouse", async () => {
    const { rig, stage, frames } = await ready();
    stage.button(RED).dispatchEvent(new PointerEvent("pointerdown", { button: 2, bubbles: true }));
    frames.advance(1500);
    assert.deepEqual(kills(rig), []);
    stage.button(RED).dispatchEvent(new KeyboardEvent("keydown", { key: " ", bubbles: true }));
    frames.advance(1100);
    assert.deepEqual(kills(rig), ["secret"]);
  });

  it("ends by Cancel and by Escape, also in the middle of a press", async () => {
    for (const end of ["Cancel", "Escape"]) {
      const { rig, stage, frames } = await ready();
      press(stage, "pointerdown");
      frames.advance(900);
      if (end === "Cancel") await stage.press("Cancel");
      else stage.find(".kill").dispatchEvent(new KeyboardEvent("keydown", { key: "Escape", bubbles: true }));
      await stage.drawn();
      frames.advance(900);
      assert.equal(stage.text, "");
      assert.deepEqual(kills(rig), []);
    }
  });

  it("ends in the middle of a press when the link is lost", async () => {
    const { rig, stage, frames } = await ready();
    press(stage, "pointerdown");
    frames.advance(900);
    rig.timers.advance(3000);
    rig.operator.tick();
    await stage.drawn();
    frames.advance(900);
    assert.equal(stage.text, "");
    assert.deepEqual(kills(rig), []);
  });

  it("says why the drone does not allow it", async () => {
    const { rig, stage } = await begun();
    await rig.answer(false, "Someone else has control.");
    await stage.drawn();
    assert.match(stage.text, /Someone else has control\./);
    assert.equal(stage.button(RED).disabled, true);
  });

  it("is shut again when the token has run out", async () => {
    const { rig, stage } = await ready();
    for (let second = 0; second < 11; second += 1) {
      rig.timers.advance(1000);
      rig.hear({});
    }
    await stage.drawn();
    assert.match(stage.text, /took too long/);
    assert.equal(stage.button(RED).disabled, true);
  });

  it("is shut as soon as the clock of a simulated drone says so", async () => {
    const { rig, stage } = await begun();
    rig.server.last.say({ ...welcome(), Speed: 4 });
    rig.server.last.say({ Type: "Kill Token", Id: rig.sent().at(-1)?.Id, Token: "secret", "Valid For": 10 });
    await settle();
    rig.timers.advance(2400);
    await stage.drawn();
    assert.equal(stage.button(RED).disabled, false);
    rig.timers.advance(200);
    await stage.drawn();
    assert.equal(stage.button(RED).disabled, true);
    assert.match(stage.text, /took too long/);
  });
});
