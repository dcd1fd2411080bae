import "./dom.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { writeFence } from "../src/fence/geojson.ts";
import { LocalPlane } from "../src/fence/plane.ts";
import type { FenceSetup, Heartbeat } from "../src/protocol.ts";
import { ActionBar } from "../src/ui/action-bar.ts";
import { ChecksTab } from "../src/ui/checks-tab.ts";
import { FenceButton } from "../src/ui/fence-button.ts";
import { FenceTools } from "../src/ui/fence-tools.ts";
import { settle } from "./fakes.ts";
import { CIRCLE, impossible, possible } from "./make.ts";
import { flying, type Rig } from "./rig.ts";
import { Stage, words } from "./stage.ts";

const PLANE = new LocalPlane({ Latitude: 48, Longitude: 11 });
const SQUARE = [[-50, -50], [50, -50], [50, 50], [-50, 50]].map(([North, East]) => PLANE.toEarth({ North: North!, East: East! }));
const DRAWN: FenceSetup = { ...CIRCLE, Source: "drawn", Corners: SQUARE, Radius: null, Ceiling: 80 };
const ON_GROUND: Partial<Heartbeat> = {
  State: "Idle",
  Armed: false,
  Landed: "ON_GROUND",
  "Fence Setup": CIRCLE,
  Options: possible("Set Fence"),
};

function grounded(changes: Partial<Heartbeat> = {}): Rig {
  return flying({ ...ON_GROUND, ...changes });
}

async function checked(rig: Rig, changes: Record<string, unknown> = {}): Promise<void> {
  rig.timers.advance(200);
  const answer = { Type: "Fence Check", Id: rig.sent().at(-1)?.Id, Problem: "", Notes: [], Inner: SQUARE, "Inner Zones": [], "North South": 100, "East West": 100, Area: 10_000 };
  rig.server.last.say({ ...answer, ...changes });
  await settle();
}

describe("the fence editor's bar", () => {
  it("stands in place of the guided actions, Land and Hold stay, and goes when motors run", async () => {
    const rig = grounded();
    const stage = new Stage(new ActionBar(), rig.operator);
    await stage.drawn();
    assert.equal(stage.has("[data-action=arm]"), true);
    rig.operator.editFence();
    await stage.drawn();
    assert.equal(stage.has("[data-action=arm]"), false);
    assert.equal(stage.has(".safety .land") && stage.has(".safety .hold"), true);
    assert.match(stage.text, /Draw the fence/);
    assert.equal(stage.button("Save fence").disabled, true);
    assert.match(words(stage.button("Save fence")), /Not closed yet/);
    rig.hear({ State: "Arm", Armed: true });
    await stage.drawn();
    assert.equal(stage.has("hawk-fence-bar .fence"), false);
    assert.equal(stage.has("[data-action=arm]"), true);
  });

  it("says what the drone says, and saves only what it finds nothing against", async () => {
    const rig = grounded();
    const stage = new Stage(new ActionBar(), rig.operator);
    rig.operator.editFence();
    rig.operator.fence.draw(SQUARE);
    await checked(rig, { Problem: "Corners: the fence is too narrow: draw it wider." });
    await stage.drawn();
    assert.match(words(stage.find(".fence .bad")), /too narrow/);
    assert.equal(stage.button("Save fence").disabled, true);
    const ceiling = stage.input(".fence input");
    assert.equal(ceiling.value, "100");
    ceiling.value = "80,5";
    ceiling.dispatchEvent(new Event("input"));
    await checked(rig, { Notes: ["The drone stands 9 m outside the dotted line."] });
    await stage.drawn();
    assert.match(words(stage.find(".fence .warning")), /9 m outside/);
    await stage.press("Save fence");
    const { Type, Corners, Ceiling } = rig.sent().at(-1)!;
    assert.deepEqual([Type, Corners, Ceiling], ["Set Fence", SQUARE, 80.5]);
    await rig.answer(true);
    rig.hear({ "Fence Setup": DRAWN });
    await stage.drawn();
    assert.equal(stage.has("[data-action=arm]"), true);
    assert.deepEqual(rig.operator.toasts.shown, { level: "info", text: "The fence is saved. The next Arm uploads it." });
  });

  it("is cancelled without a word to the drone", async () => {
    const rig = grounded({ "Fence Setup": DRAWN });
    const stage = new Stage(new ActionBar(), rig.operator);
    rig.operator.editFence();
    rig.operator.fence.draw([]);
    await stage.drawn();
    await stage.press("Cancel");
    assert.equal(rig.operator.fence.open, false);
    assert.ok(rig.sent().every((command) => command.Type !== "Set Fence"));
  });
});

