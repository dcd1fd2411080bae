import { say } from "../words/say.ts";

/** What became of a file: GeoJSON of one Polygon, or the reason why it holds none. */
export type AreaFile = { text: string } | { problem: string };

/**
 * Sends a file to the drone's server, whose reader takes what the settings' files take: GeoJSON and KML. `kind` names the
 * editor that wants it.
 */
export async function readAreaFile(file: Blob, kind: "fence" | "outline"): Promise<AreaFile> {
  try {
    const answer = await fetch(`api/area-file?kind=${kind}`, { method: "POST", body: file, cache: "no-store" });
    const text = await answer.text();
    return answer.ok ? { text } : { problem: text };
  } catch {
    return { problem: say("file-unanswered") };
  }
}
