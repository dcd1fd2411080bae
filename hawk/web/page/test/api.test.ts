import assert from "node:assert/strict";
import { afterEach, beforeEach, describe, it, mock } from "node:test";
import { post, read, type Refused } from "../src/link/api.ts";
import { ofDrone } from "../src/words/drone.ts";
import { settle } from "./fakes.ts";
import { inFrench } from "./french.ts";

const busy = (pause: string | null): Response =>
  new Response(JSON.stringify({ field: "", detail: "The store of lots is busy." }), { status: 503, headers: pause === null ? {} : { "Retry-After": pause } });

describe("a refusal", () => {
  const before = globalThis.fetch;
  afterEach(() => {
    globalThis.fetch = before;
  });

  it("of a plan's change is said in French, with what stands in it", async () => {
    const labels = { text: "A 11 and 13 more", code: "label-and-count-more", values: { label: "A 11", count: 13 } };
    const detail = `${labels.text}: a person confirmed the label of another stall: swap the rows, or rename that one first`;
    const whole = { text: detail, code: "labels-a-person-confirmed-the-label-of-another-stall-swap", values: { labels: labels.text } };
    globalThis.fetch = () => Promise.resolve(Response.json({ field: "to", detail, sentences: [whole, labels] }, { status: 422 }));
    const error = (await post("lots/a/plan", {}).catch((refused: unknown) => refused)) as Refused;
    assert.equal(error.message, `to: ${detail}`);
    assert.equal(ofDrone(error.message), error.message);
    await inFrench(() => {
      assert.equal(ofDrone(error.message).replaceAll(/\s/g, " "), "A 11 et 13 de plus : une personne a confirmé ce numéro pour une autre place : échangez les rangées, ou renommez d’abord celle-là");
    });
  });
});

describe("a busy drone", () => {
  const before = globalThis.fetch;
  let asked = 0;
  let answers: () => Response = () => busy("5");

  beforeEach(() => {
    asked = 0;
    globalThis.fetch = () => {
      asked += 1;
      return Promise.resolve(answers());
    };
    mock.timers.enable({ apis: ["setTimeout"] });
  });
  afterEach(() => {
    globalThis.fetch = before;
    mock.timers.reset();
  });

  async function pass(ms: number): Promise<void> {
    await settle();
    mock.timers.tick(ms);
    await settle();
  }

  it("is asked again after the pause that it names, until it answers", async () => {
    answers = () => (asked < 3 ? busy("5") : Response.json({ items: 1 }));
    const answer = read("api/v1/lots");
    await pass(4999);
    assert.equal(asked, 1);
    await pass(1);
    assert.equal(asked, 2);
    await pass(5000);
    assert.deepEqual(await answer, { items: 1 });
  });

  it("is asked for a minute, and then says its own words, as what may pass", async () => {
    answers = () => busy(null);
    const refused = assert.rejects(read("api/v1/lots"), (error: Refused) => error.message === "The store of lots is busy." && error.isForNow);
    for (let k = 0; k < 40; k++) await pass(2000);
    await refused;
    assert.equal(asked, 31);
  });

  it("is not sent a change again, nor asked at once for what it refuses", async () => {
    answers = () => busy("1");
    await assert.rejects(post("lots/a/name", { name: "North" }), { status: 503 });
    answers = () => Response.json({ field: "", detail: "is gone" }, { status: 404 });
    await assert.rejects(read("api/v1/lots/a"), (error: Refused) => error.status === 404 && !error.isForNow);
    assert.equal(asked, 2);
  });
});
