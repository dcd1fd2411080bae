import "./dom.ts";
import "./no-drawing.ts";
import assert from "node:assert/strict";
import { afterEach, beforeEach, describe, it } from "node:test";
import { Route } from "../src/route/route.ts";
import "../src/parts/figures.ts";
import { LotViews } from "../src/views/lot-views.ts";
import { settle } from "./fakes.ts";
import { inFrench } from "./french.ts";
import { words } from "./stage.ts";

const LOT = "00000000-0000-4000-8000-000000000001";
const ONE = "00000000-0000-4000-8000-00000000000a";
const HTML = "<b onclick='alert(1)'>North</b>";
const CAME = { seq: 2, at: "2026-05-04T10:00:00Z", sender: "Drone 1", kind: "survey", name: ONE, lot: LOT, state: 3, outcome: "taken", reason: "", times: 1 };
const GUESS = { ...CAME, seq: 1, sender: "", kind: "other", name: `PUT ${HTML}`, lot: null, state: null, outcome: "refused", reason: HTML, times: 3 };
const OF_DRONE = { id: LOT, name: HTML, last_survey: { drone: "Drone 1" } };

describe("what drones sent to a desk", () => {
  const before = globalThis.fetch;
  let asked: string[];
  let hash: string;
  let views: LotViews;

  beforeEach(() => {
    asked = [];
    globalThis.fetch = (address) => {
      asked.push(address as string);
      return Promise.resolve(Response.json({ items: [CAME, GUESS], next: "1" }));
    };
  });

  afterEach(() => {
    globalThis.fetch = before;
  });

  async function drawn(): Promise<void> {
    for (let k = 0; k < 6; k++) {
      await settle();
      await views.updateComplete;
    }
  }

  async function open(at: string, access: object = {}): Promise<void> {
    hash = at;
    const route = new Route({ hash: () => hash, write: (next: string) => (hash = next) }, "");
    views = Object.assign(new LotViews(), { route, access: { lots: [OF_DRONE], unlisted: "", token: null, mayChange: true, ...access } });
    document.body.replaceChildren(views);
    await drawn();
  }

  function button(named: string): HTMLButtonElement | undefined {
    return [...views.querySelectorAll("button")].find((each) => words(each) === named);
  }

  async function choose(list: number, value: string): Promise<void> {
    const select = [...views.querySelectorAll("select")][list]!;
    select.value = value;
    select.dispatchEvent(new Event("change"));
    await drawn();
  }

  it("is a part of Lots, the newest first, with each refusal", async () => {
    await open(`#/lots/${LOT}?show=stalls`);
    button("Arrivals")!.click();
    await drawn();
    assert.match(hash, /show=arrivals/);
    const [first, second] = [...views.querySelectorAll("tbody tr")].map((row) => words(row));
    assert.match(first!, /Drone 1 *Survey 00000000 *<b[^]*North<\/b> *Taken/);
    assert.match(second!, /unknown sender *Request PUT <b[^]*– *Refused × 3 <b/);
    assert.equal(views.querySelector("archive-arrivals b"), null, "what a stranger sent is text");
  });

  it("is of all lots: a role for some lots is not offered it", async () => {
    await open(`#/lots/${LOT}?show=arrivals`, { isForSome: true });
    assert.equal(button("Arrivals"), undefined);
    assert.equal(views.querySelector("archive-arrivals"), null);
  });

  it("is chosen by sender and outcome, part by part", async () => {
    await open(`#/lots/${LOT}?show=arrivals`);
    await choose(0, "=");
    await choose(1, "refused");
    button("Show more")!.click();
    await drawn();
    await choose(0, "=Drone 1");
    assert.deepEqual(asked, ["limit=100", "limit=100&sender=", "limit=100&outcome=refused&sender=", "limit=200&outcome=refused&sender=", "limit=200&outcome=refused&sender=Drone%201"].map((each) => `api/v1/documents?${each}`));
  });

  it("is said in French, but for what the desk said", async () => {
    await inFrench(async () => {
      await open(`#/lots/${LOT}?show=arrivals`);
      assert.match(words(views), /expéditeur inconnu *Requête[^]*Refusé × 3/);
      assert.equal(views.querySelector("td [lang=en]")?.textContent, HTML);
    });
  });

  it("is offered to operators of a desk alone", async () => {
    for (const access of [{ mayChange: false }, { token: "secret" }, { lots: [{ ...OF_DRONE, last_survey: null }] }]) {
      await open(`#/lots/${LOT}?show=stalls`, access);
      assert.equal(button("Arrivals"), undefined);
    }
  });
});
