import "./dom.ts";
import "./no-drawing.ts";
import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { describe, it } from "node:test";
import ts from "typescript";
import type { LitElement } from "lit";
import type { Heartbeat } from "../src/protocol.ts";
import type { Operator } from "../src/state/operator.ts";
import type { PlanEditing } from "../src/state/plan-edit.ts";
import { STANDARD } from "../src/state/preferences.ts";
import { ActionBar } from "../src/ui/action-bar.ts";
import { AllSettings } from "../src/ui/all-settings.ts";
import { BatteryBar } from "../src/ui/battery-bar.ts";
import { ChecksTab } from "../src/ui/checks-tab.ts";
import { ControlNotePart } from "../src/ui/control-note.ts";
import { CountsCard } from "../src/ui/counts-card.ts";
import { Downloads } from "../src/ui/downloads.ts";
import { EarlierSurvey } from "../src/ui/earlier-survey.ts";
import { FenceTools } from "../src/ui/fence-tools.ts";
import { GlanceLine } from "../src/ui/glance-line.ts";
import { HeightsButton } from "../src/ui/heights-button.ts";
import { KeysList } from "../src/ui/keys-list.ts";
import { KillDialog } from "../src/ui/kill-dialog.ts";
import { LinkBanner } from "../src/ui/link-banner.ts";
import { MapTools } from "../src/ui/map-tools.ts";
import { MeasureBar } from "../src/ui/measure-bar.ts";
import { MessagesTab } from "../src/ui/messages-tab.ts";
import { MoreActions } from "../src/ui/more-actions.ts";
import { PlanPanel } from "../src/ui/plan-panel.ts";
import { PlanTools } from "../src/ui/plan-tools.ts";
import { OwnName } from "../src/ui/own-name.ts";
import { SettingsTab } from "../src/ui/settings-tab.ts";
import { StallCard } from "../src/ui/stall-card.ts";
import { StallsTab } from "../src/ui/stalls-tab.ts";
import { say } from "../src/words/say.ts";
import { FakeServer, settle } from "./fakes.ts";
import { inFrench } from "./french.ts";
import { CIRCLE, impossible, mapUpdate, possible, stall, welcome } from "./make.ts";
import { PlanStore } from "./plan-store.ts";
import { flying, type Rig } from "./rig.ts";
import { EnglishWords, spoken } from "./spoken.ts";
import { Stage } from "./stage.ts";

const SETTING = { Section: "Drone says fence", Key: "Drone says radius", Text: "Drone says its radius.", Unit: "m", Value: 150, Default: 120, Lowest: 10, Highest: 500 };

const PLAN = new PlanStore(["A 1", "A 2"]);
const anything = (): Promise<Response> => Promise.resolve(new Response(JSON.stringify({ Settings: [SETTING] })));
Object.assign(globalThis, {
  fetch: (address: string, options?: RequestInit) => (address.startsWith("api/v1/") ? PLAN.fetch(address, options) : anything()),
});
const { FlightTab } = await import("../src/ui/flight-tab.ts");
const { SurveyPanel } = await import("../src/ui/survey-panel.ts");
const { VideoPanel } = await import("../src/ui/video-panel.ts");

/** Sentences of the drone's program begin so, in every test of this file. */
const DRONE = "Drone says";
const ON_GROUND: Partial<Heartbeat> = { State: "Idle", Armed: false, Landed: "ON_GROUND", "Relative Altitude": 0, "Fence Setup": CIRCLE };
const ALL = ["Arm", "Disarm", "Takeoff", "Autonomous Explore", "Autonomous Move", "Compulsive Move", "Return To Launch", "Land", "Hold", "Resume", "Set Fence", "Set Outline", "Clear Fence", "Clear Outline", "Configure", "New Survey", "Kill"];
const REFUSED = ALL.map((command, index) => impossible(command, `${DRONE} no, for reason ${index}.`));
const CHECK = { Name: `${DRONE} GPS`, Passed: false, Value: `${DRONE} 3 of 10`, Consequence: `${DRONE} it stays.`, Remedy: `${DRONE} wait.`, "Remedy Command": null };
const SURVEYED: Partial<Heartbeat> = {
  Free: 3,
  Taken: 2,
  Unknown: 1,
  Explored: 0.47,
  "Free Range": [2, 6],
  "Lot Area": 12_300,
  "Occupancy Map": mapUpdate({ Stalls: [stall(1), stall(2, { State: "taken", Seen: 0 }), stall(3, { State: "unknown", Taken: 0.4, North: -9 })] }),
};

