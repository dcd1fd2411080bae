import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { corners, covers, extentOf, scaleBar, turn } from "../src/map/geometry.ts";
import { rgb } from "../src/map/palette.ts";
import { classPixels, clearUnseen, veilPixels } from "../src/map/tile-picture.ts";
import { CELL } from "../src/state/tile-data.ts";

const palette = {
  fog: "#000000",
  grid: "#000000",
  fence: "#000000",
  zone: "#a31d17",
  plan: "#000000",
  planCase: "#000000",
  asphalt: "#0a0b0c",
  ground: "#141516",
  veil: "#ff8000",
};

describe("geometry", () => {
  it("turns a stall's long side clockwise from north", () => {
    const upright = corners({ north: 10, east: 20, angle: 0, width: 2, length: 6 });
    assert.deepEqual(extentOf(upright), [19, 7, 21, 13]);
    const lying = extentOf(corners({ north: 0, east: 0, angle: Math.PI / 2, width: 2, length: 6 }));
    assert.deepEqual(lying?.map(Math.round), [-3, -1, 3, 1]);
  });

  it("finds extents and what they cover", () => {
    assert.equal(extentOf([]), null);
    assert.equal(covers([0, 0, 10, 10], [1, 1, 9, 9]), true);
    assert.equal(covers([0, 0, 10, 10], [1, 1, 11, 9]), false);
  });

  it("turns by the shorter way", () => {
    assert.ok(Math.abs(turn(3, -3, 1) - (2 * Math.PI - 3)) < 1e-9);
    assert.ok(Math.abs(turn(0.2, 0.4, 0.5) - 0.3) < 1e-9);
  });

  it("has a round scale bar that fits", () => {
    for (const resolution of [0.021, 0.13, 0.3, 1.7]) {
      const { length, pixels } = scaleBar(resolution, 120);
      assert.ok(pixels <= 120 && pixels > 40, `${pixels}`);
      assert.match(String(length), /^[0.]*[125]0*$/);
    }
  });
});

describe("a tile's picture", () => {
  it("paints classes, leaving open what is unknown", () => {
    const pixels = classPixels(Uint8Array.of(CELL.unknown, CELL.nonLot, CELL.lot, CELL.taken), palette);
    assert.deepEqual([...pixels], [0, 0, 0, 0, 20, 21, 22, 255, 10, 11, 12, 255, 10, 11, 12, 255]);
  });

  it("veils only what is not lot", () => {
    const pixels = veilPixels(Uint8Array.of(CELL.nonLot, CELL.lot, CELL.unknown), palette);
    assert.deepEqual([...pixels.slice(0, 3)], [...rgb("#ff8000")]);
    assert.deepEqual([pixels[7], pixels[11]], [0, 0]);
  });

  it("is transparent where the camera never was, and keeps dark cars", () => {
    const size = 32;
    const pixels = new Uint8ClampedArray(size * size * 4).fill(255);
    const paint = (left: number, top: number, width: number, height: number): void => {
      for (let row = top; row < top + height; row += 1) {
        for (let column = left; column < left + width; column += 1) pixels.set([3, 3, 3, 255], (row * size + column) * 4);
      }
    };
    const alpha = (column: number, row: number) => pixels[(row * size + column) * 4 + 3];
    paint(0, 0, 11, 32);
    paint(26, 26, 3, 2);
    clearUnseen(pixels, size);
    assert.deepEqual([alpha(2, 2), alpha(10, 2), alpha(11, 2)], [0, 0, 255]);
    assert.equal(alpha(27, 27), 255);
  });
});
