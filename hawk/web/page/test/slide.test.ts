import "./dom.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { Slide } from "../src/ui/slide.ts";
import { settle } from "./fakes.ts";
import { Frames, words } from "./stage.ts";

interface Scene {
  slide: Slide;
  track: HTMLButtonElement;
  frames: Frames;
  confirmed: () => number;
}

async function shown(): Promise<Scene> {
  const frames = new Frames();
  const slide = new Slide();
  slide.text = "Slide to move";
  let count = 0;
  slide.addEventListener("confirmed", () => (count += 1));
  document.body.replaceChildren(slide);
  await slide.updateComplete;
  const track = slide.querySelector("button")!;
  track.setPointerCapture = () => undefined;
  return { slide, track, frames, confirmed: () => count };
}

function key(type: string, more: KeyboardEventInit = {}): KeyboardEvent {
  return new KeyboardEvent(type, { key: "Enter", bubbles: true, ...more });
}

function pointer(type: string, clientX: number): PointerEvent {
  return new PointerEvent(type, { button: 0, clientX, bubbles: true });
}

describe("the slide", () => {
  it("is done by Enter that was kept pressed for a second, and not by a shorter press", async () => {
    const { track, frames, confirmed } = await shown();
    track.dispatchEvent(key("keydown"));
    frames.advance(900);
    track.dispatchEvent(key("keyup"));
    frames.advance(2000);
    assert.equal(confirmed(), 0);
    track.dispatchEvent(key("keydown"));
    frames.advance(1100);
    assert.equal(confirmed(), 1);
  });

  it("is not done by a short press on a busy page, whenever that comes to handle the release", async () => {
    const { slide, track, frames, confirmed } = await shown();
    track.dispatchEvent(key("keydown"));
    frames.advance(100);
    const up = key("keyup");
    frames.stall(1500);
    frames.run();
    track.dispatchEvent(up);
    frames.advance(2000);
    await settle();
    assert.equal(confirmed(), 0);
    assert.match(words(slide), /The page was busy: again/);
  });

  it("is not done by a key that was pressed for something else and repeats itself", async () => {
    const { track, frames, confirmed } = await shown();
    for (let repeat = 0; repeat < 60; repeat += 1) {
      track.dispatchEvent(key("keydown", { repeat: true }));
      frames.advance(50);
    }
    assert.equal(confirmed(), 0);
  });

  it("is not done once the window lost the focus, it was disabled, or it is gone", async () => {
    const ends: ((slide: Slide) => void)[] = [
      () => window.dispatchEvent(new Event("blur")),
      () => document.dispatchEvent(new Event("visibilitychange")),
      (slide) => (slide.disabled = true),
      (slide) => slide.remove(),
    ];
    for (const end of ends) {
      const { slide, track, frames, confirmed } = await shown();
      track.dispatchEvent(key("keydown"));
      frames.advance(500);
      end(slide);
      await settle();
      frames.advance(2000);
      assert.equal(confirmed(), 0, String(end));
    }
  });

  it("is done by a pointer that slid to the end, unless that was cancelled or it was disabled meanwhile", async () => {
    for (const [type, disabled, done] of [["pointerup", false, 1], ["pointercancel", false, 0], ["pointerup", true, 0]] as const) {
      const { slide, track, confirmed } = await shown();
      track.dispatchEvent(pointer("pointerdown", 10));
      track.dispatchEvent(pointer("pointermove", 300));
      slide.disabled = disabled;
      await settle();
      track.dispatchEvent(pointer(type, 300));
      assert.equal(confirmed(), done, `${type} ${disabled}`);
    }
  });
});
