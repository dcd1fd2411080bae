import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { hashOf, placeOf, unreadOf } from "../src/route/place.ts";
import { Route } from "../src/route/route.ts";

const LOT = "00000000-0000-4000-8000-000000000001";
const ONE = "00000000-0000-4000-8000-00000000000a";
const TWO = "00000000-0000-4000-8000-00000000000b";
const STALL = "00000000-0000-4000-8000-0000000000ff";

describe("the place that the address names", () => {
  it("is written as it was read", () => {
    for (const address of [`#/compare/${LOT}/${ONE}/${TWO}?from=2026-05-04&by=swipe&at=.5`, `#/lots/${LOT}/${ONE}?stall=${STALL}&show=stalls`, `#/lots/${LOT}?show=document&lots=${ONE}&lots=${TWO}`, `#/lots/${LOT}?show=all&search=North+side&order=due`, `#/report/${LOT}?part=row.B&part=zone.West+side&days=mon-fri&hours=7-11%2C16&from=2026-05-01&show=document`, "#/recordings", `#/fly/${LOT}`]) {
      assert.equal(hashOf(placeOf(address)), address);
    }
    assert.equal(placeOf(`#/compare/${LOT}/${ONE}/${TWO}`).after, TWO);
  });

  it("leaves out what is none, and begins at Fly", () => {
    assert.deepEqual(placeOf("#/all/<b>/1?from=yesterday&to=2026-5-4&show=every&part=B&days=monday&hours=noon&by=magic&at=7"), placeOf(""));
    assert.equal(hashOf(placeOf("")), "#/fly");
    assert.equal(placeOf("#/lots/<b>").lot, "");
    for (const [search, read] of [["days=blah", ""], ["days=mon-fri-sun", ""], ["days=fri-mon", "fri-mon"], ["hours=99", ""], ["hours=22-2", ""], ["hours=7-7", ""], ["hours=22-24,0-2", "22-24,0-2"], ["from=2026-02-31", ""], ["from=2026-12-01&to=2026-01-01", "2026-12-01"]] as const) {
      const place = placeOf(`#/report/${LOT}?${search}`);
      assert.equal(place.days + place.hours + place.from + place.to, read, search);
    }
  });

  it("says what of an address is left out, until the person goes on", () => {
    for (const [address, left] of [
      [`#/report/${LOT}?days=blah&hours=7-11&part=row.B&part=B`, ["days=blah", "part=B"]],
      [`#/report/${LOT}?from=2026-12-01&to=2026-01-01`, ["to=2026-01-01"]],
      [`#/lots/${LOT}/nonsense`, ["nonsense"]],
      [`#/lots/${LOT}/${ONE}/more`, ["more"]],
      [`#/recordings/${LOT}/..%2fetc?t=abc`, ["..%2fetc", "t=abc"]],
      ["#/nonsense/x", ["nonsense", "x"]],
      [`#/compare/${LOT}/${ONE}/${TWO}?by=fade&at=.5&utm=1`, []],
      ["", []],
    ] as const) {
      assert.deepEqual(unreadOf(address), left, address);
    }
    const route = new Route({ hash: () => `#/lots/${LOT}?stall=7`, write: () => undefined });
    assert.deepEqual(route.unread, ["stall=7"]);
    route.settle({ lot: ONE });
    assert.deepEqual(route.unread, ["stall=7"]);
    route.go({ view: "report" });
    assert.deepEqual(route.unread, []);
  });
});

describe("the address", () => {
  it("whose lots cannot all be read opens the list of all, and no report over others", () => {
    for (const lots of ["lots=nope", `lots=${ONE}&lots=${TWO.slice(0, 20)}`]) {
      assert.equal(placeOf(`#/lots/${LOT}?show=document&${lots}`).show, "all", lots);
      assert.ok(unreadOf(`#/lots/${LOT}?show=document&${lots}`).length > 0, lots);
    }
    assert.equal(placeOf(`#/lots/${LOT}?show=document`).show, "document");
  });

  it("changes in place within a view, and by a step that goes back between views", () => {
    const written: [string, boolean][] = [];
    const route = new Route({ hash: () => `#/lots/${LOT}`, write: (hash, replace) => written.push([hash, replace]) });
    route.go({ survey: ONE });
    route.go({ view: "report", survey: "" });
    assert.deepEqual(written, [[`#/lots/${LOT}/${ONE}`, true], [`#/report/${LOT}`, false]]);
  });

  it("of a shared lot keeps its token, and has no flight", () => {
    const written: string[] = [];
    const route = new Route({ hash: () => `#secret/compare`, write: (hash) => written.push(hash) }, "secret");
    assert.equal(route.place.view, "compare");
    route.go({ view: "lots", survey: ONE });
    assert.deepEqual(written, [`#secret/lots//${ONE}`]);
    assert.equal(new Route({ hash: () => "#secret", write: () => undefined }, "secret").place.view, "lots");
  });
});
