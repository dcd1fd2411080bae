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
  speak("fr", messagesOf("fr"));
  try {
    await run();
  } finally {
    speak("en");
  }
}
