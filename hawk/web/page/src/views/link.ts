import type { AboutSurvey, Changed, Figures, Observation, StallsUse, SurveysUse } from "../api.ts";
import { API, type Part, query, read } from "../link/api.ts";

/** A survey as the drone's GeoJSON has it. */
export interface Features {
  hawk: AboutSurvey;
  features: Feature[];
}

export interface Feature {
  id: string;
  geometry: { type: string; coordinates: unknown };
  properties: { amenity?: string; ref?: string; label?: string | null; state?: string; parking_space?: string; taken_probability?: number | null };
}

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

  surveys(period: Period): Promise<SurveysUse> {
    return this.once(`statistics/surveys${query({ ...period, time_zone: zone() })}`);
  }

  statistics(period: Period, by = ""): Promise<Figures> {
    return this.once(`statistics${query({ ...period, by, time_zone: zone() })}`);
  }

  heat(period: Period): Promise<StallsUse> {
    return this.once(`statistics/stalls${query({ ...period, time_zone: zone() })}`);
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

/** Days and hours are those of the browser's clock. */
function zone(): string {
  return Intl.DateTimeFormat().resolvedOptions().timeZone;
}
