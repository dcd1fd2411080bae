import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { deflateSync } from "node:zlib";
import { DaemonClock } from "../src/state/daemon-clock.ts";
import { Flight, isFlying, type Sample } from "../src/state/flight.ts";
import { MapStore } from "../src/state/map-store.ts";
import { type Moment, PlotHistory } from "../src/state/plot-history.ts";
import { readPreferences, STANDARD, writePreferences } from "../src/state/preferences.ts";
import { cellAt, inflateTile } from "../src/state/tile-data.ts";
import { FakeStorage } from "./fakes.ts";
import { heartbeat, mapUpdate, stall, welcome } from "./make.ts";
import { flying } from "./rig.ts";

describe("the map", () => {
  it("takes stalls, changes and removals", () => {
    const map = new MapStore();
    map.apply(mapUpdate({ Stalls: [stall(1), stall(2)] }));
    const change = map.apply(mapUpdate({ Stalls: [stall(1, { State: "taken" }), stall(2, { Removed: true })] }));
    assert.deepEqual([change.stalls, change.removed], [[1], [2]]);
    assert.deepEqual([...map.stalls.values()].map((each) => each.state), ["taken"]);
  });

  it("leaves a stall without a place alone, and calls one without a state unclear", () => {
    const map = new MapStore();
    map.apply(mapUpdate({ Stalls: [stall(1, { North: null }), stall(2, { State: null })] }));
    assert.deepEqual([...map.stalls.keys()], [2]);
    assert.equal(map.stalls.get(2)?.state, "unknown");
  });

  it("takes each version of a tile and a picture once", () => {
    const map = new MapStore();
    const update = mapUpdate({
      Tiles: [{ Row: -1, Column: 0, Version: 3, Data: "x" }],
      Mosaic: [{ Row: -1, Column: 0, Version: 2 }],
    });
    assert.equal(map.apply(update).tiles.length, 1);
    const again = map.apply(update);
    assert.deepEqual([again.tiles, again.pictures], [[], []]);
    const next = map.apply(mapUpdate({ Tiles: [{ Row: -1, Column: 0, Version: 4, Data: "y" }] }));
    assert.deepEqual(next.tiles, [{ key: { row: -1, column: 0 }, version: 4, data: "y" }]);
  });

  it("gives all that is there to a map that begins later, the newest version of each tile", () => {
    const map = new MapStore();
    const at = { Row: -1, Column: 0 };
    map.apply(mapUpdate({ Stalls: [stall(1), stall(2)], Tiles: [{ ...at, Version: 3, Data: "x" }], Mosaic: [{ ...at, Version: 2 }] }));
    map.apply(mapUpdate({ Stalls: [stall(1, { Removed: true })], Tiles: [{ ...at, Version: 4, Data: "y" }] }));
    const key = { row: -1, column: 0 };
    assert.deepEqual(map.whole(), { reset: true, stalls: [2], removed: [], tiles: [{ key, version: 4, data: "y" }], pictures: [{ key, version: 2 }] });
  });

  it("forgets everything when another map begins", () => {
    const map = new MapStore();
    map.apply(mapUpdate({ Stalls: [stall(1)] }));
    const change = map.apply(mapUpdate({ "Map Id": "b", Stalls: [stall(9)] }));
    assert.equal(change.reset, true);
    assert.deepEqual([...map.stalls.keys()], [9]);
  });

  it("keeps what it has over a lost link until the server sends it again", () => {
    const map = new MapStore();
    map.apply(mapUpdate({ Stalls: [stall(1), stall(2)] }));
    map.expectAll();
    assert.equal(map.stalls.size, 2);
    assert.equal(map.apply(mapUpdate({ Stalls: [stall(2)] })).reset, true);
    assert.deepEqual([...map.stalls.keys()], [2]);
    assert.equal(map.apply(mapUpdate({ Stalls: [stall(3)] })).reset, false);
  });
});

