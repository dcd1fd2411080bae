import type { SentenceItem } from "../protocol.ts";
import { language, sayOfDrone } from "./say.ts";

/** Sentences that are kept: those of the messages that are shown, and of the last heartbeats. */
const KEPT = 1000;
/** A sentence holds others as values, as deep as this. */
const DEEPEST = 8;
/** The fields that a reason against a move begins with. */
const FIELDS = "X, Y: ";
/** By their English text. One for the whole document, as the language is. */
const known = new Map<string, SentenceItem>();

/** Remembers the codes and the values of sentences that the drone sent. */
export function learn(sentences: readonly SentenceItem[] | undefined): void {
  for (const sentence of sentences ?? []) {
    known.delete(sentence.Text);
    known.set(sentence.Text, sentence);
  }
  for (const text of known.keys()) {
    if (known.size <= KEPT) break;
    known.delete(text);
  }
}

/** A text of the drone in the language of the page; null where the page has no words for it. */
export function translated(text: string, depth = 0): string | null {
  if (language() === "en" || text === "" || depth > DEEPEST) return null;
  const found = known.get(text);
  if (found === undefined) return withoutEnds(text, depth);
  const values = Object.entries(found.Values).map(([name, value]): [string, string | number] => [
    name,
    typeof value === "string" ? (translated(value, depth + 1) ?? value) : value,
  ]);
  return sayOfDrone(found.Code, Object.fromEntries(values));
}

/** The page leaves the full stop out where a sentence stands within another, and the fields of a move's reason. */
function withoutEnds(text: string, depth: number): string | null {
  if (known.has(`${text}.`)) return translated(`${text}.`, depth + 1)?.replace(/\.$/, "") ?? null;
  if (known.has(`${FIELDS}${text}`)) return translated(`${FIELDS}${text}`, depth + 1)?.replace(/^X, Y\s*:\s*/, "") ?? null;
  return null;
}

/** A text of the drone in the language of the page, and in English where that has no words for it. */
export function ofDrone(text: string): string {
  return translated(text) ?? text;
}
