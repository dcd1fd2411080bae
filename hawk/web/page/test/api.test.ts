import assert from "node:assert/strict";
import { afterEach, beforeEach, describe, it, mock } from "node:test";
import { post, read, Refused } from "../src/link/api.ts";
import { settle } from "./fakes.ts";

const busy = (pause: string | null): Response =>
  new Response(JSON.stringify({ field: "", detail: "The store of lots is busy." }), { status: 503, headers: pause === null ? {} : { "Retry-After": pause } });

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
