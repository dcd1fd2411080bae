import { readPreferences } from "../state/preferences.ts";
import { PageLanguage } from "../state/page-language.ts";
import { say } from "../words/say.ts";
import { Archive } from "./app.ts";
import { type LotName, read } from "./link.ts";

const preferences = readPreferences(localStorage);
const dark = matchMedia("(prefers-color-scheme: dark)");
const isShared = location.pathname.endsWith("/shared");

const showTheme = (): void => {
  const { theme } = preferences;
  document.documentElement.dataset.theme = theme === "auto" ? (dark.matches ? "dark" : "light") : theme;
};
dark.addEventListener("change", showTheme);
showTheme();

for (const archive of document.querySelectorAll("hawk-archive")) {
  if (archive instanceof Archive) begin(archive);
}

function begin(archive: Archive): void {
  archive.outside = {
    hash: () => location.hash,
    setHash: (hash) => {
      history.pushState(null, "", hash);
    },
    token: isShared ? (/^#([\w-]+)/.exec(location.hash)?.[1] ?? "none") : null,
    lots: async () => (await read<{ lots: LotName[] }>("api/lots.json")).lots,
    isOperator: async () => (await read<{ role: string }>("api/session").catch(() => ({ role: "viewer" }))).role === "operator",
  };
  const language = new PageLanguage({
    languages: () => navigator.languages,
    read: async (file) => {
      const answer = await fetch(new URL(file, document.baseURI));
      if (!answer.ok) throw new Error(`${answer.status} ${answer.statusText}`);
      return await answer.text();
    },
    changed: (name) => {
      document.documentElement.lang = name;
      document.title = say("archive-title");
      archive.drawAgain();
    },
  });
  window.addEventListener("popstate", () => archive.read());
  window.addEventListener("hashchange", () => archive.read());
  void language.follow(preferences.language);
  void archive.begin();
}
