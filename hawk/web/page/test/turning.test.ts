import "./dom.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { drawScene } from "../src/map/draw-scene.ts";
import { EMPTY_SCENE } from "../src/map/flight-scene.ts";
import { covers, onScreen, type Sight, sightExtent, toPixel, toPlace } from "../src/map/geometry.ts";
import { Glide } from "../src/map/glide.ts";
import type { Surface } from "../src/map/surface.ts";
import { MapTools } from "../src/ui/map-tools.ts";
import { flying } from "./rig.ts";
import { Stage } from "./stage.ts";

const SIGHT: Sight = { width: 800, height: 600, center: [100, 50], resolution: 0.5, rotation: 0 };

function near(found: readonly number[], wanted: readonly number[]): void {
  found.forEach((value, index) => assert.ok(Math.abs(value - (wanted[index] ?? Number.NaN)) < 1e-6, `${found.join()} is not ${wanted.join()}`));
}

describe("a turned map", () => {
  it("has east right and north up while it is not turned", () => {
    near(toPixel(SIGHT, [110, 50]), [420, 300]);
    near(toPixel(SIGHT, [100, 60]), [400, 280]);
  });

  it("turned against the drone's heading has the drone's nose up", () => {
    for (const yaw of [0.3, 1.5, -2.8]) {
      const ahead: [number, number] = [100 + 10 * Math.sin(yaw), 50 + 10 * Math.cos(yaw)];
      near(toPixel({ ...SIGHT, rotation: -yaw }, ahead), [400, 280]);
    }
  });

  it("finds the place at a pixel again", () => {
    for (const rotation of [0, 0.7, -2]) {
      const sight = { ...SIGHT, rotation };
      near(toPlace(sight, toPixel(sight, [37, -12])), [37, -12]);
    }
  });

  it("knows all that is shown, and what fits", () => {
    near(sightExtent(SIGHT), [-100, -100, 300, 200]);
    near(sightExtent({ ...SIGHT, rotation: Math.PI / 2 }), [-50, -150, 250, 250]);
    const wide = [-90, 0, 290, 100] as [number, number, number, number];
    assert.equal(covers([0, 0, 800, 600], onScreen(SIGHT, wide)), true);
    assert.equal(covers([0, 0, 800, 600], onScreen({ ...SIGHT, rotation: Math.PI / 2 }, wide)), false);
  });

  it("draws the drone's arrow by its heading on the screen", () => {
    const turns: number[] = [];
    const context = new Proxy({} as CanvasRenderingContext2D, {
      get: (_, name) => (name === "rotate" ? (angle: number) => turns.push(angle) : () => undefined),
      set: () => true,
    });
    const surface = { context, palette: {}, resolution: 0.5, rotation: -0.4, pixel: (place: readonly [number, number]) => toPixel(SIGHT, place) };
    drawScene(surface as unknown as Surface, { ...EMPTY_SCENE, drone: { north: 0, east: 0, yaw: 0.4 } });
    near(turns, [0]);
  });
});

describe("the drone's mark", () => {
  const mark = (east: number, yaw = 0) => ({ north: 0, east, yaw });

  it("is where it was first heard at once, then glides, and stays for what is not to be seen", () => {
    const glide = new Glide(() => undefined);
    glide.to(mark(0), 1, false);
    assert.deepEqual([glide.shown, glide.isGliding], [mark(0), false]);
    glide.to(mark(0.4), 1, false);
    assert.deepEqual([glide.shown, glide.isGliding], [mark(0), false]);
    glide.to(mark(30), 1, false);
    assert.deepEqual([glide.shown, glide.isGliding], [mark(0), true]);
    glide.stop();
  });

  it("jumps where movement is not wanted", () => {
    const glide = new Glide(() => undefined);
    glide.to(mark(0), 1, true);
    glide.to(mark(30, 1), 1, true);
    assert.deepEqual([glide.shown, glide.isGliding], [mark(30, 1), false]);
    glide.to(null, 1, true);
    assert.equal(glide.shown, null);
  });
});

describe("the compass", () => {
  it("turns the map with the drone and back, and the browser keeps it", async () => {
    const { operator } = flying();
    const stage = new Stage(new MapTools(), operator);
    await stage.drawn();
    await stage.press("Turn the map with the drone");
    assert.equal(operator.preferences.droneUp, true);
    assert.equal(stage.button("Turn the map with the drone").getAttribute("aria-pressed"), "true");
    await stage.press("Turn the map with the drone");
    assert.equal(operator.preferences.droneUp, false);
  });
});
