import "./dom.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { readFence, writeFence } from "../src/fence/geojson.ts";
import { LocalPlane } from "../src/fence/plane.ts";
import { FenceOnMap } from "../src/map/fence-on-map.ts";
import { shownOutline } from "../src/map/fence-shown.ts";
import type { FenceEditor, FenceEditorEvents, Ring } from "../src/map/fence-editor.ts";
import type { LotMap } from "../src/map/lot-map.ts";
import type { Heartbeat, OutlineSetup } from "../src/protocol.ts";
import { ActionBar } from "../src/ui/action-bar.ts";
import { FenceTools } from "../src/ui/fence-tools.ts";
import { OutlineButton } from "../src/ui/outline-button.ts";
import { cannotDraw, outlineSummary, sizeOf } from "../src/words/outline.ts";
import { CIRCLE, heartbeat, impossible, possible, view } from "./make.ts";
import { flying, type Rig } from "./rig.ts";
import { Stage, words } from "./stage.ts";
import { settle } from "./fakes.ts";

const PLANE = new LocalPlane({ Latitude: 48, Longitude: 11 });
const ring = (...places: [number, number][]) => places.map(([North, East]) => PLANE.toEarth({ North, East }));
const SQUARE = ring([-50, -50], [50, -50], [50, 50], [-50, 50]);
const HOLE = ring([-10, -10], [10, -10], [10, 10], [-10, 10]);
const BOW_TIE = ring([0, 0], [50, 50], [50, 0], [0, 50]);
const NONE: OutlineSetup = { Source: "none", Polygons: [], Holes: [], Area: 0, Again: [] };
const SET: OutlineSetup = { Source: "set", Polygons: [SQUARE], Holes: [HOLE], Area: 9600, Again: [] };
const ABLE = possible("Set Outline", "Set Fence");
const ON_GROUND: Partial<Heartbeat> = { State: "Idle", Armed: false, Landed: "ON_GROUND", "Fence Setup": CIRCLE, "Outline Setup": NONE, Options: ABLE };

function grounded(changes: Partial<Heartbeat> = {}): Rig {
  return flying({ ...ON_GROUND, ...changes });
}

