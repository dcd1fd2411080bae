/** Items as the only part of a list of the drone's API. */
export function list(...items: unknown[]): object {
  return { items, next: null };
}

/** Answers a read of the drone's API by its path, without parameters; 404 for another one. */
export function answer(address: string, known: Record<string, unknown>): Response {
  const found = known[address.replace(/^api\/v1\//, "").replace(/\?.*/, "")];
  return found === undefined ? refusal(404, "there is nothing at this address") : Response.json(found);
}

/** A refusal in the form of the drone's API. */
export function refusal(status: number, detail: string, more: object = {}): Response {
  return Response.json({ type: "about:blank", title: "", status, detail, field: "", ...more }, { status });
}