describe("the plots over a reload", () => {
  const moment = (seconds: number, theirs: number, rate = 1): Moment => ({ at: seconds, theirs, wall: 5_000_000 + seconds * 1000, rate });
  const sample = (at: number, theirs: number): Sample => ({ at, theirs, height: 20.04, battery: 80 });

  it("go on at their own ages, with a gap in which nothing was heard", () => {
    const storage = new FakeStorage();
    new PlotHistory(storage).keep([sample(98, 298), sample(99, 299), sample(100, 300)], moment(100, 300));
    const reloaded = { ...moment(0, 305), wall: 5_105_000, at: 2 };
    const read = new PlotHistory(storage).read(reloaded);
    assert.deepEqual(read.map((each) => Math.round(each.at)), [-5, -4, -3, -3]);
    assert.deepEqual(read.map((each) => each.height), [20, 20, 20, null], "the last one breaks the curve");
  });

  it("are those of the daemon's own clock, whose seconds may be shorter", () => {
    const storage = new FakeStorage();
    new PlotHistory(storage).keep([sample(100, 400)], moment(100, 400, 4));
    const read = new PlotHistory(storage).read({ at: 1, theirs: 440, wall: 5_110_000, rate: 4 });
    assert.equal(read[0]?.at, -9);
  });

  it("are not those of a daemon that started again, nor of long ago, nor what cannot be read", () => {
    const storage = new FakeStorage();
    new PlotHistory(storage).keep([sample(100, 300)], moment(100, 300));
    assert.deepEqual(new PlotHistory(storage).read({ at: 0, theirs: 5, wall: 5_105_000, rate: 1 }), [], "another start");
    assert.deepEqual(new PlotHistory(storage).read({ at: 0, theirs: 3300, wall: 8_100_000, rate: 1 }), [], "50 minutes ago");
    for (const text of ["{", "null", "3", '{"start": 1}', '{"start": 4800, "samples": [["x", 1, 2], 7, [1, 2]]}']) {
      storage.setItem("hawk-plots", text);
      assert.deepEqual(new PlotHistory(storage).read(moment(101, 301)), [], text);
    }
  });

  it("are kept every ten seconds, and not where nothing can be kept", () => {
    const storage = new FakeStorage();
    const history = new PlotHistory(storage);
    history.keep([sample(100, 300)], moment(100, 300));
    history.keep([sample(100, 300), sample(105, 305)], moment(105, 305));
    assert.equal(new PlotHistory(storage).read(moment(105, 305)).length, 2);
    history.keep([sample(100, 300), sample(110, 310)], moment(110, 310));
    assert.equal(new PlotHistory(storage).read(moment(110, 310)).length, 3);
    const full = { getItem: () => null, setItem: () => assert.fail("full") };
    new PlotHistory(full).keep([sample(1, 1)], moment(1, 1));
  });

  it("reach the page that was loaded again", () => {
    const session = new FakeStorage();
    const before = flying({}, session);
    before.timers.advance(10_000);
    before.hear({ Time: 110, "Relative Altitude": 12 });
    const after = flying({ Time: 100 }, session);
    assert.ok(after.operator.flight.samples.length >= 2);
    const another = flying({ Time: 3 }, session);
    assert.equal(another.operator.flight.samples.length, 1);
  });
});

describe("tiles", () => {
  it("are inflated, and refused when they have another size", async () => {
    const cells = Uint8Array.from({ length: 16 }, (_, index) => index % 5);
    const packed = (bytes: Uint8Array): string => deflateSync(bytes).toString("base64");
    assert.deepEqual(await inflateTile(packed(cells), 4), cells);
    await assert.rejects(inflateTile(packed(cells.slice(1)), 4), /15 bytes instead of 16/);
    await assert.rejects(inflateTile("AAAA", 4));
  });

  it("have row 0 south of the datum, and their first cell in the north-west corner", () => {
    assert.deepEqual(cellAt(-0.05, 0.05, 256, 0.1), { row: 0, column: 0, index: 0 });
    assert.deepEqual(cellAt(-0.15, 0.25, 256, 0.1), { row: 0, column: 0, index: 258 });
    assert.deepEqual(cellAt(25.55, -25.55, 256, 0.1), { row: -1, column: -1, index: 0 });
    assert.deepEqual(cellAt(0.05, -0.05, 256, 0.1), { row: -1, column: -1, index: 256 * 256 - 1 });
  });
});

describe("the daemon's clock", () => {
  it("is not known before the first heartbeat", () => {
    assert.equal(new DaemonClock().at(5), null);
  });

  it("goes by the least delayed heartbeat", () => {
    const clock = new DaemonClock();
    clock.add(10, 100);
    clock.add(10.5, 100.2);
    assert.equal(clock.at(11), 101);
  });

  it("runs as fast as the simulation", () => {
    const clock = new DaemonClock();
    clock.reset(4);
    clock.add(10, 100);
    assert.equal(clock.at(12), 108);
    clock.reset(1);
    assert.equal(clock.at(12), null);
  });
});

