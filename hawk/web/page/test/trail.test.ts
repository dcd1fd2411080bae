import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { fading } from "../src/map/draw-trail.ts";

/** A point every ten metres. */
const trail = (points: number, resolution: number) => Array.from({ length: points }, (_, index): [number, number] => [(index * 10) / resolution, 0]);

describe("the trail", () => {
  it("is none for less than two points", () => {
    assert.deepEqual(fading([], 1), []);
    assert.deepEqual(fading([[0, 0]], 1), []);
  });

  it("is whole while it is short", () => {
    assert.deepEqual(fading(trail(8, 1), 1), [{ from: 0, to: 7, share: 1 }]);
  });

  it("fades with the distance flown since, never fully, in pieces that hang together", () => {
    const pieces = fading(trail(120, 1), 1);
    assert.deepEqual([pieces[0]?.from, pieces.at(-1)?.to, pieces[0]?.share, pieces.at(-1)?.share], [0, 119, 0.25, 1]);
    for (const [index, piece] of pieces.slice(1).entries()) {
      assert.equal(piece.from, pieces[index]?.to);
      assert.ok(piece.share > (pieces[index]?.share ?? 1));
    }
  });

  it("fades by metres, however near one looks", () => {
    assert.deepEqual(fading(trail(120, 0.1), 0.1), fading(trail(120, 0.5), 0.5));
  });
});
