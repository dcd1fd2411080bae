import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { deflateSync } from "node:zlib";
import { discsOf, rowMarks } from "../src/map/draw-labels.ts";
import { SOFT } from "../src/map/feather.ts";
import { corners, covers, extentOf, roomBeside, scaleBar, turn } from "../src/map/geometry.ts";
import { rgb } from "../src/map/palette.ts";
import { classPixels, leaveOutUnseen, veilPixels } from "../src/map/tile-picture.ts";
import { CELL, maskOf } from "../src/state/tile-data.ts";

const palette = {
  fog: "#000000",
  grid: "#000000",
  fence: "#000000",
  zone: "#a31d17",
  plan: "#000000",
  planCase: "#000000",
  asphalt: "#0a0b0c",
  ground: "#141516",
  veil: "#ff8000", begins: "#0a6a4c", ends: "#a31d17", confirmed: "#ff8000",
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

  it("leaves room for the letters of rows, and for the tools on their side", () => {
    const map = { left: 12, right: 378 };
    assert.deepEqual(roomBeside(map), [28, 28]);
    assert.deepEqual(roomBeside(map, { left: 326, right: 370 }), [80, 28]);
    assert.deepEqual(roomBeside(map, { left: 20, right: 64 }), [28, 80]);
    assert.deepEqual(roomBeside(map, { left: 400, right: 444 }), [28, 28], "those of another map");
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

  it("leaves out what the picture does not show, to the pixel, and nothing beside it", () => {
    const size = 64;
    const wide = size + 2 * SOFT;
    const seen = new Uint8Array(wide * wide).fill(1);
    leaveOutUnseen(Uint8Array.from({ length: size * size }, (_, at) => (at % size < 35 ? 0 : 1)), size, seen);
    const cell = (column: number, row: number) => seen[(row + SOFT) * wide + column + SOFT];
    assert.deepEqual([cell(0, 0), cell(34, 63), cell(35, 0), cell(-1, 0)], [0, 0, 1, 1]);
    assert.equal(seen.filter((each) => each === 0).length, 35 * size);
  });
});

describe("letters of rows", () => {
  const row = (letter: string, north: number) => [1, 2].map((at) => ({ label: `${letter} ${at}`, north, east: 2.5 * at, angle: 0, width: 2.5, length: 5 }));
  const rows = rowMarks([...row("A", 10), ...row("B", 5), ...row("C", 0)]);
  const sight = (resolution: number) => ({ width: 400, height: 400, center: [0, 0] as [number, number], resolution, rotation: 0 });

  it("stand before the row, and go out of it where one would cover another one", () => {
    const near = discsOf(rows, sight(0.05));
    assert.deepEqual(near.map(([x]) => Math.round(x)), [195, 195, 195]);
    const far = discsOf(rows, sight(0.4));
    const apart = far.flatMap(([x, y], one) => far.slice(one + 1).map(([a, b]) => Math.hypot(a - x, b - y)));
    assert.ok(Math.min(...apart) >= 24, String(apart));
    assert.ok(far.every(([x]) => x <= 200), "west of the stalls");
  });
});

describe("the mask in a tile's picture", () => {
  const bits = Uint8Array.of(0b10000001, 0xff, 0, 0, 0, 0, 0, 0b00000010);
  const jpeg = (mark: string): Uint8Array<ArrayBuffer> => {
    const mask = [...Buffer.from(mark, "latin1"), ...deflateSync(bits)];
    return Uint8Array.from([0xff, 0xd8, 0xff, 0xfe, 0, mask.length + 2, ...mask, 0xff, 0xdb, 0, 2]);
  };

  it("is read from the first segment, the north-west cell first", async () => {
    const mask = await maskOf(jpeg("hawk seen\0"), 8);
    assert.deepEqual([...(mask ?? [])].slice(0, 16), [1, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1]);
    assert.deepEqual([mask?.length, mask?.[62], mask?.[63]], [64, 1, 0]);
  });

  it("is none in any other JPEG, and refused in another size", async () => {
    assert.equal(await maskOf(jpeg("any comment"), 8), null);
    assert.equal(await maskOf(Uint8Array.of(0xff, 0xd8, 0xff, 0xe0), 8), null);
    await assert.rejects(maskOf(jpeg("hawk seen\0"), 16), /8 bytes instead of 32/);
  });
});