describe("the flight", () => {
  const entry = (Number: number, Time: string) => ({ Number, Time, Level: "info" as const, Text: `${Number}`, Details: "" });

  it("lists messages newest first, each once, beside the page's own", () => {
    const flight = new Flight();
    flight.hear(heartbeat({ Messages: [entry(1, "2026-01-01T00:00:01Z"), entry(2, "2026-01-01T00:00:02Z")] }), 0);
    flight.note("warning", "Link lost.", "2026-01-01T00:00:03Z");
    flight.hear(heartbeat({ Messages: [entry(2, "2026-01-01T00:00:02Z"), entry(3, "2026-01-01T00:00:04Z")] }), 1);
    assert.deepEqual(flight.lines.map((line) => line.text), ["3", "Link lost.", "2", "1"]);
  });

  it("takes trail and messages again from another connection, and keeps its own lines", () => {
    const flight = new Flight();
    flight.hear(heartbeat({ Messages: [entry(1, "a")], Trail: [{ North: 1, East: 1 }] }), 0);
    flight.note("warning", "Link lost.", "b");
    flight.greet(welcome());
    assert.equal(flight.trail.length, 1);
    flight.hear(heartbeat({ Trail: [{ North: 2, East: 2 }] }), 1);
    assert.deepEqual(flight.trail, [{ North: 2, East: 2 }]);
    assert.deepEqual(flight.lines.map((line) => line.text), ["Link lost."]);
  });

  it("begins the trail again when the drone does", () => {
    const flight = new Flight();
    flight.hear(heartbeat({ Trail: [{ North: 1, East: 1 }] }), 0);
    flight.hear(heartbeat({ Trail: [{ North: 2, East: 2 }] }), 1);
    assert.equal(flight.trail.length, 2);
    flight.hear(heartbeat({ Trail: [{ North: 3, East: 3 }], "Trail Start": true }), 2);
    assert.deepEqual(flight.trail, [{ North: 3, East: 3 }]);
    flight.hear(heartbeat({ "Trail Start": true }), 3);
    assert.deepEqual(flight.trail, []);
  });

  it("notes when the motors stopped, until they run again", () => {
    const flight = new Flight();
    flight.hear(heartbeat({ Armed: false }), 0);
    assert.equal(flight.landedAt, null);
    flight.hear(heartbeat({ Armed: true }), 1);
    flight.hear(heartbeat({ Armed: false, Utc: "2026-01-02T00:00:00Z" }), 2);
    assert.equal(flight.landedAt, "2026-01-02T00:00:00Z");
    flight.hear(heartbeat({ Armed: null }), 3);
    assert.equal(flight.landedAt, "2026-01-02T00:00:00Z");
    flight.hear(heartbeat({ Armed: true }), 4);
    assert.equal(flight.landedAt, null);
  });

  it("samples the plots once a second", () => {
    const flight = new Flight();
    for (let tick = 0; tick < 11; tick += 1) flight.hear(heartbeat(), tick / 5);
    assert.deepEqual(flight.samples.map((sample) => sample.at), [0, 1, 2]);
  });

  it("distinguishes flying from standing", () => {
    assert.equal(isFlying(null), false);
    assert.equal(isFlying(heartbeat({ State: "Arm", Landed: "ON_GROUND" })), false);
    assert.equal(isFlying(heartbeat({ State: "Land", Landed: "ON_GROUND" })), false);
    assert.equal(isFlying(heartbeat({ State: "Land", Landed: "LANDING" })), true);
    assert.equal(isFlying(heartbeat({ State: "Takeoff", Landed: "TAKING_OFF" })), true);
    assert.equal(isFlying(heartbeat({ State: "Manual", Armed: null, Landed: "UNDEFINED" })), true);
  });
});

describe("preferences", () => {
  it("come back as they were stored", () => {
    const storage = new FakeStorage();
    assert.deepEqual(readPreferences(storage), STANDARD);
    const chosen = { ...STANDARD, theme: "dark", leftHanded: true, name: "Ana", sound: false, units: "feet", droneUp: true } as const;
    writePreferences(storage, chosen);
    assert.deepEqual(readPreferences(storage), chosen);
  });

  it("are as standard when nothing sensible is stored or nothing can be", () => {
    for (const stored of ["{", "null", '{"theme":"pink","leftHanded":"yes"}', "7"]) {
      const storage = new FakeStorage();
      storage.setItem("hawk-page", stored);
      assert.deepEqual(readPreferences(storage), STANDARD);
    }
    const full = { getItem: () => null, setItem: () => assert.fail("full") };
    assert.doesNotThrow(() => writePreferences(full, STANDARD));
  });
});
