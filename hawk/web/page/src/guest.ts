export * from "./parts/shared.ts";
import { followWindow, Route, windowAddress } from "./route/route.ts";
import { Guest } from "./shell/guest.ts";
import { dressed } from "./views/dressed.ts";

const token = /^#([\w-]+)/.exec(location.hash)?.[1] ?? "none";
const route = new Route(windowAddress(), token);
followWindow(route);

for (const guest of document.querySelectorAll("hawk-guest")) {
  if (!(guest instanceof Guest)) continue;
  const speak = dressed("archive-title", () => guest.requestUpdate());
  Object.assign(guest, { route, token, speak });
}
