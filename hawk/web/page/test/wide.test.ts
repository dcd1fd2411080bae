import assert from "node:assert/strict";
import { describe, it } from "node:test";
import type { Sight } from "../src/map/geometry.ts";
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
