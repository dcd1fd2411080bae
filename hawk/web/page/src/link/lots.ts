import type { ChangeList, DayPlan, DroneProposals, ListedLot, PossiblePlaces, Proposals, Survey, SurveyProposals } from "../api.ts";
import { learn } from "../words/drone.ts";
import { say } from "../words/say.ts";
import { answer, API, orNull, post, read, readAll, Refused } from "./api.ts";

/** Kinds of a survey's files, as the drone makes them. */
export const SURVEY_FILES = ["csv", "geojson", "gpkg", "kmz", "png", "sections.csv", "sections.geojson"];

export interface Lots {
  lots: ListedLot[];
  /** Surveys that wait for the answer to "which lot is it?". */
  undecided: Survey[];
  /** Another one after each survey and change. */
  stamp: string;
}

/** Asks the drone for its lots; null when it does not answer. */
export async function fetchLots(): Promise<Lots | null> {
  const asked = [readAll<ListedLot>("lots"), readAll<Survey>("surveys", { placed: "undecided" }), read<ChangeList>(`${API}/changes`)] as const;
  const found = await orNull(Promise.all(asked));
  return found && { lots: found[0], undecided: found[1], stamp: JSON.stringify(found) };
}

/** Asks what the surveys of a lot propose to change; null when the drone does not answer. */
export function fetchProposals(lot: string): Promise<Proposals | null> {
  return answer(`${API}/lots/${lot}/proposals`);
}

/** Asks where a survey may lie; null when the drone does not answer. */
export function fetchPlaces(survey: string): Promise<PossiblePlaces | null> {
  return answer(`${API}/surveys/${survey}/places`);
}

/** Names a lot; returns the reason why that failed, else nothing. */
export function nameLot(lot: string, name: string): Promise<string> {
  return change(`lots/${lot}/name`, { name });
}

/** Chooses the clock of a lot, "" for that of its place; returns the reason why that failed, else nothing. */
export function chooseClock(lot: string, zone: string): Promise<string> {
  return change(`lots/${lot}/time-zone`, { time_zone: zone === "" ? null : zone });
}

/** Moves a survey to a lot, to a new one for null; returns the reason why that failed, else nothing. */
export function moveSurvey(survey: string, lot: string | null): Promise<string> {
  return change(`surveys/${survey}/move`, { lot });
}

/** A forecast. `wind` and `gust` in m/s, `cloud` in percent, `rain` in mm. */
export interface Forecast {
  made: string;
  hours: { begin: string; hours: number; wind: number; gust: number; cloud: number; rain: number }[];
}

/** Asks for the day's rounds; their sentences are learnt. Rejects with Refused. */
export async function planDay(batteries: number, forecast: Forecast | null): Promise<DayPlan> {
  const plan = await post<DayPlan>("day-plan", { batteries, forecast });
  learn(plan.sentences.map(({ text, code, values }) => ({ Text: text, Code: code, Values: values })));
  return plan;
}

/** Takes proposals over, those of confirmed stalls too where `all`; returns the reason why that failed, else nothing. */
export function takeOver(lot: string, changes: SurveyProposals, all: boolean): Promise<string> {
  const end = all ? changes.end.map(({ id }) => id) : "all";
  return change(`lots/${lot}/take-over`, { survey: changes.survey, begin: "all", end });
}

/** Drops all proposals of a survey; returns the reason why that failed, else nothing. */
export function dropChanges(lot: string, survey: string): Promise<string> {
  return change(`lots/${lot}/drop`, { survey, begin: "all", end: "all" });
}

/** Takes the changes of a plan on a drone over; returns the reason why that failed, else nothing. */
export function takeOverDrone(lot: string, { drone, base }: DroneProposals): Promise<string> {
  return change(`lots/${lot}/take-over`, { drone, base });
}

/** Drops the changes of a plan on a drone; returns the reason why that failed, else nothing. */
export function dropDrone(lot: string, { drone, base }: DroneProposals): Promise<string> {
  return change(`lots/${lot}/drop`, { drone, base });
}

/** Merges another lot into a lot; returns the reason why that failed, else nothing. */
export function mergeLot(lot: string, other: string): Promise<string> {
  return change(`lots/${lot}/merge`, { with: other });
}

/** Says where a survey lies; returns the reason why that failed, else nothing. */
export function choosePlace(survey: string, place: number): Promise<string> {
  return change(`surveys/${survey}/place`, { place });
}

async function change(path: string, body: object): Promise<string> {
  try {
    await post(path, body);
    return "";
  } catch (error) {
    return (error instanceof Refused && error.message) || say("file-unanswered");
  }
}
