import { FluentBundle, FluentResource } from "@fluent/bundle";
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { afterEach, describe, it, mock } from "node:test";
import { keysModule, patterns, valuesOf } from "../dev/keys.ts";
import { type LanguageOutside, PageLanguage } from "../src/state/page-language.ts";
import { readPreferences, STANDARD, writePreferences } from "../src/state/preferences.ts";
import * as format from "../src/words/format.ts";
import { firstSpoken, type LanguageName, LANGUAGES } from "../src/words/languages.ts";
import { capital, language, number, say, speak } from "../src/words/say.ts";
import { metresOf, typed } from "../src/words/units.ts";
import { FakeStorage } from "./fakes.ts";
import { inFrench, messagesOf } from "./french.ts";

const NAMES = Object.keys(LANGUAGES) as LanguageName[];
const OTHERS = NAMES.filter((name) => name !== "en");
const THIN = "\u202f";
const HARD = "\u00a0";

afterEach(() => {
  speak("en");
  mock.restoreAll();
});

/** Every choice of values that makes another sentence of a message. */
function samples(values: Map<string, string>): Record<string, string | number>[] {
  const choices = [...values].map(([name, type]): [string, (string | number)[]] => {
    if (type === "number") return [name, [0, 1, 2, 21]];
    return [name, type.startsWith('"') ? type.split(" | ").map((each) => JSON.parse(each) as string) : ["7"]];
  });
  return choices.reduce<Record<string, string | number>[]>(
    (made, [name, each]) => made.flatMap((before) => each.map((value) => ({ ...before, [name]: value }))),
    [{}],
  );
}

