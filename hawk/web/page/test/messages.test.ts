import "./dom.ts";
import assert from "node:assert/strict";
import { beforeEach, describe, it } from "node:test";
import type { LogEntry } from "../src/protocol.ts";
import { MessagesTab } from "../src/ui/messages-tab.ts";
import { logName, logText, matching } from "../src/words/log-lines.ts";
import { flying, type Rig } from "./rig.ts";
import { Stage, words } from "./stage.ts";

const SAID: LogEntry[] = [
  { Number: 1, Time: "2026-05-01T10:00:00Z", Level: "info", Text: "Taking off to 20 m.", Details: "" },
  { Number: 2, Time: "2026-05-01T10:00:05Z", Level: "warning", Text: "The wind is strong.", Details: "WIND 9 m/s\nGUST 12 m/s" },
  { Number: 3, Time: "2026-05-01T10:00:09Z", Level: "error", Text: "The camera is silent.", Details: "" },
  { Number: 4, Time: "2026-05-01T10:00:12Z", Level: "ok", Text: "The camera is back.", Details: "" },
];

/** What the page would have saved: name and text of each file. */
function catchSaved(): { name: string; text: Promise<string> }[] {
  const saved: { name: string; text: Promise<string> }[] = [];
  let content: Blob | null = null;
  URL.createObjectURL = (blob) => {
    content = blob as Blob;
    return "blob:messages";
  };
  URL.revokeObjectURL = () => undefined;
  const links = Object.getPrototypeOf(document.createElement("a")) as HTMLAnchorElement;
  links.click = function click(this: HTMLAnchorElement): void {
    if (content) saved.push({ name: this.download, text: content.text() });
  };
  return saved;
}

describe("the messages", () => {
  let stage: Stage<MessagesTab>;
  let rig: Rig;

  beforeEach(async () => {
    rig = flying({ Messages: SAID });
    stage = new Stage(new MessagesTab(), rig.operator);
    await stage.drawn();
  });

  function shown(): string[] {
    return [...stage.part.querySelectorAll("li > div")].map((line) => line.firstChild?.nextSibling?.textContent ?? words(line)).map((text) => text.trim());
  }

  async function search(text: string): Promise<void> {
    const field = stage.input("input");
    field.value = text;
    field.dispatchEvent(new Event("input"));
    await stage.drawn();
  }

  it("are searched in text and details, in any case", async () => {
    await search("CAMERA");
    assert.equal(shown().length, 2);
    await search("gust");
    assert.equal(shown().length, 1);
    assert.match(stage.text, /The wind is strong/);
  });

  it("say that none is like what is searched, and save none", async () => {
    await search("submarine");
    assert.match(stage.text, /No message is like this/);
    assert.equal(stage.button("Save").disabled, true);
  });

  it("are warnings and errors alone after a press, and all after another", async () => {
    await stage.press("Warnings");
    assert.equal(stage.button("Warnings").getAttribute("aria-pressed"), "true");
    assert.equal(shown().length, 2);
    await stage.press("Warnings");
    assert.equal(shown().length, 4);
  });

  it("are saved as they are found, the oldest first, under the newest's time", async () => {
    const saved = catchSaved();
    await stage.press("Warnings");
    await stage.press("Save");
    assert.equal(saved.length, 1);
    assert.equal(saved[0]!.name, "hawk-messages-2026-05-01T10-00-09.txt");
    assert.deepEqual((await saved[0]!.text).split("\n"), [
      "2026-05-01T10:00:05Z warning The wind is strong.",
      "    WIND 9 m/s",
      "    GUST 12 m/s",
      "2026-05-01T10:00:09Z error   The camera is silent.",
      "",
    ]);
  });

  it("come on while they are searched", async () => {
    await search("camera");
    rig.hear({ Messages: [{ Number: 5, Time: "2026-05-01T10:00:15Z", Level: "warning", Text: "The camera is late.", Details: "" }] });
    await stage.drawn();
    assert.equal(shown().length, 3);
    assert.equal(stage.input("input").value, "camera");
  });

  it("are drawn by sixty, all of them on demand, and all are saved", async () => {
    const many = Array.from({ length: 100 }, (_, i): LogEntry => ({ Number: 10 + i, Time: `2026-05-01T11:00:00.${String(i).padStart(3, "0")}Z`, Level: "info", Text: `Line ${i}.`, Details: "" }));
    rig.hear({ Messages: many });
    await stage.drawn();
    await search("line");
    assert.equal(shown().length, 60);
    const saved = catchSaved();
    await stage.press("Save");
    assert.equal((await saved[0]!.text).trim().split("\n").length, 100);
    await stage.press("Show more");
    assert.equal(shown().length, 100);
  });
});

describe("the text of messages", () => {
  it("is empty without any", () => {
    assert.equal(logText([]), "");
    assert.deepEqual(matching([], { text: "a", troubles: true }), []);
  });

  it("has a name that every file system takes", () => {
    assert.match(logName("2026-05-01T10:00:09.123Z"), /^[\w.-]+$/);
  });
});
