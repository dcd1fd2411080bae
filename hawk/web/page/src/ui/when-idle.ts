/** The longest time for which work waits, milliseconds. */
const LONGEST_MS = 1000;

/** Does work once the browser has nothing else to do; at once in a browser that does not report that. */
export function whenIdle(work: () => void): void {
  if ("requestIdleCallback" in globalThis) requestIdleCallback(work, { timeout: LONGEST_MS });
  else work();
}
