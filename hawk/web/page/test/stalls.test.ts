import "./dom.ts";
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { describe, it } from "node:test";
import { drawStalls } from "../src/map/draw-stalls.ts";
import { corners } from "../src/map/geometry.ts";
import { isIn, SQUARE_M, StallIndex } from "../src/map/stall-index.ts";
import { brightnessOver, contrast, detailAt, FILLS, HATCH, hatchPeriod, inset, LINES, luminance } from "../src/map/stall-style.ts";
import type { Stall, StallState } from "../src/state/map-store.ts";

/** Free and taken differ at least so much in grey over asphalt, dark or light. */
const LEAST_CONTRAST = 1.5;
/** What is black and what is white beneath a fill still differ at least so much. */
const LEAST_SEEN_BENEATH = 2;
const STATES: StallState[] = ["free", "taken", "unknown", "suggested"];

function stall(id: number, changes: Partial<Stall> = {}): Stall {
  return { id, north: 0, east: 0, angle: 0, width: 2.5, length: 5, state: "free", taken: 0.1, seen: 3, lastSeen: 1, label: String(id), ...changes };
}

describe("the look of stalls", () => {
  it("distinguishes free from taken in grey", () => {
    for (let grey = 60; grey <= 200; grey += 10) {
      const [free, taken] = (["free", "taken"] as const).map((state) => brightnessOver(state, [grey, grey, grey])) as [number, number];
      assert.ok(contrast(free, taken) >= LEAST_CONTRAST, `${contrast(free, taken)} over ${grey}`);
    }
  });

  it("lets a car be seen beneath", () => {
    for (const state of STATES) {
      const seen = contrast(brightnessOver(state, [255, 255, 255]), brightnessOver(state, [20, 20, 20]));
      assert.ok(seen >= LEAST_SEEN_BENEATH, `${seen} beneath ${state}`);
    }
  });

  it("measures brightness as WCAG does", () => {
    assert.deepEqual([luminance([0, 0, 0]), Math.round(luminance([255, 255, 255]) * 1e6)], [0, 1_000_000]);
    assert.equal(contrast(1, 0), 21);
    assert.equal(contrast(0, 1), 21);
  });

  it("is the same in the legend", async () => {
    const style = await readFile(new URL("../src/styles/tokens.css", import.meta.url), "utf8");
    const hex = (colour: readonly number[]) => `#${colour.map((value) => value.toString(16).padStart(2, "0")).join("")}`;
    assert.ok(style.includes(`--free: ${hex(FILLS.free.colour)};`));
    assert.ok(style.includes(`--taken: ${hex(HATCH.colour)};`));
    assert.ok(style.includes(`--free-line: ${LINES.free};`) && style.includes(`--taken-line: ${LINES.taken};`));
  });

  it("has a hatching that grows with the stall, within bounds", () => {
    assert.equal(hatchPeriod(0.055), 10);
    assert.equal(hatchPeriod(0.0275), 20);
    assert.deepEqual([hatchPeriod(2), hatchPeriod(0.001)], [5, 24]);
  });

  it("has less detail from afar", () => {
    assert.deepEqual([0.1, 0.3, 1].map((resolution) => detailAt(resolution)), [
      { line: 1.5, hatched: true, marked: true },
      { line: 1, hatched: true, marked: false },
      { line: 0, hatched: false, marked: false },
    ]);
  });
});

