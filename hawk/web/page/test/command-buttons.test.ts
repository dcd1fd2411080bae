import "./dom.ts";
import assert from "node:assert/strict";
import { afterEach, beforeEach, describe, it } from "node:test";
import type { LitElement } from "lit";
import { COMMAND_TABLE, type CommandButton, type SentBy } from "../src/command-table.ts";
import { LocalPlane } from "../src/fence/plane.ts";
import type { CheckItem, Heartbeat } from "../src/protocol.ts";
import type { Operator } from "../src/state/operator.ts";
import { CELL } from "../src/state/tile-data.ts";
import { ActionBar } from "../src/ui/action-bar.ts";
import { ChecksTab } from "../src/ui/checks-tab.ts";
import { ControlNotePart } from "../src/ui/control-note.ts";
import { EarlierSurvey } from "../src/ui/earlier-survey.ts";
import { FenceButton } from "../src/ui/fence-button.ts";
import { GlanceLine } from "../src/ui/glance-line.ts";
import { HeightsButton } from "../src/ui/heights-button.ts";
import { KillDialog } from "../src/ui/kill-dialog.ts";
import { LotsList } from "../src/ui/lots.ts";
import { OutlineButton } from "../src/ui/outline-button.ts";
import { OwnName } from "../src/ui/own-name.ts";
import { say } from "../src/words/say.ts";
import { answer, list } from "./api.ts";
import { settle } from "./fakes.ts";
import { CIRCLE, mapUpdate, possible, stall } from "./make.ts";
import { flying, type Rig, type Sent } from "./rig.ts";
import { Frames, Stage } from "./stage.ts";

type WithButton = SentBy<CommandButton>;
type Part = LitElement & { model: Operator };

/** Where a button is, and what a person does before it can be pressed, and after that. */
interface Scene {
  part?: () => Part;
  drone?: Partial<Heartbeat>;
  before?: (rig: Rig, stage: Stage<Part>) => unknown;
  after?: (rig: Rig, stage: Stage<Part>) => unknown;
  /** In place of a click. */
  press?: (rig: Rig, stage: Stage<Part>) => unknown;
}

const PLANE = new LocalPlane({ Latitude: 48, Longitude: 11 });
const SQUARE = ([[-50, -50], [50, -50], [50, 50], [-50, 50]] as const).map(([North, East]) => PLANE.toEarth({ North, East }));
const NO_OUTLINE = { Source: "none" as const, Polygons: [], Holes: [], Area: 0, Again: [] };
const GROUND: Partial<Heartbeat> = { State: "Idle", Armed: false, Landed: "ON_GROUND", "Fence Setup": CIRCLE, "Outline Setup": NO_OUTLINE };
const MANUAL: Partial<Heartbeat> = { State: "Manual" };

function bar(): Part {
  return Object.assign(new ActionBar(), { classAt: () => CELL.lot });
}

function failing(remedy: CheckItem["Remedy Command"]): Partial<Heartbeat> {
  return { ...GROUND, Checks: [{ Name: "A check", Passed: false, Value: "", Consequence: "", Remedy: "", "Remedy Command": remedy }] };
}

function typeHeights(_: Rig, stage: Stage<Part>): void {
  for (const field of ["Min", "Des", "Max"]) stage.input(`input[name=${field}]`).dispatchEvent(new Event("input"));
  stage.find("form").dispatchEvent(new Event("submit", { cancelable: true }));
}

async function drawFence(rig: Rig): Promise<void> {
  rig.operator.editFence();
  rig.operator.fence.draw(SQUARE);
  rig.timers.advance(200);
  const found = { Problem: "", Notes: [], Inner: SQUARE, "Inner Zones": [], "North South": 100, "East West": 100, Area: 10_000 };
  rig.server.last.say({ Type: "Fence Check", Id: rig.sent().at(-1)?.Id, ...found });
  await settle();
}

async function pointAtPlace(rig: Rig, kind: "Autonomous Move" | "Compulsive Move"): Promise<void> {
  rig.operator.pointAt({ North: 20, East: 0 }, false);
  const points = [{ North: 0, East: 0 }, { North: 20, East: 0 }];
  rig.server.last.say({ Type: "Route", Id: rig.sent().at(-1)?.Id, Points: points, Length: 20, Refused: null });
  await settle();
  rig.operator.choose(kind);
}

async function askToken(rig: Rig): Promise<void> {
  void rig.operator.cut.begin();
  rig.server.last.say({ Type: "Kill Token", Id: rig.sent().at(-1)?.Id, Token: "secret", "Valid For": 10 });
  await settle();
}

function keepPressed(_: Rig, stage: Stage<Part>): void {
  const frames = new Frames();
  stage.button(say("cut-press")).dispatchEvent(new PointerEvent("pointerdown", { button: 0, bubbles: true }));
  frames.advance(1100);
}

