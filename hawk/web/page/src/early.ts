import { askSoon, readSoon } from "./link/soon.ts";
import { firstReads } from "./route/first-reads.ts";

/** Runs before the page's own script is there: asks for what the view of the address needs, and for its script. */
const reads = firstReads(location.hash);
if (reads.length > 0) for (const name of document.currentScript?.dataset.late?.split(" ") ?? []) readSoon(name);
for (const each of reads) askSoon(`api/v1/${each}`);