const ENGLISH = new EnglishWords("fr");

type View = LitElement & { model: Operator };
type Case = [name: string, part: () => View, rig: () => Rig | Promise<Rig>];

function asked(changes: Partial<Heartbeat>, ask: (operator: Operator) => unknown): () => Promise<Rig> {
  return async () => {
    const rig = flying({ Options: possible(...ALL), ...changes });
    await ask(rig.operator);
    return rig;
  };
}

async function refused(rig: Rig, ask: () => unknown): Promise<Rig> {
  const done = ask();
  await rig.answer(false, `${DRONE} no.`);
  await done;
  return rig;
}

function lost(changes: Partial<Heartbeat>, silence = 6000): () => Rig {
  return () => {
    const rig = flying(changes);
    rig.server.last.break();
    rig.timers.advance(silence);
    rig.operator.tick();
    return rig;
  };
}

function drawing(open: (operator: Operator) => void, ...more: ((operator: Operator) => void)[]): () => Promise<Rig> {
  const setup = { Source: "none" as const, Polygons: [], Holes: [], Area: 0, Again: [] };
  return asked({ ...ON_GROUND, "Outline Setup": setup }, (operator) => [open, ...more].forEach((each) => each(operator)));
}

/** The editor of a plan, in which somebody has chosen or drawn something. */
function planned(use: (plan: PlanEditing) => void, editor = "Anna"): () => Promise<Rig> {
  return async () => {
    const rig = flying();
    PLAN.take(editor);
    rig.operator.prefer({ name: "Anna" });
    await rig.operator.plan.begin("lot");
    use(rig.operator.plan);
    return rig;
  };
}

const QUESTIONS = ["Arm", "Takeoff", "Autonomous Explore", "Return To Launch", "Land", "Resume", "New Survey"] as const;
const HOME = { North: 20, East: 30 };
const WATCHING: Partial<Heartbeat> = { "In Control": false, Controller: "Ana" };
const NOT_MINE: Partial<Heartbeat> = { ...WATCHING, "Own Name": "Ben", "Control Asked By": "Ben" };

