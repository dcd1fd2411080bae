/** A file of the survey's result. `bytes` is null while it cannot be downloaded, for the reason given. */
export interface Download {
  name: string;
  bytes: number | null;
  reason: string;
}

/** Asks the drone for its files; null when it does not answer. */
export async function fetchDownloads(): Promise<Map<string, Download> | null> {
  try {
    const response = await fetch("api/downloads.json", { cache: "no-store" });
    if (!response.ok) return null;
    return readDownloads(await response.json());
  } catch {
    return null;
  }
}

function readDownloads(answer: unknown): Map<string, Download> | null {
  const listed = (answer as { Downloads?: { Name: string; Bytes: number | null; Reason: string }[] } | null)?.Downloads;
  if (!Array.isArray(listed)) return null;
  return new Map(listed.map(({ Name, Bytes, Reason }) => [Name, { name: Name, bytes: Bytes, reason: Reason }]));
}
