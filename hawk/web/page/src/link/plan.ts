import type { Comparison, Edited, FoundStall, Lot, Survey, Plan, PlanPreview } from "../api.ts";
import { answer, API, orNull, post, read, readAll, Refused } from "./api.ts";

/** A plan, or what of it changed since a revision; `whole`: all of it. */
export type PlanChange = Pick<Plan, "whole" | "stalls" | "gone" | "zones" | "named_zones" | "sections" | "edit"> & { revision: number };

/** A lot with its plan, and what its newest registered survey saw besides. */
export interface PlannedLot {
  id: string;
  name: string;
  datum: [number, number];
  surveys: Survey[];
  found: FoundStall[];
}

/** What an operation, an undo or a redo changed; `whole`: all of the plan came. */
export type Done = Pick<Edited, "revision" | "stalls" | "gone" | "zones" | "named_zones" | "sections" | "undo" | "redo"> & { whole?: boolean };

/** Why the store did not do something. `editor`: another person edits. */
export type Refusal = Pick<Refused, "message" | "editor" | "status">;

/** Status of a refusal of a value; any other one may come of a lost edit. */
export const WRONG_VALUE = 422;

/** The drone's server did not answer: what was asked may have been done. */
export const UNANSWERED = "unanswered";

export type Reply<T> = { done: T } | { refused: Refusal } | typeof UNANSWERED;

/** Fetches a lot; null when the drone does not answer. */
export async function fetchLot(lot: string): Promise<PlannedLot | null> {
  const path = `lots/${lot}`;
  const asked = [read<Lot>(`${API}/${path}`), readAll<Survey>(`${path}/surveys`), read<Comparison>(`${API}/${path}/comparison`)] as const;
  const known = await orNull(Promise.all(asked));
  return known && { ...known[0], surveys: known[1], found: known[2].found };
}

/** Fetches a plan, or what changed after a revision; null when the drone does not answer. */
export function fetchPlan(lot: string, since: number | null): Promise<PlanChange | null> {
  return answer(`${API}/lots/${lot}/plan${since === null ? "" : `?since=${since}`}`);
}

/** Asks for a change of a plan: `path` is "edit", "edit/close", "plan", "plan/undo" or "plan/redo". */
export async function postPlan<T>(lot: string, path: string, body: object): Promise<Reply<T>> {
  return replied(post<T>(`lots/${lot}/${path}`, body));
}

/** Sends a file with a plan to be read; `choices`: as the person made them. Nothing is written. */
export async function previewPlan(lot: string, file: File, choices: URLSearchParams): Promise<Reply<PlanPreview>> {
  const asked = new URLSearchParams(choices);
  asked.set("name", file.name);
  return replied(post(`lots/${lot}/plan/import?${asked.toString()}`, file));
}

async function replied<T>(asked: Promise<T>): Promise<Reply<T>> {
  try {
    return { done: await asked };
  } catch (error) {
    return error instanceof Refused && error.status !== 0 ? { refused: error } : UNANSWERED;
  }
}
