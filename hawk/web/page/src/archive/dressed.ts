import { PageLanguage } from "../state/page-language.ts";
import { readPreferences } from "../state/preferences.ts";
import { say } from "../words/say.ts";

/** Gives the document the theme and the language that this browser chose; `title` is a message without values. */
export function dressed(title: "archive-title" | "archive-replay-mark", drawAgain: () => void): void {
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
}
