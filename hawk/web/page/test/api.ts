import type { SurveyMap } from "../src/api.ts";
import type { Feature } from "../src/views/survey-source.ts";

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

/** Stalls as a survey's map has them. */
export function surveyMap(...stalls: Feature[]): SurveyMap {
  const rings = stalls.map(({ geometry }) => (geometry.coordinates as [number, number][][])[0]!.slice(0, 4));
  const [east, north] = rings[0]?.[0] ?? [0, 0];
  return {
    origin: [east, north],
    ids: stalls.map(({ id }) => id),
    labels: stalls.map(({ properties }) => properties.ref ?? ""),
    states: stalls.map(({ properties }) => properties.state as SurveyMap["states"][number]),
    taken: stalls.map(({ properties }) => properties.taken_probability ?? null),
    corners: rings.flat().flatMap(([x, y]) => [Math.round((x - east) * 1e8), Math.round((y - north) * 1e8)]),
  };
}
