import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { ANSWER_MS, Commands } from "../src/link/commands.ts";
import { BACKOFF_MS, type LinkStatus, ReconnectingSocket, SILENCE_MS } from "../src/link/reconnect.ts";
import { socketUrl } from "../src/link/socket.ts";
import { HEADER_BYTES, readFrame, VideoLink } from "../src/link/video.ts";
import { FakeServer, FakeTimers, settle } from "./fakes.ts";

function connected(): {
  timers: FakeTimers;
  server: FakeServer;
  heard: (string | ArrayBuffer)[];
  states: LinkStatus[];
  link: ReconnectingSocket;
} {
  const timers = new FakeTimers();
  const server = new FakeServer();
  const heard: (string | ArrayBuffer)[] = [];
  const states: LinkStatus[] = [];
  const handlers = { message: (data: string | ArrayBuffer) => heard.push(data), status: (status: LinkStatus) => states.push(status) };
  const link = new ReconnectingSocket("ws://drone/ws", server.open, timers, handlers);
  link.connect();
  return { timers, server, heard, states, link };
}

describe("the socket", () => {
  it("has the scheme of the page", () => {
    assert.equal(socketUrl("ws", "http://drone:3000/"), "ws://drone:3000/ws");
    assert.equal(socketUrl("ws", "https://drone/?view=map"), "wss://drone/ws");
  });

  it("is beside the page under a sub-path of a proxy", () => {
    assert.equal(socketUrl("ws", "https://drones.example/hawk-1/"), "wss://drones.example/hawk-1/ws");
    assert.equal(socketUrl("video", "https://drones.example/hawk-1/index.html"), "wss://drones.example/hawk-1/video");
  });

  it("connects again by itself, waiting longer each time", () => {
    const { timers, server, link } = connected();
    for (const [index, wait] of [...BACKOFF_MS, 4000].entries()) {
      server.last.break();
      assert.equal(link.status, "waiting");
      timers.advance(wait - 1);
      assert.equal(server.sockets.length, index + 1);
      timers.advance(1);
      assert.equal(server.sockets.length, index + 2);
    }
  });

  it("begins with short waits again after a message", () => {
    const { timers, server } = connected();
    server.last.break();
    timers.advance(BACKOFF_MS[0]!);
    server.last.accept();
    server.last.say({});
    server.last.break();
    timers.advance(BACKOFF_MS[0]!);
    assert.equal(server.sockets.length, 3);
  });

  it("gives up a socket that says nothing", () => {
    const { timers, server, link } = connected();
    server.last.accept();
    timers.advance(SILENCE_MS - 1);
    assert.equal(link.status, "open");
    timers.advance(1);
    assert.equal(link.status, "waiting");
    assert.ok(server.sockets[0]?.closed);
  });

  it("does not listen to a socket that it gave up", () => {
    const { server, heard, link } = connected();
    const old = server.last;
    const late = old.onmessage;
    link.connect();
    late?.({ data: "late" } as MessageEvent);
    assert.deepEqual(heard, []);
  });

  it("sends only when open, and stays closed when it was closed", () => {
    const { timers, server, link } = connected();
    assert.equal(link.send("x"), false);
    server.last.accept();
    assert.equal(link.send("x"), true);
    assert.deepEqual(server.last.sent, ["x"]);
    link.close();
    timers.advance(60_000);
    assert.equal(server.sockets.length, 1);
    assert.equal(link.status, "closed");
  });
});

describe("commands", () => {
  it("pair answers by their Id, in any order", async () => {
    const sent: { Id: string }[] = [];
    const commands = new Commands((text) => sent.push(JSON.parse(text) as { Id: string }) > 0, new FakeTimers());
    const [arm, hold] = [commands.send({ Type: "Arm" }), commands.send({ Type: "Hold" })];
    commands.answer({ Type: "Ack", Id: sent[1]!.Id, Accepted: true, Reason: "" });
    commands.answer({ Type: "Ack", Id: sent[0]!.Id, Accepted: false, Reason: "no" });
    assert.equal((await hold as { Accepted: boolean }).Accepted, true);
    assert.equal((await arm as { Reason: string }).Reason, "no");
  });

  it("say so when there is no link, no answer, or the link breaks", async () => {
    const timers = new FakeTimers();
    const none = await new Commands(() => false, timers).send({ Type: "Arm" });
    assert.match((none as { Reason: string }).Reason, /Nothing was sent/);
    const commands = new Commands(() => true, timers);
    const silent = commands.send({ Type: "Arm" });
    timers.advance(ANSWER_MS);
    assert.match((await silent as { Reason: string }).Reason, /No answer/);
    const broken = commands.send({ Type: "Arm" });
    commands.abandon();
    assert.match((await broken as { Reason: string }).Reason, /link was lost/);
  });

  it("ignore an answer that nobody waits for", () => {
    const commands = new Commands(() => true, new FakeTimers());
    assert.doesNotThrow(() => commands.answer({ Type: "Ack", Id: null, Accepted: false, Reason: "not JSON" }));
  });
});

function frame(sequence: number, captured = 12.5): ArrayBuffer {
  const buffer = new ArrayBuffer(HEADER_BYTES + 3);
  const bytes = new DataView(buffer);
  for (let index = 0; index < 4; index += 1) bytes.setUint8(index, "HWK1".charCodeAt(index));
  bytes.setUint32(4, sequence, true);
  bytes.setFloat64(8, captured, true);
  bytes.setUint8(HEADER_BYTES, 0xff);
  return buffer;
}

describe("video", () => {
  it("reads sequence, capture time and picture", () => {
    const read = readFrame(frame(7));
    assert.equal(read?.sequence, 7);
    assert.equal(read.captureTime, 12.5);
    assert.deepEqual([...read.jpeg], [0xff, 0, 0]);
  });

  it("takes nothing else for a frame", () => {
    assert.equal(readFrame(new ArrayBuffer(HEADER_BYTES)), null);
    const wrong = frame(1);
    new DataView(wrong).setUint8(0, 0);
    assert.equal(readFrame(wrong), null);
  });

  it("asks for the next frame only when the last one is shown", async () => {
    const server = new FakeServer();
    let shown: (() => void) | undefined;
    const video = new VideoLink("ws://drone/video", server.open, new FakeTimers(), () => new Promise((done) => (shown = done)));
    video.start();
    server.last.accept();
    server.last.say(frame(3));
    await settle();
    assert.deepEqual(server.last.sent, []);
    shown?.();
    await settle();
    assert.deepEqual(server.last.sent, ['{"ack":3}']);
    video.stop();
    assert.ok(server.last.closed);
  });

  it("goes on after a picture that cannot be shown", async (context) => {
    const server = new FakeServer();
    const warned = context.mock.method(console, "warn", () => undefined);
    const video = new VideoLink("ws://drone/video", server.open, new FakeTimers(), () => Promise.reject(new Error("broken")));
    video.start();
    server.last.accept();
    server.last.say(frame(4));
    await settle();
    assert.deepEqual(server.last.sent, ['{"ack":4}']);
    assert.equal(warned.mock.callCount(), 1);
  });
});
