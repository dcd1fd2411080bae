import "./dom.ts";
import assert from "node:assert/strict";
import { before, describe, it } from "node:test";
import type { Plot } from "../src/ui/plot.ts";
import { settle } from "./fakes.ts";

/** Takes every call and draws nothing. */
const NO_CONTEXT: unknown = new Proxy(() => NO_CONTEXT, {
  get: (_, name) => (name === Symbol.toPrimitive ? () => 0 : name === "width" ? 10 : NO_CONTEXT),
  set: () => true,
});

class NoPath {
  readonly moveTo = nothing;
  readonly lineTo = nothing;
  readonly rect = nothing;
}

function nothing(): undefined {
  return undefined;
}

let watched = 0;

class Sizes {
  observe(): void {
    watched += 1;
  }
  disconnect(): void {
    watched = 0;
  }
}

describe("a plot", () => {
  let make: () => Plot;

  before(async () => {
    const canvas = Object.getPrototypeOf(document.createElement("canvas")) as HTMLCanvasElement;
    Object.defineProperty(canvas, "getContext", { value: () => NO_CONTEXT });
    Object.assign(globalThis, {
      ResizeObserver: Sizes,
      getComputedStyle: window.getComputedStyle.bind(window),
      requestAnimationFrame: () => 0,
      Path2D: NoPath,
    });
    const { Plot } = await import("../src/ui/plot.ts");
    make = () => new Plot();
  });

  async function shown(plot: Plot): Promise<void> {
    plot.series = [[-2, -1, 0], [1, 2, 3]];
    document.body.replaceChildren(plot);
    await plot.updateComplete;
    await settle();
  }

  it("is drawn once, and again when it comes back", async () => {
    const plot = make();
    await shown(plot);
    assert.equal(plot.querySelectorAll(".uplot").length, 1);
    plot.remove();
    assert.equal(plot.querySelectorAll(".uplot").length, 0);
    assert.equal(watched, 0);
    await shown(plot);
    assert.equal(plot.querySelectorAll(".uplot").length, 1);
    assert.equal(watched, 1);
  });

  it("that is closed while it waits to be drawn is not made again: the window would keep it", async () => {
    const plot = make();
    await shown(plot);
    plot.series = [[-1, 0], [4, 5]];
    plot.remove();
    await plot.updateComplete;
    await settle();
    assert.equal(plot.querySelectorAll(".uplot").length, 0);
    assert.equal(watched, 0);
  });
});