/** Each command that a button of the page sends. */
const SCENES: Record<WithButton, Scene> = {
  Configure: { part: () => new HeightsButton(), drone: GROUND, after: typeHeights },
  Arm: { drone: GROUND },
  Takeoff: { drone: { ...GROUND, State: "Arm", Armed: true } },
  "Autonomous Explore": {},
  "Autonomous Move": { after: (rig) => pointAtPlace(rig, "Autonomous Move") },
  "Compulsive Move": { after: (rig) => pointAtPlace(rig, "Compulsive Move") },
  Hold: {},
  "Return To Launch": { drone: MANUAL },
  Land: { drone: MANUAL },
  Disarm: { drone: { ...GROUND, State: "Arm", Armed: true } },
  Resume: { drone: MANUAL },
  "Kill Request": { part: () => new GlanceLine() },
  Kill: { part: () => new KillDialog(), before: askToken, press: keepPressed },
  "Clear Kill": { part: () => new ChecksTab(), drone: failing("Clear Kill") },
  "Set Failsafes": { part: () => new ChecksTab(), drone: failing("Set Failsafes") },
  "Set Fence": { drone: GROUND, before: drawFence },
  "Clear Fence": { part: () => new FenceButton(), drone: GROUND },
  "Set Outline": {
    drone: GROUND,
    before: ({ operator }) => {
      operator.editOutline();
      operator.outline.draw(SQUARE);
    },
  },
  "Clear Outline": { part: () => new OutlineButton(), drone: { ...GROUND, "Outline Setup": { ...NO_OUTLINE, Source: "set", Polygons: [SQUARE] } } },
  "Survey Again": {
    part: () => new LotsList(),
    drone: GROUND,
    press: async (_, stage) => {
      await settle();
      await stage.drawn();
      await stage.press(say("survey-again-of", { name: "South" }));
    },
  },
  "Fly Plan": {
    part: () => new ControlNotePart(),
    drone: { "Plan Offer": { Plan: "lot-2-7", Lot: "South", By: "Ben", Stalls: 50, Before: 40 } },
  },
  "New Survey": { part: () => new EarlierSurvey(), drone: { ...GROUND, "Occupancy Map": mapUpdate({ Stalls: [stall(1)] }), Free: 1 } },
  Name: { part: () => new OwnName(), before: (_, stage) => (stage.input("input").value = "Anna") },
  Control: { drone: { "In Control": false, Controller: null } },
};

/** The last command of a type that was sent. */
function last(rig: Rig, type: string): Sent | undefined {
  return rig.sent().findLast((each) => each.Type === type);
}

async function onStage(part: Part, operator: Operator): Promise<Stage<Part>> {
  const stage = new Stage(part, operator);
  await stage.drawn();
  return stage;
}

const LISTED = { lots: list({ id: "a", name: "South", time_zone: "UTC", stalls: 4, survey_count: 1, last_survey: null }), surveys: list(), changes: list() };

describe("the buttons of the table of commands", () => {
  const before = globalThis.fetch;
  beforeEach(() => {
    globalThis.fetch = (address) => Promise.resolve(answer(address as string, LISTED));
  });
  afterEach(() => {
    globalThis.fetch = before;
  });

  for (const [type, scene] of Object.entries(SCENES) as [WithButton, Scene][]) {
    const { button, confirm } = COMMAND_TABLE[type];
    it(`${say(button)} sends ${type}, ${confirm === "never" ? "at once" : `confirmed: ${confirm}`}`, async () => {
      const rig = flying({ Options: possible(type, "Hold"), ...scene.drone });
      let stage = await onStage((scene.part ?? bar)(), rig.operator);
      await scene.before?.(rig, stage);
      await stage.drawn();
      if (scene.press) await scene.press(rig, stage);
      else await stage.press(say(button));
      if (confirm === "slide" || confirm === "overruling") {
        assert.equal(last(rig, type), undefined, "not before it is confirmed");
        await scene.after?.(rig, stage);
        stage = await onStage(bar(), rig.operator);
        stage.find("hawk-slide").dispatchEvent(new Event("confirmed"));
      } else await scene.after?.(rig, stage);
      await stage.drawn();
      const sent = last(rig, type);
      assert.ok(sent, JSON.stringify(rig.sent()));
      assert.equal(sent.Confirmed, confirm === "overruling" ? true : undefined);
    });
  }

  it("are asked about by a slide where a pilot would be overruled, and else pressed once", async () => {
    for (const type of ["Return To Launch", "Land"] as const) {
      const rig = flying({ Options: possible(type) });
      const stage = await onStage(bar(), rig.operator);
      await stage.press(say(COMMAND_TABLE[type].button));
      assert.deepEqual(rig.sent().map(({ Type, Confirmed }) => [Type, Confirmed]), [[type, undefined]]);
    }
  });
});
