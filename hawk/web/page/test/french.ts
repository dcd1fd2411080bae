import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import type { LanguageName } from "../src/words/languages.ts";
import { speak } from "../src/words/say.ts";

/** The file of messages of a language. */
export function messagesOf(name: LanguageName): string {
  return readFileSync(fileURLToPath(new URL(`../src/messages/${name}.ftl`, import.meta.url)), "utf8");
}

/** The page speaks French while this runs. */
export async function inFrench(run: () => unknown): Promise<void> {
  speak("fr", messagesOf("fr") + sentencesOf("fr"));
  try {
    await run();
  } finally {
    speak("en");
  }
}

/** The sentences of the drone's program in a language, with their keys as the page is built. */
export function sentencesOf(name: LanguageName): string {
  const text = readFileSync(fileURLToPath(new URL(`../src/messages/drone-${name}.ftl`, import.meta.url)), "utf8");
  return text.replace(/^(?=[a-z])/gm, "drone-");
}
