import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { SOFT } from "../src/map/feather.ts";
import { corners, covers, extentOf, scaleBar, turn } from "../src/map/geometry.ts";
import { rgb } from "../src/map/palette.ts";
import { classPixels, leaveOutBlack, veilPixels } from "../src/map/tile-picture.ts";
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

  it("turns in the shorter direction", () => {
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

  const size = 64;
  const wide = size + 2 * SOFT;
  const everything = () => new Uint8Array(wide * wide).fill(1);
  const grey = () => new Uint8ClampedArray(size * size * 4).fill(200);
  const blacken = (pixels: Uint8ClampedArray, left: number, top: number, width: number, height: number): void => {
    for (let row = top; row < top + height; row += 1) {
      for (let column = left; column < left + width; column += 1) pixels.set([3, 3, 3, 255], (row * size + column) * 4);
    }
  };
  const cell = (seen: Uint8Array, column: number, row: number) => seen[(row + SOFT) * wide + column + SOFT];

  it("leaves out black that the camera never saw, to the pixel, and nothing beside it", () => {
    const [pixels, seen] = [grey(), everything()];
    blacken(pixels, 0, 0, 35, size);
    leaveOutBlack(pixels, size, seen, true);
    assert.deepEqual([cell(seen, 2, 2), cell(seen, 34, 2), cell(seen, 35, 2)], [0, 0, 1]);
  });

  it("keeps a black car in the midst of what was seen, and knows none before the cells are there", () => {
    for (const [known, kept] of [[true, 1], [false, 0]] as const) {
      const [pixels, seen] = [grey(), everything()];
      blacken(pixels, 16, 8, 18, 45);
      leaveOutBlack(pixels, size, seen, known);
      assert.equal(cell(seen, 20, 20), kept);
    }
  });

  it("leaves out even a small black patch where the cells say that nothing was seen", () => {
    const [pixels, seen] = [grey(), everything()];
    blacken(pixels, 16, 16, 16, 16);
    seen[(20 + SOFT) * wide + 20 + SOFT] = 0;
    leaveOutBlack(pixels, size, seen, true);
    assert.deepEqual([cell(seen, 17, 17), cell(seen, 40, 40)], [0, 1]);
  });
});
