import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { describe, it } from "node:test";
import { FluentBundle, FluentResource } from "@fluent/bundle";
import { patterns, valuesOf } from "../dev/keys.ts";
import { learn, ofDrone, translated } from "../src/words/drone.ts";
import { speak } from "../src/words/say.ts";
import { readAreaFile } from "../src/link/area-file.ts";
import { inFrench, messagesOf } from "./french.ts";

const file = (name: string): string => readFileSync(fileURLToPath(new URL(`../src/messages/drone-${name}.ftl`, import.meta.url)), "utf8");
const item = (Text: string, Code: string, Values: Record<string, string | number> = {}) => ({ Text, Code, Values });

describe("the sentences of the drone's program", () => {
  it("are put in the language of the page, with their values in its digits", () =>
    inFrench(() => {
      learn([item("12 m", "value-m", { value: 12 })]);
      assert.equal(ofDrone("12 m"), "12\u00a0m");
    }));

  it("hold other sentences, which are put in it too, and words of others as they are", () =>
    inFrench(() => {
      learn([item("The autopilot warns: Low.", "the-autopilot-warns-words", { words: "Low." }), item("north", "north"), item("north 12 m", "first-second", { first: "north", second: "12 m" })]);
      assert.equal(ofDrone("The autopilot warns: Low."), "L’autopilote avertit\u00a0: Low.");
      assert.equal(ofDrone("north 12 m"), "nord 12\u00a0m");
    }));

  it("leave the dots of others as they are", () =>
    inFrench(() => {
      learn([item("The autopilot warns: wait...", "the-autopilot-warns-words", { words: "wait..." }), item("Wait!", "text", { text: "Wait!" })]);
      assert.equal(ofDrone("The autopilot warns: wait..."), "L’autopilote avertit\u00a0: wait...");
      assert.equal(ofDrone("Wait!"), "Wait!");
    }));

  it("are found without their full stop", () =>
    inFrench(() => {
      learn([item("north.", "text", { text: "north" }), item("north", "north")]);
      assert.equal(ofDrone("north."), "nord.");
    }));

  it("stay English where the page has no words for the code, and in English", () => {
    learn([item("Quite new.", "quite-new")]);
    assert.equal(translated("12 m"), null);
    return inFrench(() => {
      assert.equal(translated("Quite new."), null);
      assert.equal(ofDrone("Quite new."), "Quite new.");
    });
  });

  it("do not end in a circle", () =>
    inFrench(() => {
      learn([item("round", "first-second", { first: "round", second: "x" })]);
      assert.match(ofDrone("round"), /x/);
    }));

  it("are forgotten when a thousand newer ones came", () =>
    inFrench(() => {
      learn([item("south", "south")]);
      learn(Array.from({ length: 1000 }, (_, index) => item(`${index} s`, "value-s", { value: index })));
      assert.equal(translated("south"), null);
      assert.equal(ofDrone("999 s"), "999\u00a0s");
    }));

  it("are the same in every language, can be said without an error, and clash with no message of the page", () => {
    const english = patterns(file("en"));
    const french = patterns(file("fr"));
    assert.deepEqual([...french.keys()].sort(), [...english.keys()].sort());
    const page = new Set(patterns(messagesOf("en")).keys());
    const bundle = new FluentBundle("fr", { useIsolating: false });
    assert.deepEqual(bundle.addResource(new FluentResource(file("fr"))), []);
    for (const [code, pattern] of french) {
      assert.ok(!page.has(`drone-${code}`), code);
      const errors: Error[] = [];
      const values = Object.fromEntries([...valuesOf(pattern, french).keys()].map((name) => [name, 2]));
      bundle.formatPattern(bundle.getMessage(code)?.value ?? "", values, errors);
      assert.deepEqual(errors, [], code);
    }
    speak("en");
  });
});

describe("a file that the drone refuses", () => {
  const sentences = [
    { Text: "The file cannot be read as KML: no element found.", Code: "the-file-fault", Values: { fault: "cannot be read as KML: no element found" } },
    { Text: "cannot be read as KML: no element found", Code: "cannot-be-read-as-kml-error", Values: { error: "no element found" } },
  ];
  const json = JSON.stringify({ Reason: sentences[0]!.Text, Sentences: sentences });

  for (const [type, body, problem] of [
    ["application/json; charset=utf-8", json, /^Le fichier est illisible comme KML\s: no element found\.$/],
    ["text/plain; charset=utf-8", "The file did not come.", /^The file did not come\.$/],
  ] as const) {
    it(`is refused in the language of the page: ${type}`, async () => {
      const before = globalThis.fetch;
      globalThis.fetch = () => Promise.resolve(new Response(body, { status: 422, headers: { "Content-Type": type } }));
      try {
        await inFrench(async () => {
          const read = await readAreaFile(new Blob([]), "fence");
          assert.match("problem" in read ? read.problem : "", problem);
        });
      } finally {
        globalThis.fetch = before;
      }
    });
  }
});