const CASES: Case[] = [
  ["the bar in flight", () => new ActionBar(), () => flying({ Options: possible(...ALL) })],
  ["the bar while it explores", () => new ActionBar(), () => flying({ State: "Autonomous Explore", Explored: 0.47, Options: possible("Hold") })],
  ["the bar where nothing is possible", () => new ActionBar(), () => flying({ Options: REFUSED })],
  ["the bar on the ground", () => new ActionBar(), () => flying({ ...ON_GROUND, Checks: [CHECK], Options: REFUSED })],
  ["the bar without a link", () => new ActionBar(), lost({})],
  ["the bar without control", () => new ActionBar(), () => flying(WATCHING)],
  ["the bar of one who lost control", () => new ActionBar(), () => flying({ ...WATCHING, "Control Taken By": "Ana" })],
  ["the bar when nobody has control", () => new ActionBar(), () => flying({ "In Control": false, Controller: null, Options: REFUSED })],
  ["the bar when the operator is lost", () => new ActionBar(), () => flying({ ...WATCHING, "Controller Lost": true })],
  ["the bar of a viewer", () => new ActionBar(), () => {
    const rig = flying();
    rig.server.last.say(welcome({ Role: "viewer" }));
    return rig;
  }],
  ...QUESTIONS.map((about): Case => [`the question ${about}`, () => new ActionBar(), asked({ State: "Manual" }, (operator) => operator.ask({ about }))]),
  ["a question that is refused", () => new ActionBar(), async () => {
    const rig = flying({ Options: REFUSED });
    rig.operator.ask({ about: "Arm" });
    return Promise.resolve(rig);
  }],
  ["the question of a move", () => new ActionBar(), asked({}, (operator) => operator.ask({ about: "move", target: HOME }))],
  ["the question of a move without a route", () => new ActionBar(), async () => {
    const rig = flying({ Options: possible(...ALL) });
    rig.operator.ask({ about: "move", target: HOME });
    rig.server.last.say({ Type: "Route", Id: rig.sent().at(-1)?.Id, Points: [], Length: null, Refused: `X, Y: ${DRONE} there is no path.` });
    await settle();
    rig.operator.choose("Autonomous Move");
    return rig;
  }],
  ["the question of another look", () => new ActionBar(), asked(SURVEYED, (operator) => operator.ask({ about: "move", target: HOME, stall: 2 }))],
  ["the fence's bar", () => new ActionBar(), drawing((operator) => operator.editFence())],
  ["the outline's bar", () => new ActionBar(), drawing((operator) => operator.editOutline())],
  ["the fence's tools", () => new FenceTools(), drawing((operator) => operator.editFence(), (operator) => operator.fence.drawing(2))],
  ["the outline's tools", () => new FenceTools(), drawing((operator) => operator.editOutline())],
  ["the line at the top", () => new GlanceLine(), () => flying({ ...SURVEYED, Detail: `${DRONE} it stays.` })],
  ["the line at the top while it explores", () => new GlanceLine(), () => flying({ ...SURVEYED, State: "Autonomous Explore", Remaining: 400 })],
  ["the line at the top with failed checks", () => new GlanceLine(), () => flying({ ...ON_GROUND, Checks: [CHECK, CHECK] })],
  ["the line at the top without a link", () => new GlanceLine(), lost({ State: "Return To Launch", Free: 3 })],
  ["the line at the top with old values", () => new GlanceLine(), () => flying({ "Pose Age": 5, "Battery Age": 9, "Link Age": 5, Detail: `${DRONE} it stays.` })],
  ["the banner in flight", () => new LinkBanner(), lost({ State: "Autonomous Explore" })],
  ["the banner after the return", () => new LinkBanner(), lost({ State: "Autonomous Explore" }, 60_000)],
  ["the banner of a landing", () => new LinkBanner(), lost({ State: "Land" })],
  ["the banner of a silent autopilot", () => new LinkBanner(), () => flying({ Connected: false })],
  ["the banner of a lost operator", () => new LinkBanner(), () => flying({ State: "CommunicationLost", "Return In": 12, ...WATCHING })],
  ["the banner of an unconfirmed cut", () => new LinkBanner(), () => flying({ "Kill State": "not confirmed" })],
  ["who is asked for control", () => new ControlNotePart(), () => flying({ "Control Asked By": "Ben", "Control Free In": 9 })],
  ["who asks for control", () => new ControlNotePart(), () => flying({ ...NOT_MINE, "Control Free In": 9 })],
  ["who may take control", () => new ControlNotePart(), () => flying({ ...NOT_MINE, "Control Free In": 0 })],
  ["who gives control back", () => new ControlNotePart(), asked({}, (operator) => operator.releaseControl())],
  ["the earlier survey", () => new EarlierSurvey(), () => flying({ ...ON_GROUND, ...SURVEYED, Options: possible("New Survey") })],
  ["the counts", () => new CountsCard(), () => flying({ ...ON_GROUND, ...SURVEYED })],
  ["the counts without a link", () => new CountsCard(), lost({ ...SURVEYED })],
  ["the battery", () => new BatteryBar(), () => flying({ "Battery Left": -10, "Battery Needed Survey": 80, "Survey Share": 0.6, "Battery Age": 9 })],
  ["the checks", () => new ChecksTab(), () => flying({ ...ON_GROUND, Checks: [CHECK, { ...CHECK, "Remedy Command": "Set Failsafes" }, { ...CHECK, Passed: true }], Options: REFUSED })],
  ["the downloads", () => new Downloads(), () => flying(ON_GROUND)],
  ["the heights", () => new HeightsButton(), () => flying({ Options: REFUSED })],
  ["the keys", () => new KeysList(), () => flying()],
  ["cutting the motors", () => new KillDialog(), asked({}, (operator) => void operator.cut.begin())],
  ["cutting the motors, refused", () => new KillDialog(), () => {
    const rig = flying();
    return refused(rig, () => rig.operator.cut.begin());
  }],
  ["the map's tools", () => new MapTools(), () => flying()],
  ["measuring", () => new MeasureBar(), asked({}, (operator) => {
    operator.beginMeasure();
    for (const [North, East] of [[0, 0], [0, 9], [9, 9]] as const) operator.measure.add({ North, East }, 1);
  })],
  ["the messages", () => new MessagesTab(), () => {
    const line = { Number: 1, Time: "2026-01-02T03:04:05Z", Level: "warning" as const, Text: `${DRONE} wind.`, Details: `${DRONE} details.` };
    const rig = flying({ Messages: [line] });
    return refused(rig, () => rig.operator.command({ Type: "Land" }, "Atterrir"));
  }],
  ["the messages before any", () => new MessagesTab(), () => flying()],
  ["the own name", () => Object.assign(new OwnName(), { asks: true }), () => flying(ON_GROUND)],
  ["the settings", () => new SettingsTab(), () => {
    const rig = flying({ ...ON_GROUND, "Fence Setup": { ...CIRCLE, Problem: `${DRONE} it crosses.` }, Options: REFUSED });
    rig.server.last.say(welcome({ Login: true }));
    return rig;
  }],
  ["the settings of one who watches", () => new SettingsTab(), () => flying({ ...WATCHING, Options: REFUSED })],
  ["all actions", () => new MoreActions(), () => flying({ Options: REFUSED })],
  ["the flight", () => new FlightTab(), () => flying({ Health: ["camera", "vision"].map((Name, index) => ({ Name, Healthy: index > 0, Reason: `${DRONE} none.` })) })],
  ["the survey after landing", () => new SurveyPanel(), () => flying({ ...ON_GROUND, ...SURVEYED, "Explore Done": true, "Flight Time": 312, "Distance Flown": 1830 })],
  ["the live picture", () => Object.assign(new VideoPanel(), { open: new FakeServer().open }), () => flying()],
  ["the live picture without a camera", () => Object.assign(new VideoPanel(), { open: new FakeServer().open }), () => flying({ Health: [{ Name: "camera", Healthy: false, Reason: `${DRONE} none.` }] })],
  ["a stall", () => Object.assign(new StallCard(), { chosen: 1 }), () => flying({ ...SURVEYED, Options: REFUSED })],
  ["a plan", () => new PlanPanel(), planned(() => undefined)],
  ["a plan that another person edits", () => new PlanPanel(), planned(() => undefined, "Ben")],
  ["a plan with a chosen stall", () => new PlanPanel(), planned((plan) => plan.choose(["A 1"]))],
  ["a plan with chosen stalls", () => new PlanPanel(), planned((plan) => plan.chooseRow("A"))],
  ["a plan with a row", () => new PlanPanel(), planned(({ drawing }) => {
    drawing.use("row");
    drawing.set({ style: "angled" });
    for (const place of [[-9, 0], [-9, 9], [-14, 0]] as const) drawing.add(place);
  })],
  ["a plan with a stall", () => new PlanPanel(), planned(({ drawing }) => drawing.use("stall"))],
  ["a plan with an area", () => new PlanPanel(), planned(({ drawing }) => drawing.use("area"))],
  ["the plan's tools", () => new PlanTools(), planned(() => undefined)],
  ["the stalls", () => new StallsTab(), () => flying(SURVEYED)],
];

