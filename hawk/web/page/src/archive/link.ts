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
  /** Stalls that only blurred pictures showed; null where that was not measured. */
  blurred: number | null;
  simulated: boolean;
  program: string;
  /** Kind of the pictures that it was made of; "" for a flight. */
  source: "" | "photographs" | "orthophoto" | "film";
  source_name: string;
  /** What limits a survey by pictures. */
  limits: ("by_gps" | "stretched" | "coarse" | "partly")[];
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

export interface Look {
  survey: string;
  label: string;
  looked: string;
  state: string;
  taken_probability: number;
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

/** Address of the drone's API. */
export const API = "api/v1";
/** An answer is shared by the parts of the page for so long, milliseconds; a survey that lands is seen then. */
const KEPT_MS = 30_000;
const LOOKS_SHOWN = 30;

/** Reads of one lot: by its id, or by the token of a link that was shared. What two parts ask for is asked once. */
export class LotSource {
  readonly base: string;
  private readonly kept = new Map<string, { at: number; answer: Promise<unknown> }>();
  private readonly now: () => number;

  constructor(base: string, now: () => number = Date.now) {
    this.base = `${API}/${base}`;
    this.now = now;
  }

  /** Something was changed: everything is asked for again. */
  forget(): void {
    this.kept.clear();
  }

  surveys(period: Period): Promise<Listing> {
    return this.once(`statistics/surveys${query({ ...period, time_zone: zone() })}`);
  }

  statistics(period: Period, by = ""): Promise<Statistics> {
    return this.once(`statistics${query({ ...period, by, time_zone: zone() })}`);
  }

  heat(period: Period): Promise<Heat> {
    return this.once(`statistics/stalls${query({ ...period, time_zone: zone() })}`);
  }

  between(before: string, after: string): Promise<Between> {
    return this.once(`statistics/between${query({ before, after })}`);
  }

  /** The newest looks at a stall. */
  async looks(stall: string): Promise<Look[]> {
    const { items } = await this.once<Part<Look>>(`observations${query({ stall, order: "newest", limit: String(LOOKS_SHOWN) })}`);
    return items;
  }

  features(survey: string): Promise<Features> {
    return this.once(`surveys/${survey}/stalls`);
  }

  private once<T>(path: string): Promise<T> {
    const now = this.now();
    const found = this.kept.get(path);
    if (found && now - found.at < KEPT_MS) return found.answer as Promise<T>;
    const answer = read<T>(`${this.base}/${path}`);
    this.kept.set(path, { at: now, answer });
    answer.catch(() => this.kept.delete(path));
    return answer;
  }
}

/** Part of a list; `next` is where the following one begins. */
interface Part<T> {
  items: T[];
  next: string | null;
}

/** Reads a whole list of the API, part by part. */
export async function readAll<T>(name: string): Promise<T[]> {
  const found: T[] = [];
  let after = "";
  for (;;) {
    const { items, next } = await read<Part<T>>(`${API}/${name}${query({ limit: "1000", after })}`);
    found.push(...items);
    if (next === null) return found;
    after = next;
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
    answer = await fetch(address, { cache: "no-cache", ...options });
  } catch {
    throw new Refused(say("archive-unanswered"));
  }
  if (answer.ok) return await answer.json();
  throw new Refused(reason(await answer.text()) || say("archive-refused", { status: answer.status }));
}

function reason(text: string): string {
  try {
    const { field, detail = "" } = JSON.parse(text) as { field?: string; detail?: string };
    return field ? `${field}: ${detail}` : detail;
  } catch {
    return text.startsWith("<") ? "" : text;
  }
}
