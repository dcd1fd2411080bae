import { PageLanguage } from "../state/page-language.ts";
import { type LanguageChoice, readPreferences, writePreferences } from "../state/preferences.ts";
import { say } from "../words/say.ts";

/**
 * Gives the document the theme and the language that this browser chose; `title` is a message without values. Returns
 * what lets it speak another language, and keeps that.
 */
export function dressed(title: "archive-title", drawAgain: () => void): (choice: LanguageChoice) => void {
  const { theme, language } = readPreferences(localStorage);
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const show = (): void => {
    document.documentElement.dataset.theme = theme === "auto" ? (dark.matches ? "dark" : "light") : theme;
  };
  dark.addEventListener("change", show);
  show();
  const spoken = new PageLanguage({
    languages: () => navigator.languages,
    read: async (file) => {
      const answer = await fetch(new URL(file, document.baseURI));
      if (!answer.ok) throw new Error(`${answer.status} ${answer.statusText}`);
      return await answer.text();
    },
    changed: (name) => {
      document.documentElement.lang = name;
      document.title = say(title);
      drawAgain();
    },
  });
  void spoken.follow(language);
  return (choice) => {
    writePreferences(localStorage, { ...readPreferences(localStorage), language: choice });
    void spoken.follow(choice);
  };
}
