import "./dom.ts";
import assert from "node:assert/strict";
import { afterEach, beforeEach, describe, it, mock } from "node:test";
import type { RecordingsOfSurvey } from "../src/api.ts";
import { AskedRecordings } from "../src/views/asked-recordings.ts";
import { inFrench } from "./french.ts";
import { words } from "./stage.ts";

const SURVEY = "00000000-0000-4000-8000-00000000000a";
const NONE: RecordingsOfSurvey = { survey: SURVEY, drone: "<b>Drone 1</b>", state: "none", stored: 0, bytes: null, problem: "" };

describe("recordings that a desk asks a drone for", () => {
  const before = globalThis.fetch;
  let answer: RecordingsOfSurvey;
  let sent: string[];
  let changes: number;
  let view: AskedRecordings;

  beforeEach(() => {
    mock.timers.enable({ apis: ["setTimeout"] });
    answer = NONE;
    sent = [];
    changes = 0;
    globalThis.fetch = (address, init) => {
      if (init?.method === "POST") {
        sent.push(`${address as string} ${init.body as string}`);
        answer = { ...NONE, state: "asked" };
      }
      return Promise.resolve(Response.json(answer));
    };
  });

  afterEach(() => {
    globalThis.fetch = before;
    view.remove();
    mock.timers.reset();
  });

  async function drawn(): Promise<string> {
    for (let k = 0; k < 6; k++) {
      await new Promise(setImmediate);
      await view.updateComplete;
    }
    return words(view);
  }

  async function shown(state: Partial<RecordingsOfSurvey>): Promise<string> {
    answer = { ...NONE, ...state };
    view = Object.assign(new AskedRecordings(), { survey: SURVEY });
    view.addEventListener("archive-changed", () => changes++);
    document.body.replaceChildren(view);
    return await drawn();
  }

  async function later(state: Partial<RecordingsOfSurvey>): Promise<string> {
    answer = { ...NONE, ...state };
    mock.timers.tick(5000);
    return await drawn();
  }

  it("are asked for, come, and can be watched when they are here", async () => {
    assert.equal(await shown({}), "Ask for the recording");
    view.querySelector("button")!.click();
    assert.match(await drawn(), /is asked for the recording[^]*Ask no more/);
    assert.deepEqual(sent, [`api/v1/surveys/${SURVEY}/recordings/ask {"asked":true}`]);
    assert.equal(view.querySelector("b"), null, "a name of a drone is text");
    assert.match(await later({ state: "coming", stored: 1_000_000, bytes: 4_000_000, problem: "The disk is full" }), /1(\.0)? MB of 4(\.0)? MB[^]*The disk is full/);
    assert.equal(changes, 0);
    assert.equal(await later({ state: "here", stored: 4_000_000, bytes: 4_000_000 }), "");
    assert.equal(changes, 1);
  });

  it("are said to be forbidden or gone, and may be asked for again", async () => {
    assert.match(await shown({ state: "never" }), /its settings forbid it \(collect\.recordings\)\. *Ask for the recording/);
    assert.match(await shown({ state: "gone" }), /has no recording of this survey\. *Ask for the recording/);
    await inFrench(async () => {
      assert.match(await shown({ state: "gone" }), /n’a aucun enregistrement de ce relevé\. *Demander l’enregistrement/);
    });
  });

  it("are asked of nobody where no drone sent the survey", async () => {
    assert.equal(await shown({ drone: null }), "");
  });
});
