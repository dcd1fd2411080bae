import { answer } from "./api.ts";

/** A file of the survey's result. `bytes` is null while it cannot be downloaded, for the reason given. */
export interface Download {
  name: string;
  bytes: number | null;
  reason: string;
}

/** Asks the drone for its files; null when it does not answer. */
export async function fetchDownloads(): Promise<Map<string, Download> | null> {
  return readDownloads(await answer("api/downloads.json"));
}

function readDownloads(answer: unknown): Map<string, Download> | null {
  const listed = (answer as { Downloads?: { Name: string; Bytes: number | null; Reason: string }[] } | null)?.Downloads;
  if (!Array.isArray(listed)) return null;
  return new Map(listed.map(({ Name, Bytes, Reason }) => [Name, { name: Name, bytes: Bytes, reason: Reason }]));
}
