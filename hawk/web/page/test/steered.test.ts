import "./dom.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import type { Heartbeat, PlanOfferStatus } from "../src/protocol.ts";
import { HiddenPage } from "../src/state/hidden-page.ts";
import { ControlNotePart } from "../src/ui/control-note.ts";
import { isUnseen, type PictureWindows } from "../src/ui/picture-window.ts";
import { heartbeat, view, welcome } from "./make.ts";
import { flying } from "./rig.ts";
import { Stage } from "./stage.ts";

const MINE: Partial<Heartbeat> = { State: "Autonomous Explore", Controller: "Ana", "Own Name": "Ana", "In Control": true };
const OFFER: PlanOfferStatus = { Plan: "lot-2-7", Lot: "North lot", By: "Operator 2", Stalls: 50, Before: 40 };

describe("a plan that somebody changed in flight", () => {
  it("is put as a question to the one in control, and flown by a press", async () => {
    const rig = flying(MINE);
    const stage = new Stage(new ControlNotePart(), rig.operator);
    await stage.drawn();
    assert.equal(stage.text, "");
    rig.hear({ "Plan Offer": OFFER });
    await stage.drawn();
    assert.match(stage.text, /Plan of North lot changed, signed Operator 2\. Fly it\?/);
    assert.match(stage.text, /40 stalls → 50 stalls/);
    await stage.press("Fly it");
    const { Type, Plan } = rig.sent().at(-1) ?? { Type: "" };
    assert.deepEqual({ Type, Plan }, { Type: "Fly Plan", Plan: "lot-2-7" });
  });

  it("is left by a press, until it is changed again", async () => {
    const rig = flying({ ...MINE, "Plan Offer": OFFER });
    const stage = new Stage(new ControlNotePart(), rig.operator);
    await stage.drawn();
    const sent = rig.sent().length;
    await stage.press("Leave it");
    await stage.drawn();
    assert.equal(stage.text, "");
    assert.equal(rig.sent().length, sent);
    rig.hear({ "Plan Offer": { ...OFFER, Plan: "lot-2-8", By: null } });
    await stage.drawn();
    assert.match(stage.text, /signed Operator\. Fly it\?/);
  });

  it("asks nobody who watches", async () => {
    const rig = flying({ ...MINE, "In Control": false, "Plan Offer": OFFER });
    const stage = new Stage(new ControlNotePart(), rig.operator);
    await stage.drawn();
    assert.equal(stage.text, "");
  });
});

describe("a hidden page", () => {
  it("says so with its sign of life", () => {
    const rig = flying(MINE);
    rig.operator.signOfLife(true);
    assert.deepEqual(rig.sent().at(-1), { Type: "Heartbeat", Hidden: true });
    rig.operator.signOfLife(false);
    assert.deepEqual(rig.sent().at(-1), { Type: "Heartbeat" });
  });

  it("counts as seen while the small picture window is open", () => {
    const windows: PictureWindows = { window, requestWindow: () => Promise.reject(new Error()) };
    const put = (on: object, name: string, value: unknown): void => void Object.defineProperty(on, name, { value, configurable: true });
    put(document, "hidden", true);
    assert.equal(isUnseen(), true);
    put(window, "documentPictureInPicture", windows);
    assert.equal(isUnseen(), false);
    put(window, "documentPictureInPicture", { ...windows, window: null });
    assert.equal(isUnseen(), true);
    put(document, "hidden", false);
    assert.equal(isUnseen(), false);
    put(window, "documentPictureInPicture", undefined);
  });

  it("warns after 15 s of the drone's clock in a task, and once", () => {
    const page = new HiddenPage();
    const exploring = view({ heartbeat: heartbeat(MINE), welcome: welcome({ Speed: 2 }) });
    assert.equal(page.look(true, exploring, 100), null);
    assert.equal(page.look(true, exploring, 107.4), null);
    assert.match(page.look(true, exploring, 107.5) ?? "", /The page is hidden: look at it/);
    assert.equal(page.look(true, exploring, 108), null);
    assert.equal(page.look(false, exploring, 109), null);
  });

  it("warns of nothing while the drone holds, and on the page of those who watch", () => {
    const page = new HiddenPage();
    for (const changes of [{ ...MINE, State: "Hover" }, { ...MINE, "In Control": false }]) {
      const seen = view({ heartbeat: heartbeat(changes) });
      assert.equal(page.look(true, seen, 100), null);
      assert.equal(page.look(true, seen, 200), null);
    }
  });
});
