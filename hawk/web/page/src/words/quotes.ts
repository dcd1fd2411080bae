import type { View } from "./view.ts";

/** Sentences of the drone's program that the page shows among its own words, as they may stand in them. */
export function droneSentences(view: View): string[] {
  const heartbeat = view.heartbeat;
  if (!heartbeat) return [];
  const reasons = heartbeat.Options.map(({ Reason }) => Reason);
  return [heartbeat.Detail, ...reasons].flatMap((text) => [text, text.replace(/\.$/, "")]).filter((text) => text !== "");
}
