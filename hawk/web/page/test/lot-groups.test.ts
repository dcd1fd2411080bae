import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { APART_PX, groupsOf, type LotMark } from "../src/map/lot-groups.ts";

function mark(id: string, east: number, north: number): LotMark {
  return { id, name: id, words: () => "", taken: null, place: [east, north] };
}

const names = (marks: readonly LotMark[], resolution: number): string[] => groupsOf(marks, resolution).map((group) => group.map(({ id }) => id).join(" "));

describe("pins of lots", () => {
  it("stand apart for two lots 45 m apart once their circles do not touch, and are one before", () => {
    const marks = [mark("A", 0, 0), mark("B", 45, 0), mark("C", 500, 500)];
    assert.deepEqual(names(marks, 1), ["A", "B", "C"]);
    assert.deepEqual(names(marks, 2), ["A B", "C"]);
    assert.deepEqual(names(marks, 40), ["A B C"]);
  });

  it("are the same groups wherever the lots lie, over the edges of squares, too", () => {
    for (const [east, north] of [[0, 0], [-23, 7], [19_999_990, -19_999_990], [-1, -1]] as const) {
      const marks = [mark("A", east, north), mark("B", east + 20, north - 5), mark("C", east + 30, north)];
      assert.deepEqual(names(marks, 1), ["A B", "C"], `${east} ${north}`);
    }
  });

  it("hold each lot once, and no two of them touch", () => {
    let seed = 7;
    const next = (): number => (seed = (seed * 16_807) % 2_147_483_647) / 2_147_483_647;
    const marks = Array.from({ length: 2000 }, (_, k) => mark(`${k}`, 4000 * (next() - 0.5), 4000 * (next() - 0.5)));
    for (const resolution of [0.2, 1.7, 9, 300]) {
      const groups = groupsOf(marks, resolution);
      const ids = groups.flat().map(({ id }) => id);
      assert.equal(new Set(ids).size, marks.length);
      assert.equal(ids.length, marks.length);
      const places = groups.map(([{ place }]) => place);
      const closest = places.reduce((least, [east, north], k) => places.slice(k + 1).reduce((so, [x, y]) => Math.min(so, Math.hypot(x - east, y - north)), least), Infinity);
      assert.ok(closest >= APART_PX * resolution, `${closest} m at ${resolution}`);
    }
  });
});
