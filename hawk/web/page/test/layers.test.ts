import "./dom.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { EMPTY_SCENE, type Scene, withLayers } from "../src/map/flight-scene.ts";
import { ALL_LAYERS, readPreferences, writePreferences } from "../src/state/preferences.ts";
import { MapTools } from "../src/ui/map-tools.ts";
import { FakeStorage } from "./fakes.ts";
import { flying } from "./rig.ts";
import { Stage } from "./stage.ts";

const PLACE = { North: 1, East: 2 };
const SCENE: Scene = {
  ...EMPTY_SCENE,
  fence: [PLACE],
  limit: [PLACE],
  zones: [[PLACE]],
  zoneLimits: [[PLACE]],
  outline: [[PLACE]],
  trail: [PLACE],
  home: PLACE,
  drone: { north: 0, east: 0, yaw: 0 },
  selected: { north: 0, east: 0, angle: 0, width: 2, length: 5 },
};

describe("what is left out of the map", () => {
  it("is nothing while every layer is on", () => {
    assert.deepEqual(withLayers(SCENE, ALL_LAYERS, false), SCENE);
  });

  it("is the fence with its zones, the trail, or the chosen stall, each alone", () => {
    const bare = { ...SCENE, fence: [], limit: [], zones: [], zoneLimits: [] };
    assert.deepEqual(withLayers(SCENE, { ...ALL_LAYERS, fence: false }, false), bare);
    assert.deepEqual(withLayers(SCENE, { ...ALL_LAYERS, trail: false }, false), { ...SCENE, trail: [] });
    assert.deepEqual(withLayers(SCENE, { ...ALL_LAYERS, outline: false }, false), { ...SCENE, outline: [] });
    assert.deepEqual(withLayers(SCENE, { ...ALL_LAYERS, stalls: false }, false), { ...SCENE, selected: null });
  });

  it("is never the fence while a place to fly to is chosen", () => {
    assert.deepEqual(withLayers(SCENE, { ...ALL_LAYERS, fence: false }, true).fence, [PLACE]);
  });

  it("is never the drone or its home", () => {
    const off = { stalls: false, picture: false, fence: false, outline: false, trail: false, background: false };
    const { drone, home } = withLayers(SCENE, off, false);
    assert.deepEqual({ drone, home }, { drone: SCENE.drone, home: PLACE });
  });
});

describe("the choice of layers", () => {
  it("is kept by the browser, and one that cannot be read is on", () => {
    const storage = new FakeStorage();
    const chosen = { ...readPreferences(storage), layers: { ...ALL_LAYERS, trail: false } };
    writePreferences(storage, chosen);
    assert.deepEqual(readPreferences(storage), chosen);
    storage.setItem("hawk-page", JSON.stringify({ layers: { stalls: "no", picture: false } }));
    assert.deepEqual(readPreferences(storage).layers, { ...ALL_LAYERS, picture: false });
    storage.setItem("hawk-page", JSON.stringify({ layers: 3 }));
    assert.deepEqual(readPreferences(storage).layers, ALL_LAYERS);
  });

  it("is made in a panel that Escape closes, and that gives the focus back", async () => {
    const { operator } = flying();
    const stage = new Stage(new MapTools(), operator);
    await stage.drawn();
    assert.equal(stage.has(".layers"), false);
    await stage.press("Layers");
    assert.equal(document.activeElement, stage.find("input[name=stalls]"));
    const fence = stage.input("input[name=fence]");
    fence.checked = false;
    fence.dispatchEvent(new Event("change"));
    assert.deepEqual(operator.preferences.layers, { ...ALL_LAYERS, fence: false });
    const escape = new KeyboardEvent("keydown", { key: "Escape", bubbles: true, cancelable: true });
    fence.dispatchEvent(escape);
    await stage.drawn();
    assert.deepEqual([stage.has(".layers"), escape.defaultPrevented], [false, true]);
    assert.equal(document.activeElement, stage.button("Layers"));
  });
});
