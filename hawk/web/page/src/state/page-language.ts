import { firstSpoken, type LanguageName, LANGUAGES } from "../words/languages.ts";
import { speak } from "../words/say.ts";
import type { LanguageChoice } from "./preferences.ts";

export interface LanguageOutside {
  /** The browser's languages, as in navigator.languages. */
  languages: () => readonly string[];
  /** Reads a file of messages; rejects when it cannot. */
  read: (file: string) => Promise<string>;
  /** The page speaks this language from now on. */
  changed: (name: LanguageName) => void;
}

/** Lets the page speak the language that is wanted. Until its file is there, and without it, the page stays as it is. */
export class PageLanguage {
  private wanted: LanguageName = "en";
  private readonly outside: LanguageOutside;

  constructor(outside: LanguageOutside) {
    this.outside = outside;
  }

  /** Speaks what was chosen; asks for a file only when that is another language than before. */
  async follow(choice: LanguageChoice): Promise<void> {
    const wanted = choice === "auto" ? firstSpoken(this.outside.languages()) : choice;
    if (wanted === this.wanted) return;
    this.wanted = wanted;
    const { file, label } = LANGUAGES[wanted];
    try {
      const text = file === null ? "" : await this.outside.read(file);
      if (wanted !== this.wanted) return; // another one was chosen meanwhile
      speak(wanted, text);
      this.outside.changed(wanted);
    } catch (error) {
      console.warn(`${label}: ${file} could not be read. The page keeps its language. Load it again.`, error);
    }
  }
}
