import type { SurveyUse } from "../api.ts";

/** A survey on the bar; `at`: part of the day, 0 to 1. `ids`: all that it stands for, which lie too near each other on the bar. */
export interface Tick {
  survey: SurveyUse;
  at: number;
  clock: string;
  ids: readonly string[];
}

/** A day of the lot's clock; `date`: its midnight, as if that clock were UTC. */
export interface Day {
  date: Date;
  ticks: Tick[];
}

const DAY_MS = 86_400_000;
const WEEK_DAYS = 7;
/** Ticks nearer than this part of a day are one: two hours. */
const APART = 1 / 12;

/** What a clock shows at a time, as if it were UTC, milliseconds; without a time zone the browser's. */
export function onClock(iso: string, zone?: string): number {
  const parts = new Intl.DateTimeFormat("en", { ...(zone === undefined ? {} : { timeZone: zone }), hourCycle: "h23", year: "numeric", month: "numeric", day: "numeric", hour: "numeric", minute: "numeric", second: "numeric" }).formatToParts(new Date(iso));
  const of = (type: string): number => Number(parts.find((part) => part.type === type)?.value ?? 0);
  return Date.UTC(of("year"), of("month") - 1, of("day"), of("hour"), of("minute"), of("second"));
}

/** The midnights of the week that ends with a day, `back` weeks before it. */
export function weekOf(iso: string, zone: string, back = 0): number[] {
  const last = Math.floor(onClock(iso, zone) / DAY_MS) * DAY_MS - back * WEEK_DAYS * DAY_MS;
  return Array.from({ length: WEEK_DAYS }, (_, index) => last - (WEEK_DAYS - 1 - index) * DAY_MS);
}

/** The surveys of days, by the lot's clock; of those that lie too near the newest stands for all. */
export function daysOf(surveys: readonly SurveyUse[], midnights: readonly number[], zone: string): Day[] {
  const placed = surveys.map((survey) => ({ survey, clock: onClock(survey.ended, zone) })).sort((one, other) => one.clock - other.clock);
  return midnights.map((midnight) => {
    const ticks: Tick[] = [];
    for (const { survey, clock } of placed.filter(({ clock: at }) => at >= midnight && at < midnight + DAY_MS)) {
      const at = (clock - midnight) / DAY_MS;
      const last = ticks.at(-1);
      const tick = { survey, at, clock: new Date(clock).toISOString().slice(11, 16), ids: [survey.id] };
      if (last && at - last.at < APART - 1e-6) ticks[ticks.length - 1] = { ...tick, at: last.at, ids: [...last.ids, survey.id] };
      else ticks.push(tick);
    }
    return { date: new Date(midnight), ticks };
  });
}