describe("the files of messages", () => {
  it("are listed with their values in keys.ts: `node --run keys` writes it", () => {
    const written = readFileSync(fileURLToPath(new URL("../src/messages/keys.ts", import.meta.url)), "utf8");
    assert.equal(written, keysModule(messagesOf("en")));
  });

  for (const name of NAMES) {
    it(`hold each message once and no line that is none: ${name}`, () => {
      const text = messagesOf(name);
      const begun = text.split("\n").flatMap((line) => /^([a-z][a-z-]*) =/.exec(line)?.[1] ?? []);
      assert.deepEqual([...new Set(begun)], begun);
      assert.deepEqual([...patterns(text).keys()], begun);
      const strange = text.split("\n").filter((line) => !/^$|^#{1,3}( |$)|^[a-z-]+ =|^ {4,}\S/.test(line));
      assert.deepEqual(strange, []);
    });

    it(`say every message without an error: ${name}`, () => {
      const bundle = new FluentBundle(name, { useIsolating: false });
      assert.deepEqual(bundle.addResource(new FluentResource(messagesOf(name))), []);
      const all = patterns(messagesOf("en"));
      for (const [key, pattern] of all) {
        for (const values of samples(valuesOf(pattern, all))) {
          const errors: Error[] = [];
          const text = bundle.formatPattern(bundle.getMessage(key)?.value ?? "", values, errors);
          assert.deepEqual(errors, [], key);
          assert.match(text, /^\S(.*\S)?$/, key);
          assert.doesNotMatch(text, /[{}]| {2}/, key);
        }
      }
    });
  }

  for (const name of OTHERS) {
    it(`have the messages of English, with its values: ${name}`, () => {
      const [english, other] = [patterns(messagesOf("en")), patterns(messagesOf(name))];
      assert.deepEqual([...other.keys()].sort(), [...english.keys()].sort());
      for (const [key, pattern] of english) {
        const wanted = [...valuesOf(pattern, english).keys()].sort();
        assert.deepEqual([...valuesOf(other.get(key) ?? "", other).keys()].sort(), wanted, key);
      }
    });

    it(`choose by no name that English does not give: ${name}`, () => {
      const [english, other] = [patterns(messagesOf("en")), patterns(messagesOf(name))];
      for (const [key, pattern] of english) {
        const given = valuesOf(pattern, english);
        for (const [value, type] of valuesOf(other.get(key) ?? "", other)) {
          if (type.startsWith('"')) assert.equal(type, given.get(value), key);
        }
      }
    });
  }
});

describe("French", () => {
  it("writes numbers, units and marks as its typography asks", () =>
    inFrench(() => {
      assert.equal(format.height(4.26, "metres"), `4,3${HARD}m`);
      assert.equal(format.percent(88.6), `89${THIN}%`);
      assert.equal(format.length(12_345, "feet"), `40${THIN}502${HARD}ft`);
      assert.equal(format.area(12_300, "metres"), `1,23${HARD}ha`);
      assert.equal(format.bytes(1_234_000), `1,2${HARD}Mo`);
      assert.equal(format.wind(5.23, 1.5 * Math.PI, "metres"), `5,2${HARD}m/s de l’ouest`);
      assert.equal(format.place(48.137, -11.5), `48,13700°${HARD}N${THIN}; 11,50000°${HARD}O`);
      assert.equal(format.clock("2026-01-02T10:00:00"), "10:00:00");
      assert.equal(number(-0.04, 1), "0,0");
      assert.equal(say("cut-question"), `Couper les moteurs${THIN}?`);
      assert.equal(say("refused", { what: "Armer", reason: "no GPS" }), `Armer${HARD}: no GPS`);
    }));

  it("counts 0 and 1 as one, and English only 1", async () => {
    assert.equal(say("checks-failed", { checks: 0 }), "0 checks failed");
    assert.equal(say("stalls-found", { stalls: 12_345 }), "12345 stalls found");
    await inFrench(() => {
      assert.equal(say("checks-failed", { checks: 0 }), "0 contrôle échoué");
      assert.equal(say("checks-failed", { checks: 2 }), "2 contrôles échoués");
      assert.equal(say("stalls-found", { stalls: 12_345 }), `12${THIN}345 places trouvées`);
    });
  });

  it("leaves values as they are, whatever stands in them", () =>
    inFrench(() => assert.equal(say("asks-for-control", { name: "O'Neil ? { $name }" }), "O'Neil ? { $name } demande les commandes.")));

  it("offers numbers with a comma, and takes them with either", () =>
    inFrench(() => {
      assert.equal(typed(1234.5, "metres"), "1234,5");
      assert.equal(metresOf(typed(1234.5, "metres"), "metres"), 1234.5);
      assert.equal(metresOf("12.5", "metres"), 12.5);
    }));

  it("begins a word that stands alone large", () => inFrench(() => assert.equal(capital("état"), "État")));

  it("says in English what it lacks", () => {
    speak("fr", "free = libre\n");
    assert.deepEqual([say("free"), say("taken")], ["libre", "taken"]);
  });
});

describe("the language of the page", () => {
  function page(languages: string[], read: LanguageOutside["read"]): { follow: PageLanguage["follow"]; heard: string[] } {
    const heard: string[] = [];
    const made = new PageLanguage({ languages: () => languages, read, changed: (name) => heard.push(name) });
    return { follow: (choice) => made.follow(choice), heard };
  }
  const french = (): Promise<string> => Promise.resolve(messagesOf("fr"));

  it("is the first of the browser's that exists", () => {
    assert.equal(firstSpoken(["fr-CA", "en"]), "fr");
    assert.equal(firstSpoken(["de", "FR", "en"]), "fr");
    assert.equal(firstSpoken(["en-GB", "fr"]), "en");
    assert.equal(firstSpoken(["fry", "constructor"]), "en");
    assert.equal(firstSpoken([]), "en");
  });

  it("is the one that was chosen, whatever the browser's is, and changes at once", async () => {
    const { follow, heard } = page(["en"], french);
    await follow("fr");
    assert.deepEqual([language(), say("land")], ["fr", "Atterrir"]);
    await follow("auto");
    assert.deepEqual([language(), say("land")], ["en", "Land"]);
    assert.deepEqual(heard, ["fr", "en"]);
  });

  it("is English where English is wanted, without asking for a file", async () => {
    const { follow, heard } = page(["en-US"], () => Promise.reject(new Error("asked")));
    const warn = mock.method(console, "warn", () => undefined);
    await follow("auto");
    await follow("en");
    assert.deepEqual([heard, warn.mock.callCount()], [[], 0]);
  });

  it("stays English without its file, and says so once", async () => {
    const warn = mock.method(console, "warn", () => undefined);
    const { follow, heard } = page(["fr"], () => Promise.reject(new Error("404 Not Found")));
    await follow("auto");
    await follow("auto");
    assert.deepEqual([language(), say("land"), heard], ["en", "Land", []]);
    assert.equal(warn.mock.callCount(), 1);
    assert.match(String(warn.mock.calls[0]?.arguments[0]), /Français: .*fr\.ftl could not be read/);
  });

  it("is the last one chosen, though a file comes late", async () => {
    let arrive = (_text: string): void => undefined;
    const { follow, heard } = page(["en"], () => new Promise((resolve) => (arrive = resolve)));
    const late = follow("fr");
    await follow("en");
    arrive(messagesOf("fr"));
    await late;
    assert.deepEqual([language(), heard], ["en", ["en"]]);
  });

  it("is kept by this browser; what is no language is not", () => {
    const storage = new FakeStorage();
    writePreferences(storage, { ...STANDARD, language: "fr" });
    assert.equal(readPreferences(storage).language, "fr");
    storage.setItem("hawk-page", JSON.stringify({ language: "tlh" }));
    assert.equal(readPreferences(storage).language, "auto");
  });
});
