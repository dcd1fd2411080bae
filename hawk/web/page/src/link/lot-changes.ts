import { fetchJson } from "./fetch-json.ts";
import { change } from "./lots.ts";

/** Corners on Earth, [latitude, longitude], degrees. */
export type Corners = readonly (readonly [number, number])[];

export interface Beginning {
  id: number;
  corners: Corners;
}

export interface Ending {
  id: string;
  label: string;
  is_confirmed: boolean;
  corners: Corners;
}

/** What one survey proposes to change. */
export interface SurveyChanges {
  survey: string;
  ended: string;
  begin: Beginning[];
  end: Ending[];
}

/** A survey whose place is not certain. */
export interface DoubtfulSurvey {
  survey: string;
  ended: string;
  why: string;
  places: number;
}

export interface LotChanges {
  surveys: SurveyChanges[];
  doubtful: DoubtfulSurvey[];
}

/** North, east, angle, width, length in the lot's frame: metres, radians clockwise from north. */
export type Shape = readonly [number, number, number, number, number];

/** The stalls of a lot, and those of a survey at each place where it may lie. */
export interface PossiblePlaces {
  known: Shape[];
  places: { stalls: Shape[] }[];
}

/** Asks what the surveys of a lot propose to change; null when the drone does not answer. */
export async function fetchChanges(lot: string): Promise<LotChanges | null> {
  const answer = (await fetchJson(`api/lots/${lot}/changes.json`)) as LotChanges | null;
  return Array.isArray(answer?.surveys) && Array.isArray(answer.doubtful) ? answer : null;
}

/** Asks where a survey may lie; null when the drone does not answer. */
export async function fetchPlaces(survey: string): Promise<PossiblePlaces | null> {
  const answer = (await fetchJson(`api/surveys/${survey}/places.json`)) as PossiblePlaces | null;
  return Array.isArray(answer?.known) && Array.isArray(answer.places) ? answer : null;
}

/** Takes changes over, those of confirmed stalls too where `all`; returns the reason why that failed, else nothing. */
export function takeOver(lot: string, changes: SurveyChanges, all: boolean): Promise<string> {
  const end = all ? changes.end.map(({ id }) => id) : "all";
  return change(`api/lots/${lot}/take-over`, { survey: changes.survey, begin: "all", end });
}

/** Drops all changes of a survey; returns the reason why that failed, else nothing. */
export function dropChanges(lot: string, survey: string): Promise<string> {
  return change(`api/lots/${lot}/drop`, { survey, begin: "all", end: "all" });
}

/** Says where a survey lies; returns the reason why that failed, else nothing. */
export function choosePlace(survey: string, place: number): Promise<string> {
  return change(`api/surveys/${survey}/place`, { place });
}
