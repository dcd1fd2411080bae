import type { AskedUse, Changed, Figures, Observation, StallsUse, SurveyGround, SurveysUse } from "../api.ts";
import { API, orNull, type Part, query, read, readByLink } from "../link/api.ts";
import type { Place } from "../route/place.ts";
import { askedOf } from "./question.ts";
import { type Features, onMap, type SurveyOnMap } from "./survey-source.ts";

/** Days of the period, as 2026-05-04; "" without that end. */
export interface Period {
  from: string;
  to: string;
}

/** An answer is shared by the parts of the page for so long, milliseconds; a survey that lands is seen then. */
const KEPT_MS = 30_000;
const LOOKS_SHOWN = 30;

/** Reads of one lot: by its id, or by the token of a link that was shared. What two parts ask for is asked once. */
export class LotSource {
  readonly base: string;
  readonly isShared: boolean;
  private readonly kept = new Map<string, { at: number; answer: Promise<unknown> }>();
  private readonly now: () => number;

  constructor(base: string, now: () => number = Date.now) {
    this.base = `${API}/${base}`;
    this.isShared = base.startsWith("shared/");
    this.now = now;
  }

  /** Something was changed: everything is asked for again. */
  forget(): void {
    this.kept.clear();
  }

  surveys(period: Period): Promise<SurveysUse> {
    return this.once(`statistics/surveys${query({ ...period })}`);
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

  features(survey: string): Promise<Features> {
    return this.once(`surveys/${survey}/stalls`);
  }

  /** A survey with its picture; a link shows no picture. */
  async onMap(survey: string): Promise<SurveyOnMap | null> {
    const ground = this.isShared ? null : orNull(this.ask<SurveyGround>(`${API}/surveys/${survey}/ground`));
    return onMap(survey, await this.features(survey), await ground);
  }

  private once<T>(path: string): Promise<T> {
    return this.ask(`${this.base}/${path}`);
  }

  private ask<T>(address: string): Promise<T> {
    const now = this.now();
    const found = this.kept.get(address);
    if (found && now - found.at < KEPT_MS) return found.answer as Promise<T>;
    const answer = this.isShared ? readByLink<T>(address) : read<T>(address);
    this.kept.set(address, { at: now, answer });
    answer.catch(() => this.kept.delete(address));
    return answer;
  }
}