describe("in French", () => {
  for (const [name, part, rig] of CASES) {
    it(`speaks no English, and marks the drone's words: ${name}`, () =>
      inFrench(async () => {
        const stage = new Stage(part(), (await rig()).operator);
        await stage.drawn();
        const said = spoken(stage.part);
        assert.ok(said.length > 0, "nothing is said");
        for (const { text, isEnglish } of said) {
          if (isEnglish) assert.ok(text.includes(DRONE) || text === "English", text);
          else assert.deepEqual(ENGLISH.in(text.replaceAll(DRONE, "")), [], text);
        }
        for (const element of stage.part.querySelectorAll("*")) {
          const own = [...element.childNodes].filter((node) => node.nodeType === 3).map((node) => node.textContent ?? "").join("");
          if (own.includes(DRONE)) assert.equal(element.closest("[lang]")?.getAttribute("lang"), "en", own);
        }
      }));
  }

  it("speaks no English, and marks the drone's words: all settings", () =>
    inFrench(async () => {
      const stage = new Stage(new AllSettings(), flying().operator);
      await stage.drawn();
      const details = stage.find("details") as HTMLDetailsElement;
      details.open = true;
      details.dispatchEvent(new Event("toggle"));
      await stage.drawn();
      const said = spoken(stage.part);
      const drone = said.filter(({ text }) => text.includes(DRONE));
      assert.deepEqual(drone.map(({ text, isEnglish }) => [text, isEnglish]), [SETTING.Section, SETTING.Key, SETTING.Text].map((text) => [text, true]));
      assert.deepEqual(said.filter((each) => !drone.includes(each)).flatMap(({ text }) => ENGLISH.in(text)), []);
      assert.match(stage.text, /150 m modifié.*de 10 à 500 m/);
    }));

  it("would find English: the same views in English are full of it", async () => {
    for (const [name, part, rig] of CASES) {
      const stage = new Stage(part(), (await rig()).operator);
      await stage.drawn();
      const found = spoken(stage.part).filter(({ text }) => ENGLISH.in(text).length > 0);
      assert.ok(found.length > 0, name);
      assert.equal(stage.part.querySelectorAll("[lang=en] [lang], span[lang]").length, 0, "nothing is marked in English");
    }
  });

  it("says every drawn view again when the language changes", async () => {
    const rig = flying({ Options: possible(...ALL) });
    const stage = new Stage(new ActionBar(), rig.operator);
    await stage.drawn();
    assert.match(stage.text, /Return home/);
    await inFrench(async () => {
      rig.operator.drawAgain();
      await stage.drawn();
      assert.match(stage.text, /Retour au départ/);
      assert.doesNotMatch(stage.text, /Return home/);
    });
  });

  it("offers the languages in their own names, and keeps the choice", async () => {
    const rig = flying();
    const stage = new Stage(new SettingsTab(), rig.operator);
    await stage.drawn();
    const labels = [...stage.part.querySelectorAll("hawk-language label")];
    assert.deepEqual(labels.map((label) => [label.textContent.trim(), label.getAttribute("lang")]), [["As this browser", null], ["English", "en"], ["Français", "fr"]]);
    labels[2]?.querySelector("input")?.dispatchEvent(new Event("change"));
    assert.deepEqual(rig.operator.preferences, { ...STANDARD, language: "fr" });
  });
});

