import type { Heartbeat } from "../protocol.ts";

/** The words of the user error, in English; null when there is none. */
export function userError(heartbeat: Heartbeat | null): string | null {
  return heartbeat === null || heartbeat["User Error"] === 0 ? null : heartbeat["User Error Text"];
}
