import "./dom.ts";
import assert from "node:assert/strict";
import { afterEach, beforeEach, describe, it } from "node:test";
import type { PlanView } from "../src/views/plan-view.ts";
import { Replay } from "../src/replay/app.ts";
import { clockOf, type Event, lastAt, type Line, stateAt } from "../src/replay/line.ts";
import { settle } from "./fakes.ts";
import { words } from "./stage.ts";

const HTML = "<b onclick='alert(1)'>Armed</b>";
const EVENTS: Event[] = [
  { at: 1, kind: "command", text: "Arm", level: "info" },
  { at: 1, kind: "state", text: "Takeoff", level: "info" },
  { at: 2, kind: "message", text: HTML, level: "ok" },
  { at: 8, kind: "state", text: "Hover", level: "info" },
];
const LINE: Line = {
  name: "20260504T103000Z.mcap",
  utc: "2026-05-04T10:30:00Z",
  maker: "hawk-drone 0.3.0",
  damage: "",
  seconds: 10,
  events: EVENTS,
  track: [[0, 52, 5, 0], [4, 52.0001, 5, 12.5], [9, 52.0001, 5.0001, 20]],
  pictures: [2, 4, 6],
  maps: [3, 7],
};

function stalls(count: number): object {
  const features = Array.from({ length: count }, (_, k) => {
    const at = (x: number, y: number): [number, number] => [5 + (3 * k + x) / 1e5, 52 + y / 1e5];
    return { id: k, geometry: { type: "Polygon", coordinates: [[at(0, 0), at(0, 5), at(2, 5), at(2, 0), at(0, 0)]] }, properties: { label: `A ${k}`, state: "free" } };
  });
  return { type: "FeatureCollection", features };
}

describe("the time line", () => {
  it("finds what was last at a time", () => {
    assert.deepEqual([-1, 2, 3.9, 4, 99].map((at) => lastAt([2, 4, 6], at)), [-1, 0, 0, 1, 2]);
    assert.equal(lastAt([], 5), -1);
  });

  it("knows the state, and writes minutes", () => {
    assert.deepEqual([0, 1, 7, 9].map((at) => stateAt(EVENTS, at)), ["", "Takeoff", "Takeoff", "Hover"]);
    assert.deepEqual([0, 59.9, 187, -1].map(clockOf), ["0:00", "0:59", "3:07", "0:00"]);
  });
});

describe("a replay", () => {
  const before = globalThis.fetch;
  let line: Line;
  let replay: Replay;
  let draw: ((passed: number) => void) | null;

  beforeEach(() => {
    line = LINE;
    draw = null;
    globalThis.fetch = (address, options) => {
      assert.equal(options?.method, undefined, "a replay only reads");
      if (address === "api/replay.json") return Promise.resolve(Response.json(line));
      return Promise.resolve(Response.json(stalls(address === "api/replay/maps/0" ? 1 : 2)));
    };
  });

  afterEach(() => {
    globalThis.fetch = before;
  });

  async function open(): Promise<void> {
    replay = new Replay();
    replay.every = (next) => {
      draw = next;
      return () => (draw = null);
    };
    document.body.replaceChildren(replay);
    await replay.begin();
    await drawn();
  }

  async function drawn(): Promise<void> {
    for (let k = 0; k < 4; k++) {
      await settle();
      await replay.updateComplete;
    }
  }

  async function press(label: string, which = 0): Promise<void> {
    const found = [...replay.querySelectorAll("button")].filter((each) => words(each) === label)[which];
    assert.ok(found, `${label}: ${words(replay)}`);
    found.click();
    await drawn();
  }

  const picture = (): string | null => replay.querySelector("img")?.getAttribute("src") ?? null;
  const drawnStalls = (): number => (replay.querySelector("path.free")?.getAttribute("d") ?? "").split("M").length - 1;

  it("is marked as one, and begins before the first picture", async () => {
    await open();
    assert.match(words(replay), /Replay 20260504T103000Z\.mcap/);
    assert.match(words(replay), /No picture yet/);
    assert.equal(picture(), null);
    assert.equal(replay.querySelectorAll("li b").length, 0);
  });

  it("jumps to a message, and shows state, height, picture and map of that time", async () => {
    await open();
    await press("0:08");
    assert.equal(picture(), "api/replay/pictures/2");
    assert.equal(drawnStalls(), 2);
    assert.match(words(replay), /0:08 \/ 0:10/);
    assert.match(words(replay), /Hover · 12\.5 m high/);
    assert.equal(words(replay.querySelector("li.on")!).includes("Hover"), true);
  });

  it("makes the ground once for a map, and moves the drone over it", async () => {
    await open();
    await press("0:08");
    const plan = replay.querySelector<PlanView>("archive-plan")!;
    const [ground, drone] = [plan.ground, replay.querySelector("circle.drone")?.getAttribute("cx")];
    await press("Play");
    draw?.(1.5);
    await drawn();
    assert.equal(plan.ground, ground);
    assert.notEqual(replay.querySelector("circle.drone")?.getAttribute("cx"), drone);
  });

  it("plays at the speed that was chosen, pauses, ends at its end, and begins again", async () => {
    await open();
    const speed = replay.querySelector("select")!;
    speed.value = "4";
    speed.dispatchEvent(new Event_("change"));
    await press("Play");
    draw?.(1);
    await drawn();
    assert.match(words(replay), /0:04 \/ 0:10/);
    await press("Pause");
    assert.equal(draw, null);
    await press("Play");
    draw!(1);
    draw!(1);
    await drawn();
    assert.match(words(replay), /0:10 \/ 0:10/);
    assert.equal(draw, null);
    await press("Play");
    assert.match(words(replay), /0:00 \/ 0:10/);
  });

  it("follows the time bar", async () => {
    await open();
    const bar = replay.querySelector<HTMLInputElement>("input[type=range]")!;
    bar.value = "4.2";
    bar.dispatchEvent(new Event_("input"));
    await drawn();
    assert.equal(picture(), "api/replay/pictures/1");
    assert.equal(drawnStalls(), 1);
  });

  it("says where a recording is damaged", async () => {
    line = { ...LINE, damage: "the file has no end" };
    await open();
    assert.match(words(replay), /damaged from here on: the file has no end/);
  });
});

const Event_ = document.defaultView!.Event;
