import { say } from "../words/say.ts";

/** A figure with its 90 % interval and the number of surveys behind it; null where nobody flew. */
export interface Estimate {
  value: number | null;
  low: number | null;
  high: number | null;
  surveys: number;
}

/** Ends of what surveys alone can say; null for an end that is not known. */
export interface Bracket {
  low: number | null;
  high: number | null;
}

export interface SurveyRow {
  id: string;
  placed: string;
  free: number;
  taken: number;
  unknown: number;
  simulated: boolean;
  program: string;
  /** UTC in ISO 8601. */
  began: string;
  ended: string;
  occupancy: Estimate;
  /** Why no figure uses it; "" where figures do. */
  left_out_code: "" | "unregistered" | "no_time" | "no_looks";
}

export interface Listing {
  lot: string;
  name: string;
  /** Name of the clock that days and hours are of. */
  clock: string;
  surveys: SurveyRow[];
}

export interface Use {
  name: string;
  capacity: number;
  surveys: number;
  hours: number;
  occupancy: Estimate;
  accumulation: Estimate;
  load_space_hours: Estimate;
  peak: { begin: string; occupancy: Estimate; rivals: number } | null;
  above: Record<string, Estimate>;
  never_taken: Estimate & { stalls: string[] };
  always_taken: Estimate & { stalls: string[] };
  turnover: { hours: number; arrivals: Bracket; per_stall_hour: Bracket; stay_hours: Bracket };
}

export interface Statistics {
  clock: string;
  surveys: number;
  first: string | null;
  last: string | null;
  left_out: { survey: string }[];
  whole: Use | null;
  parts: Use[];
  hours: { hour: number; days: number; occupancy: Estimate }[];
  days: { day: string; days: number; occupancy: Estimate }[];
}

/** By stall, in columns. */
export interface Heat {
  surveys_in_period: number;
  ids: string[];
  labels: string[];
  surveys: number[];
  share: (number | null)[];
  low: (number | null)[];
  high: (number | null)[];
}

export interface Between {
  compared: number;
  unknown: number;
  came: Estimate;
  left: Estimate;
  stalls: { id: string; label: string; taken: boolean; chance: number }[];
}

export interface Looks {
  label: string;
  looks: { survey: string; looked: string; state: string; taken_probability: number }[];
}

/** A survey as the drone's GeoJSON has it. */
export interface Features {
  hawk: { lot: string; survey_ended_utc: string; registered: boolean; position_uncertainty_m: number | null; software: string };
  features: Feature[];
}

export interface Feature {
  id: string;
  geometry: { type: string; coordinates: unknown };
  properties: { amenity?: string; ref?: string; label?: string | null; state?: string; parking_space?: string; taken_probability?: number | null };
}

export interface RecordingRow {
  name: string;
  bytes: number;
  began: string | null;
  seconds: number | null;
  survey: string | null;
  lot: { name: string } | null;
  keep: boolean;
  under_way: boolean;
}

export interface ShareRow {
  id: string;
  made: string;
  ends: string;
  open: boolean;
}

export interface LotName {
  id: string;
  name: string;
}

/** A question that the drone refused or did not answer; the text says why. */
export class Refused extends Error {}

/** Days of the period, as 2026-05-04; "" without that end. */
export interface Period {
  from: string;
  to: string;
}

/** Reads of one lot: by its id, or by the token of a link that was shared. */
export class LotSource {
  private readonly base: string;

  constructor(base: string) {
    this.base = base;
  }

  surveys(period: Period): Promise<Listing> {
    return read(`${this.base}/surveys.json${query({ ...period, time_zone: zone() })}`);
  }

  statistics(period: Period, by = ""): Promise<Statistics> {
    return read(`${this.base}/statistics.json${query({ ...period, by, time_zone: zone() })}`);
  }

  heat(period: Period): Promise<Heat> {
    return read(`${this.base}/heat.json${query({ ...period, time_zone: zone() })}`);
  }

  between(before: string, after: string): Promise<Between> {
    return read(`${this.base}/between.json${query({ before, after })}`);
  }

  looks(stall: string): Promise<Looks> {
    return read(`${this.base}/stalls/${stall}/looks.json`);
  }

  features(survey: string): Promise<Features> {
    return read(`${this.base}/surveys/${survey}.geojson`);
  }
}

/** Days and hours are those of the browser's clock. */
function zone(): string {
  return Intl.DateTimeFormat().resolvedOptions().timeZone;
}

function query(values: Record<string, string>): string {
  const given = Object.entries(values).filter(([, value]) => value !== "");
  return given.length === 0 ? "" : `?${new URLSearchParams(given).toString()}`;
}

/** Asks for JSON. Rejects with Refused, in the drone's words where it gave some. */
export async function read<T>(address: string): Promise<T> {
  return (await asked(address, {})) as T;
}

/** Posts a change; returns its answer. Rejects with Refused. */
export async function post<T>(address: string, body: object = {}): Promise<T> {
  return (await asked(address, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) })) as T;
}

async function asked(address: string, options: RequestInit): Promise<unknown> {
  let answer: Response;
  try {
    answer = await fetch(address, { cache: "no-store", ...options });
  } catch {
    throw new Refused(say("archive-unanswered"));
  }
  if (answer.ok) return await answer.json();
  throw new Refused(reason(await answer.text()) || say("archive-refused", { status: answer.status }));
}

function reason(text: string): string {
  try {
    const { field, reason: words } = JSON.parse(text) as { field?: string; reason?: string };
    return field ? `${field}: ${words ?? ""}` : (words ?? "");
  } catch {
    return text.startsWith("<") ? "" : text;
  }
}
