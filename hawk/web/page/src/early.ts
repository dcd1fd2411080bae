import { askSoon, readSoon } from "./link/soon.ts";
import { firstPart, firstReads } from "./route/first-reads.ts";

/** Runs before the page's own script is there: asks for what the view of the address needs, and for its part of the page. */
const parts = document.currentScript?.dataset ?? {};
for (const name of parts[firstPart(location.hash)]?.split(" ") ?? []) readSoon(name);
for (const each of firstReads(location.hash)) askSoon(`api/v1/${each}`);
