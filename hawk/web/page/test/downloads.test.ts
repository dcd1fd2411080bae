import "./dom.ts";
import assert from "node:assert/strict";
import { afterEach, beforeEach, describe, it } from "node:test";
import { Downloads } from "../src/ui/downloads.ts";
import * as format from "../src/words/format.ts";
import { flying } from "./rig.ts";
import { Stage, words } from "./stage.ts";

const LISTED = [
  { Name: "stalls.csv", Bytes: 34_000, Reason: "" },
  { Name: "stalls.geojson", Bytes: 152_400, Reason: "" },
  { Name: "lot.jpg", Bytes: 2_460_000, Reason: "" },
  { Name: "recording.mcap", Bytes: null, Reason: "The recording can be downloaded once the motors are off." },
];

describe("the survey's files", () => {
  const before = globalThis.fetch;
  let answers: (() => Promise<Response>)[];
  let asked: string[];

  beforeEach(() => {
    asked = [];
    answers = [];
    globalThis.fetch = (address) => {
      asked.push(address as string);
      return (answers.shift() ?? listed)();
    };
  });

  afterEach(() => {
    globalThis.fetch = before;
  });

  const listed = (): Promise<Response> => Promise.resolve(Response.json({ Downloads: LISTED }));
  const ground = { State: "Idle" as const, Armed: false, Free: 3 };

  it("are four, with their kinds and sizes, or why one is not there", async () => {
    const stage = new Stage(new Downloads(), flying(ground).operator);
    await stage.drawn();
    const links = [...stage.part.querySelectorAll("a")].map((link) => [link.getAttribute("href"), words(link)]);
    assert.deepEqual(links, [
      ["api/stalls.csv", "TableCSV, 34 kB"],
      ["api/stalls.geojson", "Stalls for mapsGeoJSON, 152 kB"],
      ["api/lot.jpg", "Picture of the lotJPEG, 2.5 MB"],
    ]);
    assert.match(words(stage.find(".off")), /Recording.*once the motors are off/);
  });

  it("can be had without their sizes when the drone does not say them", async () => {
    for (const answer of [
      () => Promise.reject(new TypeError("no link")),
      () => Promise.resolve(new Response("", { status: 500 })),
      () => Promise.resolve(Response.json({ other: 1 })),
      () => Promise.resolve(Response.json(null)),
    ]) {
      answers = [answer];
      const stage = new Stage(new Downloads(), flying(ground).operator);
      await stage.drawn();
      assert.equal(stage.part.querySelectorAll("a").length, 4);
      assert.match(stage.text, /RecordingMCAP/);
    }
  });

  it("are asked for again when the map has changed, and not with every heartbeat", async () => {
    const rig = flying(ground);
    const stage = new Stage(new Downloads(), rig.operator);
    await stage.drawn();
    for (const free of [3, 3, 3, 4, 4]) {
      rig.hear({ ...ground, Free: free });
      await stage.drawn();
    }
    assert.equal(asked.length, 2);
  });

  it("are asked for once in flight, where the map changes all the time", async () => {
    const rig = flying({ Free: 1 });
    const stage = new Stage(new Downloads(), rig.operator);
    for (let free = 1; free < 9; free += 1) {
      rig.hear({ Free: free });
      await stage.drawn();
    }
    assert.equal(asked.length, 1);
  });

  it("show no late answer about an earlier map", async () => {
    let late: (response: Response) => void = () => undefined;
    answers = [() => new Promise((resolve) => (late = resolve))];
    const rig = flying(ground);
    const stage = new Stage(new Downloads(), rig.operator);
    await stage.drawn();
    rig.hear({ ...ground, Free: 4 });
    await stage.drawn();
    late(Response.json({ Downloads: [{ Name: "stalls.csv", Bytes: 1, Reason: "" }] }));
    await stage.drawn();
    assert.match(stage.text, /CSV, 34 kB/);
  });
});

describe("the size of a file", () => {
  it("has the unit of its size", () => {
    assert.deepEqual([0, 999, 1000, 12_345, 1_200_000, 87e6, 3.2e9, 5e12].map(format.bytes), ["0 B", "999 B", "1.0 kB", "12 kB", "1.2 MB", "87 MB", "3.2 GB", "5000 GB"]);
  });
});
