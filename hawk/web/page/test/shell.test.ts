import "./dom.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { Route } from "../src/route/route.ts";
import { Guest } from "../src/shell/guest.ts";
import { TopBar, viewsOf } from "../src/shell/top-bar.ts";
import { LateViews } from "../src/shell/views.ts";
import { LotViews } from "../src/views/lot-views.ts";
import { keepClock } from "../src/words/clock.ts";
import * as format from "../src/words/format.ts";
import { settle } from "./fakes.ts";
import { inFrench } from "./french.ts";
import { flying } from "./rig.ts";
import { words } from "./stage.ts";

const LOT = "00000000-0000-4000-8000-000000000001";
const OTHER = "00000000-0000-4000-8000-000000000002";
const ABOUT = { time_zone: "UTC", survey_count: 1, last_survey: null };
const HTML = "<b onclick='alert(1)'>North</b>";

async function bar(place: string): Promise<{ top: TopBar; written: [string, boolean][] }> {
  const written: [string, boolean][] = [];
  const route = new Route({ hash: () => place, write: (hash, replace) => written.push([hash, replace]) });
  const top = Object.assign(new TopBar(), { route, place: route.place, views: ["fly", "lots", "report"], lots: [{ ...ABOUT, id: LOT, name: HTML }, { ...ABOUT, id: OTHER, name: "South" }] });
  document.body.replaceChildren(top);
  await top.updateComplete;
  return { top, written };
}

describe("the bar on every view", () => {
  it("leads to each view of the same lot, and says which one it is", async () => {
    const { top } = await bar(`#/lots/${LOT}/${OTHER}?stall=${OTHER}`);
    const links = [...top.querySelectorAll("nav a")];
    assert.deepEqual(links.map((each) => each.getAttribute("href")), [`#/fly/${LOT}`, `#/lots/${LOT}`, `#/report/${LOT}`]);
    assert.deepEqual(links.map((each) => each.getAttribute("aria-current")), [null, "page", null]);
  });

  it("goes to another lot, whose name is text; its surveys are others", async () => {
    const { top, written } = await bar(`#/lots/${LOT}/${OTHER}`);
    const select = top.querySelector("select")!;
    assert.equal(select.options[0]?.textContent.trim(), HTML);
    select.value = OTHER;
    select.dispatchEvent(new Event("change", { bubbles: true }));
    assert.deepEqual(written, [[`#/lots/${OTHER}`, false]]);
  });

  it("names the lot among hundreds, and leads to the table of all", async () => {
    const { top } = await bar(`#/lots/${LOT}/${OTHER}`);
    top.lots = Array.from({ length: 600 }, (_, k) => ({ ...ABOUT, id: k === 3 ? LOT : `${k}`, name: `Lot ${k}` }));
    await top.updateComplete;
    const link = top.querySelector(".lot a");
    assert.deepEqual([link?.textContent, link?.getAttribute("href")], ["Lot 3", `#/lots/${LOT}?show=all`]);
    assert.equal(top.querySelector(".lot select"), null);
  });

  it("opens the documentation beside the page: the page of a flight is never left", async () => {
    const { top } = await bar("");
    assert.equal(top.querySelector(".help")?.getAttribute("target"), "_blank");
    for (const link of top.querySelectorAll("a:not(.help)")) assert.match(link.getAttribute("href")!, /^#\//);
  });

  it("always leads back to the flight of a drone", () => {
    assert.deepEqual(viewsOf(true, false), ["fly", "lots", "compare", "report", "recordings"]);
    assert.deepEqual(viewsOf(false, false), ["fly", "recordings"]);
    assert.deepEqual(viewsOf(false, true), ["recordings"]);
  });

  it("gives all times the clock of the lot that it names, and draws them again when that is another one", async () => {
    const top = Object.assign((await bar(`#/fly/${OTHER}`)).top, { clocked: () => shown.push(format.clock("2026-05-04T20:30:15Z"), format.day("2026-05-04T20:30:15Z")) });
    const shown: string[] = [];
    for (const time_zone of ["Asia/Tokyo", "America/Toronto", "America/Toronto"]) {
      top.lots = [{ ...ABOUT, id: LOT, name: "North" }, { ...ABOUT, id: OTHER, name: "South", time_zone }];
      await top.updateComplete;
    }
    assert.deepEqual(shown, ["05:30:15", "2026-05-05", "16:30:15", "2026-05-04"]);
    keepClock(undefined);
  });

  it("speaks French", async () => {
    await inFrench(async () => assert.match(words((await bar("")).top), /Voler\s*Parkings\s*Rapport/));
  });
});

describe("a view that is read when it is opened", () => {
  it("says so, and asks again where that failed", async () => {
    let [asked, draws] = [0, 0];
    const guest = new Guest();
    const late = new LateViews(() => (draws += 1), () => (asked++ === 0 ? Promise.reject(new Error("no link")) : Promise.resolve()));
    Object.assign(guest, { late, token: "secret", route: new Route({ hash: () => "#secret", write: () => undefined }, "secret") });
    document.body.replaceChildren(guest);
    await guest.updateComplete;
    assert.match(words(guest), /Lots/);
    assert.doesNotMatch(words(guest), /Fly|Recordings/);
    await settle();
    assert.equal(draws, 1);
    guest.requestUpdate();
    await guest.updateComplete;
    assert.match(guest.querySelector("[role=alert]")?.textContent ?? "", /No answer/);
    guest.querySelector<HTMLButtonElement>(".page button")!.click();
    await settle();
    assert.deepEqual([asked, draws], [2, 2]);
  });
});

describe("the page's end", () => {
  it("is asked about while this operator is in control and the motors are on", () => {
    const rig = flying({ State: "Hover", Armed: true, "In Control": true });
    assert.equal(rig.operator.isFlyingIt, true);
    rig.hear({ "In Control": false });
    assert.equal(rig.operator.isFlyingIt, false, "who watches may go");
    rig.hear({ "In Control": true, State: "Idle", Armed: false });
    assert.equal(rig.operator.isFlyingIt, false);
    rig.hear({ State: "Hover", Armed: null });
    assert.equal(rig.operator.isFlyingIt, true, "the autopilot is silent: the motors may be on");
  });
});

describe("a view without a lot", () => {
  it("says that none is stored only when the drone said so", async () => {
    for (const [lots, unlisted, said] of [[[], "", /No lot is stored yet/], [null, "", /Asking the drone/], [null, "The store is busy.", /The store is busy\./]] as const) {
      const access = { lots, unlisted, token: null, mayChange: true, operator: null, isForSome: false };
      const views = Object.assign(new LotViews(), { route: new Route({ hash: () => "#/report", write: () => undefined }), access });
      document.body.replaceChildren(views);
      await views.updateComplete;
      assert.match(words(views), said);
      assert.equal(words(views).includes("No lot"), lots !== null);
      views.remove();
    }
  });
});