describe("the area to explore", () => {
  it("is drawn, set, and closed once the drone takes it", async () => {
    const rig = grounded();
    const { outline } = rig.operator;
    rig.operator.editOutline();
    outline.draw(SQUARE);
    outline.draw(SQUARE, undefined, [HOLE]);
    void outline.save();
    const { Type, Polygons, Holes } = rig.sent().at(-1)!;
    assert.deepEqual([Type, Polygons, Holes], ["Set Outline", [SQUARE], [HOLE]]);
    assert.equal(outline.open, true, "not before the answer");
    await rig.answer(true);
    assert.deepEqual([outline.open, outline.draft], [false, null]);
    assert.match(rig.operator.toasts.shown?.text ?? "", /next Explore sees all of it inside the fence/);
  });

  it("stays open with what was drawn when the drone refuses it, and shows why", async () => {
    const rig = grounded();
    const { outline } = rig.operator;
    rig.operator.editOutline();
    outline.draw(SQUARE);
    void outline.save();
    await rig.answer(false, "Polygons: nothing of the outline lies inside the fence.");
    assert.deepEqual([outline.open, outline.saving, outline.draft?.isDrawn], [true, false, true]);
    assert.match(rig.operator.toasts.shown?.text ?? "", /nothing of the outline lies inside/);
  });

  it("is drawn on the ground only; what was drawn is kept when motors run", () => {
    const rig = grounded();
    const { outline } = rig.operator;
    rig.operator.editOutline();
    outline.draw(SQUARE);
    rig.hear({ State: "Arm", Armed: true });
    assert.deepEqual([outline.open, outline.draft?.isDrawn], [false, true]);
    assert.match(rig.operator.toasts.shown?.text ?? "", /on the ground only.*What was drawn is kept/);
    rig.operator.editOutline();
    assert.equal(outline.open, false, "not in this state");
    rig.hear({});
    rig.operator.editOutline();
    assert.deepEqual([outline.open, outline.draft?.corners], [true, SQUARE]);
  });

  it("is never drawn together with the fence", () => {
    const { operator } = grounded();
    operator.editFence();
    operator.editOutline();
    assert.deepEqual([operator.fence.open, operator.outline.open, operator.drawing === operator.fence], [true, false, true]);
    operator.fence.cancel();
    operator.editOutline();
    operator.editFence();
    assert.deepEqual([operator.fence.open, operator.outline.open, operator.drawing === operator.outline], [false, true, true]);
  });

  it("begins with the one in force; one of several polygons is not edited, so that none is lost", () => {
    const one = grounded({ "Outline Setup": SET }).operator;
    one.editOutline();
    assert.deepEqual([one.outline.draft?.corners, one.outline.draft?.zones], [SQUARE, [HOLE]]);
    const several = grounded({ "Outline Setup": { ...SET, Polygons: [SQUARE, HOLE] } }).operator;
    several.editOutline();
    assert.equal(several.outline.open, false);
    assert.match(cannotDraw(several.view(), several.outline.setup), /several polygons/);
  });

  it("of the last survey can be taken again, by the browser that knew it", async () => {
    const rig = grounded({ "Outline Setup": { ...SET, Polygons: [SQUARE, HOLE], Holes: [] } });
    const { outline } = rig.operator;
    assert.equal(outline.last, null, "it still is in force");
    rig.hear({ "Outline Setup": NONE });
    assert.deepEqual(outline.last, { Polygons: [SQUARE, HOLE], Holes: [] });
    void outline.takeLast();
    const { Type, Polygons, Holes } = rig.sent().at(-1)!;
    assert.deepEqual([Type, Polygons, Holes], ["Set Outline", [SQUARE, HOLE], []]);
    await rig.answer(true);
  });

  it("that was stored wrongly is no outline", () => {
    for (const stored of ["{", "null", "3", '{"Polygons":[],"Holes":[]}', '{"Polygons":[[{"Latitude":1}]],"Holes":[]}', '{"Polygons":[[1,2,3]]}']) {
      const rig = grounded();
      const { outline } = rig.operator;
      Object.assign(outline, { hooks: { storage: { getItem: () => stored, setItem: () => undefined } } });
      assert.equal(outline.last, null, stored);
    }
  });

  it("goes into a file of its own kind and comes back", () => {
    const { operator } = grounded();
    operator.editOutline();
    operator.outline.draw(SQUARE, undefined, [HOLE]);
    const text = operator.outline.export() ?? "";
    assert.match(text, /"name": "outline"/);
    assert.doesNotMatch(text, /ceiling/);
    operator.outline.draw([]);
    assert.equal(operator.outline.import(text), true);
    assert.deepEqual([operator.outline.draft?.corners.length, operator.outline.draft?.zones.length], [4, 1]);
    assert.equal(operator.outline.import("{}"), false);
    assert.match(operator.toasts.shown?.text ?? "", /Save the outline alone/);
    const fence = readFence(writeFence({ corners: SQUARE, zones: [], ceiling: 80 }));
    assert.equal(fence.ceiling, 80);
  });
});

describe("the words about the area to explore", () => {
  it("say what the next Explore surveys", () => {
    assert.equal(outlineSummary(null, "metres").line, "not known yet");
    assert.deepEqual(outlineSummary(NONE, "metres"), { title: "Explores the lot that it finds", line: "no outline is set" });
    assert.deepEqual(outlineSummary(SET, "metres"), { title: "Explores an outline of 0.96 ha", line: "1 polygon, 1 hole, set for this survey" });
    assert.match(outlineSummary({ ...SET, Source: "file" }, "feet").line, /from the settings/);
  });

  it("measure what is drawn less its holes, and find sides that cross", () => {
    assert.equal(Math.round(sizeOf({ corners: SQUARE, zones: [HOLE] }, PLANE) ?? 0), 9600);
    assert.equal(sizeOf({ corners: BOW_TIE, zones: [] }, PLANE), null);
    assert.equal(sizeOf({ corners: SQUARE, zones: [BOW_TIE] }, PLANE), null);
  });

  it("say why it cannot be drawn", () => {
    const able = heartbeat(ON_GROUND);
    assert.equal(cannotDraw(view({ heartbeat: able }), NONE), "");
    assert.equal(cannotDraw(view({ heartbeat: able }), null), "Not known yet");
    assert.equal(cannotDraw(view({ heartbeat: heartbeat({ Options: ABLE }) }), NONE), "On the ground only, with the motors off");
    const refused = heartbeat({ ...ON_GROUND, Options: [impossible("Set Outline", "A fence is being saved.")] });
    assert.equal(cannotDraw(view({ heartbeat: refused }), NONE), "A fence is being saved");
    assert.equal(cannotDraw(view({ heartbeat: heartbeat({ ...ON_GROUND, "In Control": false }) }), NONE), "Not in control");
  });
});

