import "./dom.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { LocalPlane } from "../src/fence/plane.ts";
import { Background, cornerOf, inGrid, placement, tilesIn, zoomFor } from "../src/map/background.ts";
import { MapTools } from "../src/ui/map-tools.ts";
import { settle } from "./fakes.ts";
import { flying } from "./rig.ts";
import { Stage } from "./stage.ts";

const PLANE = new LocalPlane({ Latitude: 48, Longitude: 11 });

describe("tiles of a background", () => {
  it("lie where the web's grid has them", () => {
    assert.deepEqual(cornerOf({ zoom: 0, x: 0, y: 0 }).Longitude, -180);
    assert.ok(Math.abs(cornerOf({ zoom: 0, x: 0, y: 0 }).Latitude - 85.05113) < 1e-5);
    assert.deepEqual(cornerOf({ zoom: 1, x: 1, y: 1 }), { Latitude: 0, Longitude: 0 });
    const { x, y } = inGrid({ Latitude: 48, Longitude: 11 }, 18);
    assert.deepEqual([Math.floor(x), Math.floor(y)], [139081, 91125]);
    const again = cornerOf({ zoom: 18, x, y });
    assert.ok(Math.abs(again.Latitude - 48) < 1e-9 && Math.abs(again.Longitude - 11) < 1e-9);
  });

  it("are chosen by how near one looks", () => {
    const zooms = [16, 18, 20];
    assert.deepEqual([2, 0.3, 0.1, 0.001].map((resolution) => zoomFor(zooms, resolution, 48)), [16, 18, 20, 20]);
    assert.equal(zoomFor([], 0.3, 48), null);
  });

  it("cover what is shown, and are left out where they would be too many", () => {
    const tiles = tilesIn([-100, -100, 100, 100], 18, PLANE);
    const corners = [[-100, -100], [100, 100]].map(([East, North]) => inGrid(PLANE.toEarth({ North: North!, East: East! }), 18));
    for (const { x, y } of corners) assert.ok(tiles.some((tile) => tile.x === Math.floor(x) && tile.y === Math.floor(y)));
    assert.deepEqual(tilesIn([-5000, -5000, 5000, 5000], 22, PLANE), []);
  });

  it("are drawn to the decimetre where they belong", () => {
    const resolution = 0.5;
    const zoom = 18;
    const place = { North: 83, East: -47 };
    const { x, y } = inGrid(PLANE.toEarth(place), zoom);
    const tile = { zoom, x: Math.floor(x), y: Math.floor(y) };
    const [a, b, c, d, e, f] = placement(tile, PLANE, resolution);
    const [right, down] = [x - tile.x, y - tile.y];
    const [east, south] = [(a * right + c * down + e) * resolution, (b * right + d * down + f) * resolution];
    assert.ok(Math.hypot(east - place.East, -south - place.North) < 0.1);
  });
});

describe("the background", () => {
  async function drawn(answers: Record<string, { ok: boolean; body?: unknown }>, visible = true) {
    const asked: string[] = [];
    const background = new Background(() => undefined);
    globalThis.fetch = ((url: string) => {
      asked.push(url);
      const { ok, body } = answers[url] ?? { ok: url.startsWith("api/background/"), body: null };
      return Promise.resolve({ ok, json: () => Promise.resolve(body), blob: () => Promise.resolve(url) });
    }) as unknown as typeof fetch;
    globalThis.createImageBitmap = ((url: unknown) => Promise.resolve({ url, close: () => undefined })) as unknown as typeof createImageBitmap;
    let images = 0;
    const context = new Proxy({} as CanvasRenderingContext2D, {
      get: (_, name) => (name === "drawImage" ? () => (images += 1) : () => undefined),
    });
    const draw = async (): Promise<number> => {
      images = 0;
      background.draw(context, [-60, -60, 60, 60], 0.5);
      for (let turn = 0; turn < 8; turn += 1) await settle();
      return images;
    };
    await background.load();
    background.plane = PLANE;
    background.visible = visible;
    return { background, asked, draw };
  }

  const LISTED = { "api/background.json": { ok: true, body: { Zooms: [18] } } };

  it("is fetched from the drone's own computer as it is needed, and each tile once", async () => {
    const { asked, draw } = await drawn(LISTED);
    assert.equal(await draw(), 0);
    const tiles = asked.length - 1;
    assert.ok(tiles >= 1 && asked.every((url) => /^api\/background(\.json|\/18\/\d+\/\d+)$/.test(url)));
    assert.equal(await draw(), tiles);
    assert.equal(asked.length, tiles + 1);
  });

  it("asks for nothing where there are no tiles, or while it is switched off", async () => {
    for (const answer of [{ ok: false }, { ok: true, body: { Zooms: [] } }, { ok: true, body: "nonsense" }]) {
      const { asked, draw } = await drawn({ "api/background.json": answer });
      assert.equal(await draw(), 0);
      assert.equal(asked.length, 1);
    }
    const { asked, draw } = await drawn(LISTED, false);
    await draw();
    assert.equal(asked.length, 1);
  });

  it("can be switched only where there is one", async () => {
    const { operator } = flying();
    const stage = new Stage(new MapTools(), operator);
    await stage.drawn();
    await stage.press("Layers");
    assert.equal(stage.has("input[name=background]"), false);
    stage.part.background = true;
    await stage.drawn();
    assert.equal(stage.has("input[name=background]"), true);
  });
});
