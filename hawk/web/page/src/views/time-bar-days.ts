import type { SurveyUse } from "../api.ts";
import { onClock } from "../words/clock.ts";
import { timeWords } from "./figures.ts";

export const SPANS = ["day", "week", "month"] as const;
export type Span = (typeof SPANS)[number];

/** A survey on the bar; `left`: pixels from the begin of its day. `ids`: all that it stands for, which lie too near each other. */
export interface Tick {
  survey: SurveyUse;
  left: number;
  clock: string;
  ids: readonly string[];
  /** Mean share that is taken; null where none is known. */
  share: number | null;
}

/** A day of the lot's clock; `date`: its midnight, as if that clock were UTC. */
export interface Day {
  date: number;
  ticks: Tick[];
}

/** Hours of the day that the bar shows, first and last. */
export type Hours = readonly [number, number];

export const DAY_MS = 86_400_000;
export const HOUR_MS = 3_600_000;
const WEEK_DAYS = 7;
/** Days of a narrow bar in place of a week. */
const FEW_DAYS = 3;
/** The first day of 1970 was a Thursday, three days after a Monday. */
const AFTER_MONDAY = 3;
/** Hours that are shown in any case. */
const USUAL: Hours = [7, 19];
/** Ticks nearer than this, pixels, are one; so much more for each digit of their number beyond the first. */
export const APART_PX = 12;
const DIGIT_PX = 7;

/** Whether a clock's time lies in the day of a midnight. */
export function isOn(clock: number, midnight: number): boolean {
  return clock >= midnight && clock < midnight + DAY_MS;
}

/** The midnights of the day, the week or the month that a clock's time lies in: nothing moves while one goes within it. */
export function midnightsOf(clock: number, span: Span, isNarrow = false): number[] {
  const day = Math.floor(clock / DAY_MS);
  const from = (first: number, count: number): number[] => Array.from({ length: count }, (_, index) => (first + index) * DAY_MS);
  if (span === "day") return from(day, 1);
  if (span === "week") return isNarrow ? from(day - (day % FEW_DAYS), FEW_DAYS) : from(day - ((day + AFTER_MONDAY) % WEEK_DAYS), WEEK_DAYS);
  const date = new Date(clock);
  const [first, next] = [Date.UTC(date.getUTCFullYear(), date.getUTCMonth(), 1), Date.UTC(date.getUTCFullYear(), date.getUTCMonth() + 1, 1)];
  return from(first / DAY_MS, (next - first) / DAY_MS);
}

/** A day as the API takes it: 2026-05-04. */
export function dayOf(midnight: number): string {
  return new Date(midnight).toISOString().slice(0, 10);
}

/** Hours of the day with everything that is shown. */
export function hoursOf(clocks: readonly number[]): Hours {
  const hours = clocks.map(hourOf);
  return [Math.min(USUAL[0], ...hours.map(Math.floor)), Math.max(USUAL[1], ...hours.map((hour) => Math.floor(hour) + 1))];
}

function hourOf(clock: number): number {
  return (((clock % DAY_MS) + DAY_MS) % DAY_MS) / HOUR_MS;
}

/** Where a clock's time lies in its day, pixels. */
export function leftOf(clock: number, [first, last]: Hours, width: number): number {
  return (width * (hourOf(clock) - first)) / (last - first);
}

/** The surveys of days, by the lot's clock; those that lie too near are one. `width`: of a day, pixels. */
export function daysOf(surveys: readonly SurveyUse[], midnights: readonly number[], zone: string, hours: Hours, width: number, shareOf: (survey: SurveyUse) => number | null): Day[] {
  const placed = surveys.map((survey) => ({ survey, clock: onClock(survey.at, zone) })).sort((one, other) => one.clock - other.clock);
  return midnights.map((date) => {
    const groups: { left: number; clock: number; surveys: [SurveyUse, ...SurveyUse[]] }[] = [];
    for (const { survey, clock } of placed) {
      if (!isOn(clock, date)) continue;
      const left = leftOf(clock, hours, width);
      const last = groups.at(-1);
      if (last && left - last.left < apart(last.surveys.length)) last.surveys.push(survey);
      else groups.push({ left, clock, surveys: [survey] });
    }
    return { date, ticks: groups.map(({ left, clock, surveys: all }) => tickOf(all, left, clock, shareOf)) };
  });
}

/** The number of surveys stands above its tick: the next one leaves it room. */
function apart(surveys: number): number {
  return APART_PX + DIGIT_PX * (String(surveys).length - 1);
}

function tickOf(all: readonly [SurveyUse, ...SurveyUse[]], left: number, clock: number, shareOf: (survey: SurveyUse) => number | null): Tick {
  return { survey: all[0], left, clock: timeWords(clock), ids: all.map(({ id }) => id), share: mean(all.map(shareOf)) };
}

function mean(shares: readonly (number | null)[]): number | null {
  const known = shares.filter((share) => share !== null);
  return known.length === 0 ? null : known.reduce((sum, share) => sum + share, 0) / known.length;
}

/** Words below the bar. */
export interface Caption {
  left: number;
  text: string;
  tone: "on" | "" | "due";
}

const LETTER_PX = 7;
const PADDING_PX = 12;
const GAP_PX = 4;

/** Those that have room, the first ones first. What is chosen makes room beside another one. */
export function fitting(captions: readonly Caption[], width: number): Caption[] {
  const taken: [number, number][] = [];
  return captions.flatMap((caption) => {
    const size = caption.text.length * LETTER_PX + PADDING_PX;
    const within = (left: number): number => Math.max(0, Math.min(width - size, left));
    const beside = caption.tone === "on" ? taken.flatMap(([from, to]) => [from - GAP_PX - size, to + GAP_PX]) : [];
    const left = [caption.left - size / 2, ...beside].map(within).find((each) => taken.every(([from, to]) => each >= to || each + size <= from));
    if (left === undefined) return [];
    taken.push([left, left + size]);
    return [{ ...caption, left }];
  });
}