describe("the outline's parts of the page", () => {
  it("stand in the bar in place of the guided actions; Land and Hold stay", async () => {
    const rig = grounded();
    const stage = new Stage(new ActionBar(), rig.operator);
    rig.operator.editOutline();
    await stage.drawn();
    assert.equal(stage.has("[data-action=arm]"), false);
    assert.equal(stage.has(".safety .land") && stage.has(".safety .hold"), true);
    assert.match(words(stage.button("Set outline")), /Not closed yet/);
    rig.operator.outline.draw(BOW_TIE);
    await stage.drawn();
    assert.match(words(stage.find(".bad")), /sides cross/);
    assert.equal(stage.button("Set outline").disabled, true);
    rig.operator.outline.draw(SQUARE);
    await stage.drawn();
    assert.match(stage.text, /Outline of 1\.00 ha, 4 corners/);
    await stage.press("Set outline");
    assert.equal(rig.sent().at(-1)?.Type, "Set Outline");
    await rig.answer(true);
  });

  it("name what is cut out of it a hole", async () => {
    const rig = grounded();
    rig.operator.editOutline();
    rig.operator.outline.draw(SQUARE);
    const stage = new Stage(new FenceTools(), rig.operator);
    await stage.drawn();
    await stage.press("Add hole: a part that is not explored");
    assert.equal(rig.operator.outline.zoning, true);
    assert.equal(rig.operator.fence.zoning, false);
    await stage.press("Clear");
    assert.equal(rig.operator.outline.draft?.isDrawn, false);
  });

  it("offer in the settings to remove it, and after that to take the last one again", async () => {
    const options = possible("Set Outline", "Clear Outline");
    const rig = grounded({ "Outline Setup": SET, Options: options });
    const stage = new Stage(new OutlineButton(), rig.operator);
    await stage.drawn();
    assert.deepEqual(stage.enabled(), ["Remove the outline", "Edit outline"]);
    await stage.press("Remove the outline");
    assert.equal(rig.sent().at(-1)?.Type, "Clear Outline");
    await rig.answer(true);
    rig.hear({ "Outline Setup": NONE, Options: possible("Set Outline") });
    await stage.drawn();
    assert.deepEqual(stage.enabled(), ["Last outline: take it again", "Draw outline"]);
  });

  it("are not offered without control", async () => {
    const rig = grounded({ "Outline Setup": SET, "In Control": false, Options: possible("Set Outline", "Clear Outline") });
    const stage = new Stage(new OutlineButton(), rig.operator);
    await stage.drawn();
    assert.deepEqual(stage.enabled(), []);
    assert.match(stage.text, /Not in control/);
  });
});

describe("the outline on the map", () => {
  it("lies where its corners are on Earth", () => {
    const [outer, hole] = shownOutline(SET, PLANE);
    assert.deepEqual(outer?.map(({ North, East }) => [Math.round(North), Math.round(East)]), [[-50, -50], [50, -50], [50, 50], [-50, 50]]);
    assert.equal(hole?.length, 4);
    assert.deepEqual([shownOutline(null, PLANE), shownOutline(SET, null)], [[], []]);
  });

  it("is drawn with the fence's editor, and each goes into its own drawing", async () => {
    const { operator } = grounded({ Datum: [48, 11] });
    const shown: { ring: Ring; zones: readonly Ring[] }[] = [];
    let events: FenceEditorEvents | null = null;
    const editor = { removing: false, zone: () => undefined, measureIn: () => undefined, show: (ring: Ring, zones: readonly Ring[]) => shown.push({ ring, zones }) };
    const lot = { editFence: (_: unknown, given: FenceEditorEvents) => ((events = given), editor), leaveFence: () => (events = null), stay: () => undefined, bringInView: () => undefined, centre: { North: 0, East: 0 } };
    let come: (part: { FenceEditor: typeof FenceEditor }) => void = () => undefined;
    const onMap = new FenceOnMap(lot as unknown as LotMap, operator, () => new Promise((resolve) => (come = resolve)));
    operator.editOutline();
    onMap.update();
    assert.equal(events, null, "the editor is still read");
    come({ FenceEditor: Object as unknown as typeof FenceEditor });
    await settle();
    const drawn = (): FenceEditorEvents => events ?? assert.fail("no editor");
    drawn().drawn([[-20, -20], [20, -20], [20, 20]], []);
    assert.equal(operator.outline.draft?.isDrawn, true);
    assert.equal(operator.fence.draft === null, true);
    assert.equal(onMap.shown(), null, "the fence that counts stays");
    operator.outline.cancel();
    onMap.update();
    assert.equal(events, null);
    operator.editFence();
    onMap.update();
    drawn().drawn([[-20, -20], [20, -20], [20, 20]], []);
    assert.equal(operator.fence.draft?.isDrawn, true);
    assert.deepEqual([operator.outline.draft, shown.at(-1)?.ring], [null, []]);
  });
});
