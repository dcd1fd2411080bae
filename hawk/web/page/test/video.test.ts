import "./dom.ts";
import assert from "node:assert/strict";
import { afterEach, describe, it } from "node:test";
import { HEADER_BYTES } from "../src/link/video.ts";
import type { VideoPanel as Panel } from "../src/ui/video-panel.ts";
import { pictureWords, snapshotName } from "../src/words/picture.ts";
import { FakeServer, settle } from "./fakes.ts";
import { flying } from "./rig.ts";
import { Stage } from "./stage.ts";

Object.defineProperty(globalThis, "location", { value: { protocol: "http:", host: "drone:3000" }, configurable: true });
const { VideoPanel } = await import("../src/ui/video-panel.ts");

class Bitmap {
  width = 96;
  height = 54;
}

function frame(sequence: number): ArrayBuffer {
  const buffer = new ArrayBuffer(HEADER_BYTES + 3);
  const bytes = new DataView(buffer);
  for (let index = 0; index < 4; index += 1) bytes.setUint8(index, "HWK1".charCodeAt(index));
  bytes.setUint32(4, sequence, true);
  bytes.setFloat64(8, 99.9, true);
  bytes.setUint8(HEADER_BYTES, sequence);
  return buffer;
}

/** The panel with its own server; every picture can be decoded. */
async function shown(changes = {}): Promise<{ stage: Stage<Panel>; server: FakeServer; rig: ReturnType<typeof flying> }> {
  Object.defineProperty(globalThis, "createImageBitmap", { value: () => Promise.resolve(new Bitmap()), configurable: true });
  const rig = flying(changes);
  const server = new FakeServer();
  const panel = new VideoPanel();
  panel.open = server.open;
  const stage = new Stage(panel, rig.operator);
  await stage.drawn();
  return { stage, server, rig };
}

async function say(server: FakeServer, stage: Stage<Panel>, sequence: number): Promise<void> {
  server.last.say(frame(sequence));
  await settle();
  await stage.drawn();
}

/** A window as the browser opens it for Document Picture-in-Picture. */
class SmallWindow {
  readonly document = document.implementation.createHTMLDocument("");
  readonly drawn: unknown[] = [];
  ticks: (() => void)[] = [];
  closed: (() => void)[] = [];
  setInterval(run: () => void): number {
    this.ticks.push(run);
    return 1;
  }
  clearInterval(): void {
    this.ticks = [];
  }
  addEventListener(_name: string, run: () => void): void {
    this.closed.push(run);
  }
  close(): void {
    for (const each of this.closed) each();
  }
}

function offer(small: SmallWindow | null): void {
  const windows = small && { requestWindow: () => Promise.resolve(small) };
  Object.defineProperty(window, "documentPictureInPicture", { value: windows ?? undefined, configurable: true });
}

function hide(hidden: boolean): void {
  Object.defineProperty(document, "hidden", { value: hidden, configurable: true });
  document.dispatchEvent(new Event("visibilitychange"));
}

afterEach(() => {
  offer(null);
  hide(false);
  document.body.replaceChildren();
});

describe("the words of a picture", () => {
  it("name its time and place in the file name", () => {
    const at = Date.UTC(2026, 10, 24, 15, 48, 1, 900);
    assert.equal(
      snapshotName(at, { latitude: 43.260123, longitude: -79.920341 }, false),
      "hawk-2026-11-24T15-48-01Z-43.26012N-79.92034W.jpg",
    );
    assert.equal(snapshotName(at, { latitude: -1, longitude: 2 }, true), "hawk-simulation-2026-11-24T15-48-01Z-1.00000S-2.00000E.jpg");
    assert.equal(snapshotName(at, { latitude: null, longitude: 2 }, false), "hawk-2026-11-24T15-48-01Z.jpg");
  });

  it("never call an old picture live", () => {
    assert.equal(pictureWords(0.3, false), "Live, 0.3 s");
    assert.equal(pictureWords(0.3, true), "Simulation, 0.3 s");
    assert.equal(pictureWords(5, false), "5 s old");
    assert.equal(pictureWords(5, true), "Simulation, 5 s old");
    assert.equal(pictureWords(null, false), "No picture yet");
  });
});

describe("saving a picture", () => {
  it("is impossible before the first, then saves the newest one's bytes under its name", async (context) => {
    const { stage, server } = await shown({ Latitude: 43.5, Longitude: -79.5 });
    assert.ok(!stage.enabled().includes("Save this picture"));
    server.last.accept();
    await say(server, stage, 7);
    await say(server, stage, 8);
    const saved: Blob[] = [];
    const names: string[] = [];
    context.mock.method(URL, "createObjectURL", (blob: Blob) => {
      saved.push(blob);
      return "blob:drone";
    });
    context.mock.method(URL, "revokeObjectURL", () => undefined);
    const anchor = Object.getPrototypeOf(document.createElement("a")) as HTMLAnchorElement;
    context.mock.method(anchor, "click", function (this: HTMLAnchorElement) {
      if (this.tagName === "A") names.push(this.download);
      else this.dispatchEvent(new Event("click"));
    });
    await stage.press("Save this picture");
    assert.equal(saved.length, 1);
    assert.deepEqual([...new Uint8Array(await saved[0]!.arrayBuffer())], [8, 0, 0]);
    assert.match(names[0] ?? "", /^hawk-\d{4}-\d\d-\d\dT\d\d-\d\d-\d\dZ-43\.50000N-79\.50000W\.jpg$/);
  });
});

describe("the small window", () => {
  it("is not offered where the browser has none", async () => {
    const { stage } = await shown();
    assert.deepEqual(stage.enabled(), ["Swap map and video", "Full screen"]);
  });

  it("keeps the pictures coming while the page is hidden, and no longer", async () => {
    const small = new SmallWindow();
    offer(small);
    const { stage, server } = await shown();
    server.last.accept();
    await stage.press("Show in a small window");
    hide(true);
    assert.equal(server.last.closed, false);
    small.close();
    assert.equal(server.last.closed, true);
    await stage.drawn();
    assert.ok(stage.enabled().includes("Show in a small window"));
  });

  it("marks its picture as old by itself", async () => {
    const small = new SmallWindow();
    offer(small);
    const { stage, server, rig } = await shown({ Time: 100 });
    server.last.accept();
    await stage.press("Show in a small window");
    assert.match(small.document.body.textContent, /No picture yet/);
    await say(server, stage, 1);
    assert.match(small.document.body.textContent, /Live, 0\.\d s/);
    rig.timers.advance(10_000);
    small.ticks[0]?.();
    assert.match(small.document.body.textContent, /^10 s old$/);
    assert.match(small.document.querySelector("canvas")?.style.filter ?? "", /grayscale/);
  });

  it("ends with the page's own picture", async () => {
    const small = new SmallWindow();
    offer(small);
    const { stage, server } = await shown();
    await stage.press("Show in a small window");
    stage.part.remove();
    assert.deepEqual(small.ticks, []);
    assert.ok(server.sockets.every((each) => each.closed));
  });
});
