import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { changedSides, fade, seenWithRim, type Side, SIDES, SOFT, softened } from "../src/map/feather.ts";

const SIZE = 64;
const WIDE = SIZE + 2 * SOFT;
const filled = (cell: number) => new Uint8Array(SIZE * SIZE).fill(cell);
/** Seen up to a column, not beyond. */
const halved = (columns: number) => filled(0).map((_, index) => (index % SIZE < columns ? 2 : 0));

describe("the soft edge of what was seen", () => {
  it("is none in the midst of it", () => {
    assert.equal(softened(seenWithRim(SIZE, () => filled(1)), SIZE), null);
  });

  it("shows nothing at the edge, everything SOFT cells inside, and rises between", () => {
    const around = (side: Side) => (side[1] > 0 ? filled(0) : side[1] < 0 ? filled(2) : halved(40));
    const shown = softened(seenWithRim(SIZE, around), SIZE);
    const row = [...(shown ?? []).slice(20 * SIZE, 21 * SIZE)];
    assert.deepEqual([row[45], row[40], row[40 - SOFT], row[0]], [0, 0, 255, 255]);
    assert.ok((row[39] ?? 255) < 16, `${row[39]} at the last cell that was seen`);
    for (let column = 39 - SOFT; column < 40; column += 1) assert.ok((row[column] ?? 0) >= (row[column + 1] ?? 0));
    const steps = row.slice(0, -1).map((value, column) => Math.abs(value - (row[column + 1] ?? 0)));
    assert.ok(Math.max(...steps) <= 255 / (SOFT / 2), "no stair");
  });

  it("shows nothing of a notch that was not seen, though most around it was", () => {
    const cells = filled(2);
    const [row, column] = [30, 30];
    cells[row * SIZE + column] = 0;
    const shown = softened(seenWithRim(SIZE, (side) => (side[0] === 0 && side[1] === 0 ? cells : filled(2))), SIZE);
    const at = (down: number, right: number) => shown?.[(row + down) * SIZE + column + right] ?? -1;
    assert.equal(at(0, 0), 0);
    for (const steps of [1, 3, SOFT]) {
      const around = [at(0, steps), at(0, -steps), at(steps, 0), at(-steps, 0)];
      assert.deepEqual(around, around.map(() => around[0]), "alike on all sides");
    }
    assert.ok(at(0, 1) < at(1, 1) && at(1, 1) < at(0, 2));
    assert.equal(at(SOFT, 0), 255);
  });

  it("does not show where two tiles meet that were both seen", () => {
    const shown = softened(seenWithRim(SIZE, (side) => (side[0] >= 0 && side[1] >= 0 ? filled(2) : null)), SIZE);
    assert.equal(shown?.[SIZE * SIZE - 1], 255);
    assert.ok((shown[0] ?? 255) < 16);
    assert.ok((shown[(SIZE - 1) * SIZE] ?? 255) < 16);
  });

  it("takes each neighbour's nearest strip as the rim", () => {
    for (const side of SIDES) {
      const seen = seenWithRim(SIZE, (each) => (each[0] === side[0] && each[1] === side[1] ? filled(1) : null));
      const count = seen.reduce((sum, cell) => sum + cell, 0);
      assert.equal(count, (side[0] === 0 ? SIZE : SOFT) * (side[1] === 0 ? SIZE : SOFT));
      const [row, column] = side.map((step) => (step < 0 ? 0 : step > 0 ? WIDE - 1 : WIDE >> 1)) as [number, number];
      assert.equal(seen[row * WIDE + column], 1);
    }
  });

  it("makes pixels transparent by as much", () => {
    const pixels = Uint8ClampedArray.of(9, 9, 9, 255, 9, 9, 9, 150, 9, 9, 9, 255);
    fade(pixels, Uint8Array.of(255, 51, 0));
    assert.deepEqual([...pixels], [9, 9, 9, 255, 9, 9, 9, 30, 9, 9, 9, 0]);
    fade(pixels, null);
    assert.equal(pixels[3], 255);
  });
});

describe("a tile that changed", () => {
  it("changes its neighbours only where what was seen at its border changed", () => {
    assert.deepEqual(changedSides(filled(2), filled(4), SIZE), []);
    assert.deepEqual(changedSides(null, filled(2), SIZE), SIDES);
    const inner = filled(0);
    inner[30 * SIZE + 30] = 2;
    assert.deepEqual(changedSides(filled(0), inner, SIZE), []);
    const west = filled(0);
    west[30 * SIZE + SOFT - 1] = 1;
    assert.deepEqual(changedSides(filled(0), west, SIZE), [[0, -1]]);
    const corner = filled(0);
    corner[SIZE * SIZE - 1] = 1;
    assert.deepEqual(changedSides(filled(0), corner, SIZE), [[0, 1], [1, 0], [1, 1]]);
  });
});