describe("the fence tools", () => {
  async function tools(): Promise<{ rig: Rig; stage: Stage<FenceTools>; asked: unknown[] }> {
    const rig = grounded();
    const stage = new Stage(new FenceTools(), rig.operator);
    const asked: unknown[] = [];
    stage.part.addEventListener("fence-tool", (event) => asked.push((event as CustomEvent).detail));
    rig.operator.editFence();
    await stage.drawn();
    return { rig, stage, asked };
  }

  it("offer what is possible at each step", async () => {
    const { rig, stage, asked } = await tools();
    assert.deepEqual(stage.enabled(), ["Square", "Import"]);
    rig.operator.fence.drawing(2);
    await stage.drawn();
    assert.deepEqual(stage.enabled(), ["Undo", "Clear", "Import"]);
    rig.operator.fence.drawing(3);
    await stage.drawn();
    await stage.press("Close the ring");
    await stage.press("Undo");
    rig.operator.fence.draw(SQUARE);
    await stage.drawn();
    assert.deepEqual(stage.enabled(), ["Undo", "Remove corners", "Add zone: an exclusion zone", "Clear", "Import", "Export"]);
    assert.deepEqual(asked, ["close", "back"]);
  });

  it("remove, clear and take back", async () => {
    const { rig, stage } = await tools();
    rig.operator.fence.draw(SQUARE);
    await stage.drawn();
    await stage.press("Remove corners");
    assert.equal(stage.button("Remove corners").getAttribute("aria-pressed"), "true");
    assert.equal(rig.operator.fence.removing, true);
    await stage.press("Clear");
    assert.deepEqual([rig.operator.fence.draft?.corners, rig.operator.fence.removing], [[], false]);
    await stage.press("Undo");
    assert.deepEqual(rig.operator.fence.draft?.corners, SQUARE);
  });

  it("read a file that was chosen, once, and refuse one that is too large", async () => {
    const { rig, stage } = await tools();
    const input = stage.input("input[type=file]");
    const choose = async (file: { size: number }): Promise<void> => {
      Object.defineProperty(input, "files", { value: [file], configurable: true });
      input.dispatchEvent(new Event("change"));
      await stage.drawn();
    };
    const text = writeFence({ corners: SQUARE, zones: [], ceiling: 70 });
    const sent: unknown[] = [];
    const answers = [
      () => Promise.resolve(new Response("The file must hold exactly one Polygon.", { status: 422 })),
      () => Promise.reject(new Error("no network")),
      () => Promise.resolve(new Response(text)),
    ];
    const before = globalThis.fetch;
    globalThis.fetch = (address, options) => {
      sent.push(address, options?.method, options?.body);
      return (answers.shift() ?? answers[0])!();
    };
    const said = (): string => rig.operator.toasts.shown?.text ?? "";
    try {
      await choose({ size: 5_000_000 });
      assert.match(said(), /too large/);
      assert.deepEqual(sent, []);
      const file = { size: 900 };
      for (const words of [/exactly one Polygon/, /did not answer/]) {
        await choose(file);
        await settle();
        assert.match(said(), words);
        assert.deepEqual(rig.operator.fence.draft?.corners, []);
      }
      await choose(file);
      await settle();
      assert.deepEqual(sent.slice(0, 3), ["api/area-file?kind=fence", "POST", file]);
    } finally {
      globalThis.fetch = before;
    }
    const draft = rig.operator.fence.draft;
    assert.deepEqual([draft?.corners.length, draft?.ceiling], [4, "70"]);
  });
});

describe("the button that opens the fence editor", () => {
  it("names the fence that counts, and opens the editor", async () => {
    const rig = grounded();
    const stage = new Stage(new FenceButton(), rig.operator);
    const opened: unknown[] = [];
    stage.part.addEventListener("open-panel", (event) => opened.push((event as CustomEvent).detail));
    await stage.drawn();
    assert.match(stage.text, /Fence: circle of 150 m around where it is armed, up to 100 m/);
    assert.deepEqual(stage.enabled(), ["Edit fence"]);
    await stage.press("Edit fence");
    assert.deepEqual(opened, ["fence"]);
  });

  it("is closed in the air, without control, and before the fence is known, and says why", async () => {
    for (const [changes, why] of [
      [{ State: "Hover", Options: [impossible("Set Fence", "Flying: land first.")] }, "Flying: land first"],
      [{ "In Control": false }, "Not in control"],
      [{ "Fence Setup": null }, "Not known yet"],
    ] as [Partial<Heartbeat>, string][]) {
      const stage = new Stage(new FenceButton(), grounded(changes).operator);
      await stage.drawn();
      assert.equal(stage.button("Edit fence").disabled, true);
      assert.match(words(stage.button("Edit fence")), new RegExp(why));
    }
  });

  it("sets a drawn fence aside", async () => {
    const rig = grounded({ "Fence Setup": DRAWN, Options: possible("Set Fence", "Clear Fence") });
    const stage = new Stage(new FenceButton(), rig.operator);
    await stage.drawn();
    await stage.press("Set aside the drawn fence");
    assert.equal(rig.sent().at(-1)?.Type, "Clear Fence");
  });

  it("is the remedy of a fence that the drone stands outside of", async () => {
    const outside = {
      Name: "Fence",
      Passed: false,
      Value: "110 × 110 m, drone 9 m outside",
      Consequence: "It could not fly anywhere.",
      Remedy: "Put the drone inside the fence, or draw another one.",
      "Remedy Command": "Set Fence" as const,
    };
    const rig = grounded({ Checks: [outside] });
    const stage = new Stage(new ChecksTab(), rig.operator);
    const opened: unknown[] = [];
    stage.part.addEventListener("open-panel", (event) => opened.push((event as CustomEvent).detail));
    await stage.drawn();
    await stage.press("Draw the fence");
    assert.deepEqual(opened, ["fence"]);
    assert.deepEqual(rig.sent(), []);
  });
});
