import type { SentenceItem } from "../protocol.ts";
import { learn, ofDrone } from "../words/drone.ts";
import { say } from "../words/say.ts";

/** What became of a file: GeoJSON of one Polygon, or the reason why it holds none. */
export type AreaFile = { text: string } | { problem: string };

/**
 * Sends a file to the drone's server, whose reader takes what the settings' files take: GeoJSON and KML. `kind` names the
 * editor that wants it.
 */
export async function readAreaFile(file: Blob, kind: "fence" | "outline"): Promise<AreaFile> {
  try {
    const answer = await fetch(`api/area-file?kind=${kind}`, {
      method: "POST",
      headers: { Accept: "application/json" },
      body: file,
      cache: "no-store",
    });
    const text = await answer.text();
    if (answer.ok) return { text };
    return { problem: answer.headers.get("Content-Type")?.startsWith("application/json") === true ? refusal(text) : text };
  } catch {
    return { problem: say("file-unanswered") };
  }
}

/** The drone's reason in the language of the page. */
function refusal(text: string): string {
  const { Reason, Sentences } = JSON.parse(text) as { Reason: string; Sentences?: SentenceItem[] };
  learn(Sentences);
  return ofDrone(Reason);
}
