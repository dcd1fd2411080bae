import type { AskedUse, Change, Changed, DueList, Figures, Observation, Recording, SeenSections, StallsUse, Survey, SurveyGround, SurveyMap, SurveysUse } from "../api.ts";
import type { LocalPlane } from "../fence/plane.ts";
import { API, orNull, type Part, query, read, readAll, readByLink } from "../link/api.ts";
import type { Place } from "../route/place.ts";
import { askedOf } from "./question.ts";
import { onMap, planeOf, type SurveyOnMap } from "./survey-source.ts";

/** Days of the period, as 2026-05-04; "" without that end. */
export interface Period {
  from: string;
  to: string;
}

/** An answer is shared by the parts of the page for so long, milliseconds; a survey that lands is seen then. */
const KEPT_MS = 30_000;
const LOOKS_SHOWN = 30;
/** Number of the newest surveys of which one that counts is looked for. */
const NEWEST = "8";
const DUE_DAYS = "35";

/** A survey that a person deleted, and the change that undoing brings it back by. */
export interface DeletedSurvey {
  survey: string;
  ended: string;
  seq: number;
}

/** The recordings of a survey's flights that can be shown. */
export function recordingsOf(all: readonly Recording[], survey: string): Recording[] {
  return all.filter(({ lot, under_way }) => lot?.survey === survey && !under_way);
}

/** Reads of one lot: by its id, or by the token of a link that was shared. What two parts ask for is asked once. */
export class LotSource {
  readonly base: string;
  readonly isShared: boolean;
  /** Recordings may be read and asked for: not by a link, nor by a role for some lots. */
  readonly hasRecordings: boolean;
  private readonly kept = new Map<string, { at: number; answer: Promise<unknown> }>();
  private readonly now: () => number;
  /** In which all surveys of the lot are shown: place and zoom stay when one follows another. */
  private plane: LocalPlane | null = null;

  constructor(base: string, hasRecordings = true, now = (): number => Date.now()) {
    this.base = `${API}/${base}`;
    this.isShared = base.startsWith("shared/");
    this.hasRecordings = hasRecordings && !this.isShared;
    this.now = now;
  }

  /** Something was changed: everything is asked for again. */
  forget(): void {
    this.kept.clear();
  }

  surveys(period: Period): Promise<SurveysUse> {
    return this.once(`statistics/surveys${query({ ...period })}`);
  }

  survey(survey: string): Promise<SurveysUse> {
    return this.once(`statistics/surveys${query({ survey })}`);
  }

  newest(): Promise<SurveysUse> {
    return this.once(`statistics/surveys${query({ newest: NEWEST })}`);
  }

  /** The surveys of the lot that are deleted, and ended in a period; a link knows of none. */
  async deleted(period: Period): Promise<DeletedSurvey[]> {
    if (this.isShared) return [];
    const changes = await this.keep(`${API}/changes`, () => readAll<Change>("changes", { lot: this.base.slice(`${API}/lots/`.length) }));
    const undoable = new Map(changes.filter(({ kind, undone }) => kind === "delete" && undone === null).flatMap(({ surveys, seq }) => surveys.map((id) => [id, seq] as const)));
    if (undoable.size === 0) return [];
    const all = await readAll<Survey>("surveys", { placed: "deleted", ...period });
    return all.flatMap(({ id, ended }) => (undoable.has(id) ? [{ survey: id, ended, seq: undoable.get(id) ?? 0 }] : []));
  }

  /** When surveys are due; a link knows of none. */
  async due(): Promise<string[]> {
    return this.isShared ? [] : (await this.once<DueList>(`due${query({ days: DUE_DAYS })}`)).items;
  }

  /** What was recorded over the lot. */
  async recordings(): Promise<Recording[]> {
    if (!this.hasRecordings) return [];
    const all = await this.keep(`${API}/recordings`, () => readAll<Recording>("recordings"));
    return all.filter(({ lot }) => lot !== null && this.base === `${API}/lots/${lot.id}`);
  }

  statistics(period: Period, by = ""): Promise<Figures> {
    return this.once(`statistics${query({ ...period, by })}`);
  }

  /** The answer to what the address asks. */
  asked(place: Place): Promise<AskedUse> {
    return this.once(`statistics/ask${query(askedOf(place))}`);
  }

  heat(period: Period): Promise<StallsUse> {
    return this.once(`statistics/stalls${query({ ...period })}`);
  }

  between(before: string, after: string): Promise<Changed> {
    return this.once(`statistics/between${query({ before, after })}`);
  }

  /** The newest looks at a stall. */
  async looks(stall: string): Promise<Observation[]> {
    const { items } = await this.once<Part<Observation>>(`observations${query({ stall, order: "newest", limit: String(LOOKS_SHOWN) })}`);
    return items;
  }

  /** The sections of the lot with what a survey saw of each. */
  sections(survey: string): Promise<SeenSections> {
    return this.once(`surveys/${survey}/sections`);
  }

  map(survey: string): Promise<SurveyMap> {
    return this.once(`surveys/${survey}/map`);
  }

  /** A survey with its picture, null where it has neither a stall nor a picture; a link shows no picture. */
  async onMap(survey: string): Promise<SurveyOnMap | null> {
    const asked = this.ground(survey);
    const [map, ground] = [await this.map(survey), await asked];
    this.plane ??= planeOf(map, ground);
    return this.plane && onMap(survey, map, ground, this.plane);
  }

  /** Where the picture of a survey lies; null for a link, and where there is none. */
  ground(survey: string): Promise<SurveyGround | null> {
    return this.isShared ? Promise.resolve(null) : orNull(this.ask<SurveyGround>(`${API}/surveys/${survey}/ground`));
  }

  private once<T>(path: string): Promise<T> {
    return this.ask(`${this.base}/${path}`);
  }

  private ask<T>(address: string): Promise<T> {
    return this.keep(address, () => (this.isShared ? readByLink<T>(address) : read<T>(address)));
  }

  private keep<T>(address: string, work: () => Promise<T>): Promise<T> {
    const now = this.now();
    const found = this.kept.get(address);
    if (found && now - found.at < KEPT_MS) return found.answer as Promise<T>;
    const answer = work();
    this.kept.set(address, { at: now, answer });
    answer.catch(() => this.kept.delete(address));
    return answer;
  }
}
