import type { ListedLot } from "../api.ts";
import { read, readAll } from "../link/api.ts";
import { Archive } from "./app.ts";
import { dressed } from "./dressed.ts";

const isShared = location.pathname.endsWith("/shared");

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
    lots: () => readAll<ListedLot>("lots"),
    isOperator: async () => (await read<{ role: string }>("api/session").catch(() => ({ role: "viewer" }))).role === "operator",
  };
  window.addEventListener("popstate", () => archive.read());
  window.addEventListener("hashchange", () => archive.read());
  dressed("archive-title", () => archive.drawAgain());
  void archive.begin();
}
