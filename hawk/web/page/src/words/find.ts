import { language } from "./say.ts";

/** Letters without their accents and in lower case: "etoile" finds "Étoile". */
function plain(text: string): string {
  return text.normalize("NFD").replaceAll(/\p{M}/gu, "").toLowerCase();
}

/** Those whose text holds all words that are wanted; the same list where none is. */
export function withWords<T>(all: readonly T[], wanted: string, textOf: (one: T) => string): readonly T[] {
  const words = plain(wanted).split(/\s+/).filter((word) => word !== "");
  if (words.length === 0) return all;
  return all.filter((one) => {
    const here = plain(textOf(one));
    return words.every((word) => here.includes(word));
  });
}

/** The order of names in the page's language: Lot 2 before Lot 10. */
export function nameOrder(): (one: string, other: string) => number {
  return new Intl.Collator(language(), { numeric: true }).compare;
}
