import { say } from "../words/say.ts";
import { fetchJson } from "./fetch-json.ts";

/** A lot that lasts, with its newest survey. */
export interface Lot {
  id: string;
  name: string;
  stalls: number;
  surveys: number;
  /** UTC in ISO 8601; null without a survey. */
  lastSeen: string | null;
  /** Id of the newest survey. */
  newest: string | null;
}

/** Ends of the names of a survey's files, as the drone makes them. */
export const SURVEY_FILES = ["csv", "geojson", "gpkg", "kmz", "png"];

/** A survey that waits for the answer to "which lot is it?". */
export interface Undecided {
  id: string;
  ended: string;
  candidates: string[];
}

export interface Lots {
  lots: Lot[];
  undecided: Undecided[];
  /** Another one after each survey and change. */
  stamp: string;
}

interface Listed {
  lots: { id: string; name: string; stalls: number; survey_count: number; last_survey: { id: string; ended: string } | null }[];
  undecided: Undecided[];
  changes?: unknown;
}

/** Asks the drone for its lots; null when it does not answer. */
export async function fetchLots(): Promise<Lots | null> {
  const answer = (await fetchJson("api/lots.json")) as Listed | null;
  if (!Array.isArray(answer?.lots) || !Array.isArray(answer.undecided)) return null;
  const lots = answer.lots.map(({ id, name, stalls, survey_count, last_survey }) => ({
    id,
    name,
    stalls,
    surveys: survey_count,
    lastSeen: last_survey?.ended ?? null,
    newest: last_survey?.id ?? null,
  }));
  return { lots, undecided: answer.undecided, stamp: JSON.stringify(answer) };
}

/** Names a lot; returns the reason why that failed, else nothing. */
export function nameLot(lot: string, name: string): Promise<string> {
  return change(`api/lots/${lot}/name`, { name });
}

/** Moves a survey to a lot, to a new one for null; returns the reason why that failed, else nothing. */
export function moveSurvey(survey: string, lot: string | null): Promise<string> {
  return change(`api/surveys/${survey}/move`, { lot });
}

/** Posts a change of lots; returns the reason why that failed, else nothing. */
export async function change(address: string, body: object): Promise<string> {
  try {
    const answer = await fetch(address, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body), cache: "no-store" });
    if (answer.ok) return "";
    const text = await answer.text();
    if (answer.headers.get("Content-Type")?.startsWith("application/json") !== true) return text;
    const { field, reason } = JSON.parse(text) as { field: string; reason: string };
    return field === "" ? reason : `${field}: ${reason}`;
  } catch {
    return say("file-unanswered");
  }
}