describe("neighbouring stalls", () => {
  it("do not overlap as they are drawn, with their outlines, though they were found some centimetres too large", () => {
    const angle = 0.8;
    const pitch = 2.5;
    for (const resolution of [0.05, 0.15, 0.4]) {
      const { line } = detailAt(resolution);
      const outer = (east: number): ReturnType<typeof inset> => {
        const drawn = inset({ north: 0, east, angle, width: pitch + 0.12, length: 5 }, line, resolution);
        return { ...drawn, width: drawn.width + line * resolution, length: drawn.length + line * resolution };
      };
      const [one, other] = [outer(0), outer(pitch / Math.cos(angle))];
      assert.equal(corners(one).some(([east, north]) => isIn(other, north, east, -1e-9)), false);
      assert.equal(corners(other).some(([east, north]) => isIn(one, north, east, -1e-9)), false);
    }
  });

  it("keep half of their size however far away", () => {
    assert.deepEqual(inset({ north: 0, east: 0, angle: 0, width: 2.4, length: 5 }, 1, 2), { north: 0, east: 0, angle: 0, width: 1.2, length: 2.84 });
  });

  it("are drawn with one path a kind, so that nothing is filled twice", () => {
    const fills: string[] = [];
    const calls: Record<string, unknown> = { fill: () => fills.push(String(calls.fillStyle)) };
    const context = new Proxy(calls, { get: (kept, name) => kept[String(name)] ?? (() => undefined) }) as unknown as CanvasRenderingContext2D;
    const stalls = [1, 2, 3, 4].map((id) => stall(id, { state: id === 4 ? "unknown" : "free" }));
    drawStalls(context, stalls, { west: 0, north: 0, resolution: 1, ratio: 1 }, detailAt(1));
    assert.deepEqual(fills, ["rgba(112,182,255,0.46)", "rgba(16,22,28,0.38)"]);
  });
});

describe("the stall at a place", () => {
  it("is that in whose turned rectangle it lies, by a finger's breadth", () => {
    const index = new StallIndex<number, Stall>((one, other) => one.state === other.state);
    index.put(stall(7, { north: 40, east: -40, angle: Math.PI / 4 }));
    assert.equal(index.at(41.7, -38.3, 0)?.id, 7);
    assert.equal(index.at(41.7, -41.7, 0), null);
    assert.equal(index.at(41, -41, 0), null);
    assert.equal(index.at(41, -41, 0.2)?.id, 7);
  });

  it("is the nearer of two, across squares too", () => {
    const index = new StallIndex<number, Stall>((one, other) => one.state === other.state);
    index.put(stall(1, { east: SQUARE_M - 0.5 }));
    index.put(stall(2, { east: SQUARE_M + 1 }));
    assert.equal(index.at(0, SQUARE_M + 0.1, 0)?.id, 1);
    assert.equal(index.at(0, SQUARE_M + 0.6, 0)?.id, 2);
  });

  it("moves with the stall, and goes with it", () => {
    const index = new StallIndex<number, Stall>((one, other) => one.state === other.state);
    assert.equal(index.put(stall(1)), true);
    assert.equal(index.put(stall(1, { seen: 9 })), false, "nothing that is drawn changed");
    assert.equal(index.at(0, 0, 0)?.seen, 9);
    const before = index.within([-1, -1, 1, 1]).map((square) => square.version);
    assert.equal(index.put(stall(1, { state: "taken" })), true);
    assert.notDeepEqual(index.within([-1, -1, 1, 1]).map((square) => square.version), before);
    index.put(stall(1, { east: 100 }));
    assert.deepEqual([index.at(0, 0, 0), index.at(0, 100, 0)?.id], [null, 1]);
    assert.deepEqual([index.remove(1), index.remove(1), index.at(0, 100, 0)], [true, false, null]);
  });

  it("belongs to a square whose picture holds all of it", () => {
    const index = new StallIndex<number, Stall>((one, other) => one.state === other.state);
    for (const east of [0, SQUARE_M / 2, SQUARE_M - 0.01]) index.put(stall(east, { east, angle: 0.78, length: 7 }));
    const [square] = index.within([0, 0, 1, 1]);
    const [west, south, eastern, north] = square!.extent;
    for (const each of square!.stalls.values()) {
      for (const [x, y] of corners(each)) assert.ok(x > west && x < eastern && y > south && y < north);
    }
  });
});
