export const VIEWS = ["surveys", "compare", "figures", "stalls", "report", "recordings", "links"] as const;
export type ViewName = (typeof VIEWS)[number];

/** What the page shows, as it stands behind the address's "#": a link leads there, and "back" goes back. */
export interface Place {
  lot: string;
  view: ViewName;
  survey: string;
  before: string;
  after: string;
  stall: string;
  from: string;
  to: string;
  /** "1": the report is of every lot, a page each. */
  every: "" | "1";
}

const NOWHERE: Place = { lot: "", view: "surveys", survey: "", before: "", after: "", stall: "", from: "", to: "", every: "" };
const DAY = /^\d{4}-\d{2}-\d{2}$/;

/** The place that an address names; what cannot be read is left out. */
export function placeOf(hash: string): Place {
  const given = new URLSearchParams(hash.replace(/^#/, ""));
  const place: Place = { ...NOWHERE };
  for (const name of ["lot", "survey", "before", "after", "stall"] as const) {
    const value = given.get(name) ?? "";
    if (/^[0-9a-f-]{36}$/.test(value)) place[name] = value;
  }
  for (const name of ["from", "to"] as const) {
    const value = given.get(name) ?? "";
    if (DAY.test(value)) place[name] = value;
  }
  if (given.get("every") === "1") place.every = "1";
  const view = given.get("view");
  const known = VIEWS.find((name) => name === view);
  return known ? { ...place, view: known } : place;
}

/** The address of a place, with what differs from none. */
export function hashOf(place: Place): string {
  const given = Object.entries(place).filter(([name, value]) => value !== NOWHERE[name as keyof Place]);
  return `#${new URLSearchParams(given as [string, string][]).toString()}`;
}
