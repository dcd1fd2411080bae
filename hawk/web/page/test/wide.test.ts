import "./no-drawing.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import type { FrameState } from "ol/Map.js";
import type { Sight } from "../src/map/geometry.ts";
import { SquarePictures } from "../src/map/square-pictures.ts";
import { StallIndex } from "../src/map/stall-index.ts";
import { shift } from "../src/map/wide-canvas.ts";

const SIGHT: Sight = { width: 800, height: 600, center: [0, 0], resolution: 0.5, rotation: 0 };

describe("a canvas that is larger than the map", () => {
  it("is shifted against the direction in which the view moves, up to its margin", () => {
    assert.deepEqual(shift(SIGHT, SIGHT, 100), [0, 0]);
    assert.deepEqual(shift(SIGHT, { ...SIGHT, center: [10, 20] }, 100), [-20, 40]);
    assert.equal(shift(SIGHT, { ...SIGHT, center: [51, 0] }, 100), null);
    assert.equal(shift(SIGHT, { ...SIGHT, center: [0, -51] }, 100), null);
  });

  it("is shifted along the screen where the map is turned", () => {
    const turned = { ...SIGHT, rotation: Math.PI / 2 };
    const [right, down] = shift(turned, { ...turned, center: [10, 0] }, 100) ?? [];
    assert.deepEqual([Math.round(right ?? NaN), Math.round(down ?? NaN)], [0, -20]);
  });

  it("is drawn again at another zoom, turn or size", () => {
    for (const change of [{ resolution: 0.4 }, { rotation: 0.1 }, { width: 700 }, { height: 700 }]) {
      assert.equal(shift(SIGHT, { ...SIGHT, ...change }, 100), null);
    }
  });
});

describe("stalls in squares", () => {
  it("are drawn all at once when they come into sight, and into a picture for each square after that", () => {
    const drawn: number[][] = [];
    const index = new StallIndex<number, { id: number; north: number; east: number; angle: number; width: number; length: number }>(() => true);
    for (const id of [0, 1, 2]) index.put({ id, north: 1, east: 1 + 40 * id, angle: 0, width: 2, length: 5 });
    const pictures = new SquarePictures(index, (_, stalls) => drawn.push([...stalls].map(({ id }) => id)));
    const context = document.createElement("canvas").getContext("2d")!;
    const paint = (): unknown => pictures.paint(context, SIGHT, { pixelRatio: 1, viewHints: [0, 0] } as unknown as FrameState);
    paint();
    assert.deepEqual(drawn.splice(0), [[0, 1, 2]]);
    paint();
    assert.deepEqual(drawn.splice(0), [[0], [1], [2]]);
    index.remove(1);
    index.put({ id: 3, north: 1, east: 2, angle: 0, width: 2, length: 5 });
    paint();
    assert.deepEqual(drawn.splice(0), [[0, 3]], "the square that changed");
  });
});
