import "./dom.ts";
import assert from "node:assert/strict";
import { afterEach, beforeEach, describe, it } from "node:test";
import type { Extent } from "../src/map/geometry.ts";
import { GroundTiles } from "../src/map/ground-tiles.ts";
import { settle } from "./fakes.ts";

const KEYS = [{ row: 0, column: 0 }, { row: 0, column: 1 }, { row: 1, column: 0 }];
const GRID = { cells: 256, cellSize: 0.1 };
const FAR: Extent = [-100, -100, 100, 100];
/** Within the first tile. */
const NEAR: Extent = [1, -9, 9, -1];

describe("the ground of a survey", () => {
  const before = { fetch: globalThis.fetch, bitmap: globalThis.createImageBitmap };
  let asked: string[];
  let answers: Record<string, Response>;
  let changes: boolean[];
  let tiles: GroundTiles;

  beforeEach(() => {
    [asked, changes] = [[], []];
    answers = { whole: new Response("picture") };
    globalThis.fetch = (address) => {
      asked.push(address as string);
      return Promise.resolve(answers[address as string]?.clone() ?? new Response("", { status: 404 }));
    };
    globalThis.createImageBitmap = () => Promise.resolve({ width: 256, height: 256, close: () => undefined });
    tiles = new GroundTiles(GRID, (isDone) => changes.push(isDone));
  });

  afterEach(() => {
    [globalThis.fetch, globalThis.createImageBitmap] = [before.fetch, before.bitmap];
  });

  async function show(): Promise<void> {
    tiles.show({ address: ({ row, column }) => `${row}/${column}`, place: { north: 0, east: 0, turn: 0 }, tiles: KEYS, whole: "whole" });
    assert.equal(tiles.arrived, "none");
    for (let k = 0; k < 5; k += 1) await settle();
  }

  it("is one picture from afar, over the rectangle of its tiles", async () => {
    await show();
    const drawn: number[][] = [];
    tiles.draw(FAR, 0.3, (_, ...place) => drawn.push(place.map((each) => each + 0)));
    assert.deepEqual(drawn, [[0, 0, 51.2, 51.2]]);
    assert.deepEqual([asked, tiles.arrived, changes.at(-1)], [["whole"], "all", true]);
  });

  it("is finer tiles nearby, those in sight alone, each asked for once", async () => {
    await show();
    for (const extent of [NEAR, NEAR]) tiles.draw(extent, 0.1, () => undefined);
    await settle();
    assert.deepEqual(asked, ["whole", "0/0"]);
  });

  it("is its tiles at once where it has no picture of the whole", async () => {
    answers = { whole: new Response(null, { status: 204 }) };
    await show();
    assert.deepEqual(asked.sort(), ["0/0", "0/1", "1/0", "whole"]);
    assert.equal(tiles.arrived, "all");
  });

  it("is asked for no tile where the picture of the whole is as fine as they are", async () => {
    globalThis.createImageBitmap = () => Promise.resolve({ width: 512, height: 512, close: () => undefined });
    await show();
    tiles.draw(NEAR, 0.02, () => undefined);
    assert.deepEqual(asked, ["whole"]);
  });
});
