import frenchFile from "../messages/fr.ftl";

/** Languages that the page speaks. English is part of the page, any other is a file of its own. */
export type LanguageName = "en" | "fr";

export interface Language {
  /** Its name in itself. */
  label: string;
  /** Address of its messages; null for those that are part of the page. */
  file: string | null;
  /** Groups of three digits in large numbers. */
  grouping: "min2" | false;
  /** Spaces and marks as its typography wants them, in place of those that are easily typed. */
  typography: (text: string) => string;
}

export const LANGUAGES: Readonly<Record<LanguageName, Language>> = {
  en: { label: "English", file: null, grouping: false, typography: (text) => text },
  fr: { label: "Français", file: frenchFile, grouping: "min2", typography: french },
};

/** The first of the browser's languages, as in navigator.languages, that the page speaks: "fr-CA" is French. */
export function firstSpoken(languages: readonly string[]): LanguageName {
  const names = languages.map((tag) => tag.toLowerCase().split("-")[0]);
  return names.find((name): name is LanguageName => isLanguage(name)) ?? "en";
}

export function isLanguage(name: unknown): name is LanguageName {
  return typeof name === "string" && Object.hasOwn(LANGUAGES, name);
}

/** No-break spaces before double marks and the sign of per cent, and the curved apostrophe. */
function french(text: string): string {
  return text.replace(/ (?=[;!?%])/g, "\u202f").replace(/ (?=:)/g, "\u00a0").replaceAll("'", "’");
}
