import "./dom.ts";
import assert from "node:assert/strict";
import { describe, it } from "node:test";
import { LitElement } from "lit";
import { Asked } from "../src/views/view.ts";
import { settle } from "./fakes.ts";

class Host extends LitElement {}
customElements.define("asked-host", Host);

describe("an answer", () => {
  it("stays until the next one is there, unless it is about another lot", async () => {
    const asked = new Asked<string>(new Host());
    const never = (): Promise<string> => new Promise(() => undefined);
    asked.ask("first", () => Promise.resolve("of North"), "North");
    await settle();
    asked.ask("second", never, "North");
    assert.deepEqual([asked.value, asked.waiting], ["of North", true]);
    asked.ask("third", never, "South");
    assert.deepEqual([asked.value, asked.waiting], [null, true], "another lot has none of these surveys");
  });
});
