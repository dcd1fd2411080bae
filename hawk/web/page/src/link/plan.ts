import type { Datum, PlacedSurvey, Shift } from "../plan/frame.ts";
import type { PlanStall, PlanZone } from "../plan/values.ts";
import type { Rectangle } from "../map/geometry.ts";
import { fetchJson } from "./fetch-json.ts";

/** Who edits a plan. Times are UTC in ISO 8601. */
export interface Editor {
  who: string;
  since: string;
}

/** A plan, or what of it changed since a revision; `whole`: all of it. */
export interface PlanChange {
  revision: number;
  whole: boolean;
  stalls: PlanStall[];
  gone: string[];
  zones: PlanZone[];
  named_zones: PlanZone[];
  edit: Editor | null;
}

/** A lot with its plan, and what its newest registered survey saw besides. */
export interface PlannedLot {
  id: string;
  name: string;
  datum: Datum;
  surveys: PlacedSurvey[];
  found: Rectangle[];
}

/** An edit that is this person's. */
export interface OwnEdit {
  edit: string;
  who: string;
  since: string;
  undo: number;
  redo: number;
}

/** What an operation, an undo or a redo changed. */
export interface Done {
  revision: number;
  /** All of the plan came. */
  whole?: boolean;
  stalls: PlanStall[];
  gone: string[];
  zones: PlanZone[];
  named_zones: PlanZone[];
  undo: number;
  redo: number;
}

/** Number of the layout version that an edit made; null when nothing was changed. */
export interface Closed {
  layout: number | null;
}

/** Why the store did not do something. `editor`: another person edits. */
export interface Refused {
  reason: string;
  editor: Editor | null;
  /** The value cannot be used (422); any other refusal may come of a lost edit. */
  byValue: boolean;
}

/** The drone's server did not answer: what was asked may have been done. */
export const UNANSWERED = "unanswered";

export type Reply<T> = { done: T } | { refused: Refused } | typeof UNANSWERED;

/** Fetches a lot; null when the drone does not answer. */
export async function fetchLot(lot: string): Promise<PlannedLot | null> {
  const answer = (await fetchJson(`api/lots/${lot}.json`)) as Listed | null;
  if (!Array.isArray(answer?.datum)) return null;
  const { id, name, datum, surveys, newest_registered } = answer;
  return { id, name, datum, surveys, found: newest_registered?.found ?? [] };
}

interface Listed {
  id: string;
  name: string;
  datum: [number, number];
  surveys: { datum: [number, number] | null; place: Shift | null }[];
  newest_registered: { found: Rectangle[] } | null;
}

/** Fetches a plan, or what changed after a revision; null when the drone does not answer. */
export async function fetchPlan(lot: string, since: number | null): Promise<PlanChange | null> {
  const answer = (await fetchJson(`api/lots/${lot}/plan.json${since === null ? "" : `?since=${since}`}`)) as PlanChange | null;
  return Array.isArray(answer?.stalls) ? answer : null;
}

/** Asks for a change of a plan: `path` is "edit", "edit/close", "plan", "plan/undo" or "plan/redo". */
export async function postPlan<T>(lot: string, path: string, body: object): Promise<Reply<T>> {
  return post(`${lot}/${path}`, { headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) });
}

async function post<T>(path: string, sent: RequestInit): Promise<Reply<T>> {
  try {
    const answer = await fetch(`api/lots/${path}`, { method: "POST", cache: "no-store", ...sent });
    if (answer.ok) return { done: (await answer.json()) as T };
    return { refused: await refusal(answer) };
  } catch {
    return UNANSWERED;
  }
}

/** A stall of a file on its place in the lot's frame. */
export interface ImportedStall extends Rectangle {
  label: string;
}

/** What the import of a file would change of a plan. */
export interface ImportPreview {
  token: string;
  file: string;
  placed: { is_certain: boolean; doubt: string };
  begin: ImportedStall[];
  stay: ImportedStall[];
  end: ImportedStall[];
  /** Number of stalls that the plan has as the file does. */
  same: number;
  left_out: { name: string; reason: string }[];
  left_out_count: number;
  clashes: { name: string; reason: string }[];
  layers: { name: string; outlines: number }[];
}

/** Sends a file with a plan to be read; `choices`: as the person made them. Nothing is written. */
export async function previewPlan(lot: string, file: File, choices: URLSearchParams): Promise<Reply<ImportPreview>> {
  const query = new URLSearchParams(choices);
  query.set("name", file.name);
  return post(`${lot}/plan/import?${query.toString()}`, { body: file });
}

async function refusal(answer: Response): Promise<Refused> {
  const byValue = answer.status === 422;
  if (answer.headers.get("Content-Type")?.startsWith("application/json") !== true) {
    return { reason: await answer.text(), editor: null, byValue };
  }
  const { field, reason, who, since } = (await answer.json()) as { field: string; reason: string; who?: string; since?: string };
  const editor = who === undefined || since === undefined ? null : { who, since };
  return { reason: field === "" ? reason : `${field}: ${reason}`, editor, byValue };
}
