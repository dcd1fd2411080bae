/** Asks the drone's server for JSON; null when it does not answer, or not with JSON. */
export async function fetchJson(address: string): Promise<unknown> {
  try {
    const response = await fetch(address, { cache: "no-store" });
    return response.ok ? await response.json() : null;
  } catch {
    return null;
  }
}