describe("a name that is read aloud", () => {
  const NAMED = [
    ["tool-remove", "tool-remove-aloud"],
    ["close", "close-ring"],
    ["tool-zone", "tool-zone-aloud"],
    ["tool-hole", "tool-hole-aloud"],
    ["set-aside", "set-aside-label"],
    ["last-outline", "last-outline-label"],
    ["remove", "remove-outline"],
    ["plan-tool-area", "plan-tool-area-aloud"],
    ["plan-set", "plan-set-size"],
  ] as const;

  it("begins with the words on the button, for those who speak to their computer", () =>
    inFrench(() => {
      for (const [shown, aloud] of NAMED) assert.ok(say(aloud).startsWith(say(shown)), say(aloud));
    }));
});

describe("the sources", () => {
  const folder = fileURLToPath(new URL("../src/", import.meta.url));
  const files = readdirSync(folder, { recursive: true, encoding: "utf8" }).filter((file) => file.endsWith(".ts") && !/messages|protocol/.test(file));

  /** Texts of every template and every string of a file. */
  function texts(file: string): { templates: string[]; strings: string[] } {
    const found = { templates: [] as string[], strings: [] as string[] };
    const look = (node: ts.Node): void => {
      if (ts.isTaggedTemplateExpression(node) && node.tag.getText() === "html") found.templates.push(textOf(node.template));
      if (ts.isStringLiteral(node) || ts.isNoSubstitutionTemplateLiteral(node)) found.strings.push(node.text);
      if (ts.isTemplateExpression(node) && !ts.isTaggedTemplateExpression(node.parent)) found.strings.push(textOf(node));
      ts.forEachChild(node, look);
    };
    look(ts.createSourceFile(file, readFileSync(folder + file, "utf8"), ts.ScriptTarget.Latest, true));
    return found;
  }

  function textOf(template: ts.TemplateLiteral): string {
    if (ts.isNoSubstitutionTemplateLiteral(template)) return template.text;
    return [template.head.text, ...template.templateSpans.map(({ literal }) => literal.text)].join("\u0001");
  }

  it("hold no words in their templates: those are in the files of messages", () => {
    for (const file of files) {
      for (const template of texts(file).templates) {
        const shown = template.replace(/<[^>]*>/g, "\u0001").split("\u0001").filter((text) => /\p{L}{2}/u.test(text));
        assert.deepEqual(shown.filter((text) => text.trim() !== "Parking Lot Hawk"), [], file);
        assert.doesNotMatch(template, /(aria-label|aria-description|title|placeholder)="[^"\u0001]/, file);
      }
    }
  });

  it("hold no sentences", () => {
    const remedies = new Set(["Set failsafes.", "Allow arming again.", "Draw the fence."]); // the drone's own
    for (const file of files) {
      const sentences = texts(file).strings.filter((text) => /^[A-Z][a-z]+,? ([a-z]+|\u0001)\b.*[a-z]/.test(text) && !remedies.has(text));
      assert.deepEqual(sentences, [], file);
    }
  });
});
