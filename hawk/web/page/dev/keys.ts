import { FluentResource } from "@fluent/bundle";
import { readFileSync, writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";

/** What is used of Fluent's syntax tree. */
export type Pattern = string | (string | Expression)[];
export type Expression =
  | { type: "select"; selector: Expression; variants: { key: { type: "str" | "num"; value: string | number }; value: Pattern }[] }
  | { type: "var"; name: string }
  | { type: "mesg"; name: string }
  | { type: "str" | "num" | "term" | "func" };

const PLURALS = new Set(["zero", "one", "two", "few", "many", "other"]);

/** Messages of a file by their key. */
export function patterns(text: string): Map<string, Pattern> {
  const { body } = new FluentResource(text);
  return new Map(body.map(({ id, value }) => [id, (value ?? "") as Pattern]));
}

/** Values that a message takes, by name, with their types in TypeScript. */
export function valuesOf(pattern: Pattern, all: Map<string, Pattern>): Map<string, string> {
  const found = new Map<string, string>();
  const look = (part: Pattern): void => {
    for (const element of typeof part === "string" ? [] : part) {
      if (typeof element === "string") continue;
      if (element.type === "var" && !found.has(element.name)) found.set(element.name, "string | number");
      if (element.type === "mesg") look(all.get(element.name) ?? "");
      if (element.type !== "select") continue;
      if (element.selector.type === "var") found.set(element.selector.name, selected(element.variants.map(({ key }) => key.value)));
      for (const variant of element.variants) look(variant.value);
    }
  };
  look(pattern);
  return found;
}

/** Numbers are chosen between by their plural, names by themselves. */
function selected(keys: (string | number)[]): string {
  const isPlural = keys.every((key) => typeof key === "number" || PLURALS.has(key));
  return isPlural ? "number" : keys.map((key) => JSON.stringify(key)).join(" | ");
}

/** The module with the keys of all messages, and the values that each takes. */
export function keysModule(text: string): string {
  const all = patterns(text);
  const lines = [...all].map(([key, pattern]) => {
    const values = [...valuesOf(pattern, all)].map(([name, type]) => `${name}: ${type}`);
    return `  "${key}": ${values.length === 0 ? "Record<string, never>" : `{ ${values.join("; ")} }`};`;
  });
  const opening = "/** Keys of the page's messages, and the values that each takes. `node --run keys` writes this file from en.ftl. */";
  return `${opening}\nexport interface Messages {\n${lines.join("\n")}\n}\n`;
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const at = (name: string): string => fileURLToPath(new URL(`../src/messages/${name}`, import.meta.url));
  writeFileSync(at("keys.ts"), keysModule(readFileSync(at("en.ftl"), "utf8")));
}
