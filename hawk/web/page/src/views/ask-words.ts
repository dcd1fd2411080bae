import type { AskedUse, Estimate } from "../api.ts";
import type { Place } from "../route/place.ts";
import { KINDS } from "../plan/values.ts";
import { clockWords, dateFormat, dateLanguage } from "../words/clock.ts";
import { percent } from "../words/format.ts";
import { kindWords } from "../words/plan.ts";
import { language, number, say, sentences } from "../words/say.ts";
import { dayWords } from "./figures.ts";
import { DAYS, daysOf, HOURS, hoursOf, KINDS_OF_PARTS, type KindOfPart, namesOf, type Run, runs } from "./question.ts";
import { DAY_MS } from "./time-bar-days.ts";

/** A Monday, from which days of the week have their names. */
const MONDAY = Date.UTC(2024, 0, 1);

/** Name of a day of the week, 0 for Monday. */
export function dayName(day: number, weekday: "short" | "long"): string {
  return dayWords(MONDAY + day * DAY_MS, { weekday });
}

export function monthWords(month: string): string {
  return dayWords(Date.parse(`${month}-01`), { month: "long", year: "numeric" });
}

/** Name of a row, zone, kind of stalls or section in the words of the page. */
export function partName(kind: KindOfPart, name: string): string {
  if (kind === "zone" && name === "no zone") return say("archive-no-zone");
  if (kind !== "kind") return name;
  const known = KINDS.find((each) => each === (name === "normal" ? "" : name));
  return known === undefined ? name : kindWords(known);
}

/** What is asked: rows, zones and kinds, or sections. */
export function partsWords(parts: readonly string[]): string {
  const words = KINDS_OF_PARTS.map((kind) => {
    const names = namesOf(parts, kind).map((name) => partName(kind, name));
    return kind === "row" && names.length > 0 ? say("ask-rows", { count: names.length, names: names.join(", ") }) : names.join(", ");
  });
  return words.filter((each) => each !== "").join(" · ") || say("ask-whole-lot");
}

export function daysWords(days: string): string {
  const found = daysOf(days);
  if (found.length === DAYS.length) return say("ask-every-day");
  const words = ([first, last]: Run): string =>
    first === last ? dayName(first, "short") : say("ask-run", { first: dayName(first, "short"), last: dayName(last, "short") });
  return runs(found).map(words).join(", ");
}

export function hoursWords(hours: string): string {
  const found = hoursOf(hours);
  if (found.length === HOURS) return say("ask-every-hour");
  return runs(found).map(([first, last]) => say("ask-hours-run", { first, last: last + 1 })).join(", ");
}

/** The month that a period is, as 2026-05; "" for another period. */
export function monthOf({ from, to }: Pick<Place, "from" | "to">): string {
  const [begin, end] = monthEnds(from.slice(0, 7));
  return from !== "" && from === begin && to === end ? from.slice(0, 7) : "";
}

/** First and last day of a month. */
export function monthEnds(month: string): [string, string] {
  const [year = 0, index = 1] = month.split("-").map(Number);
  const last = new Date(Date.UTC(year, index, 0)).getUTCDate();
  return [`${month}-01`, `${month}-${last}`];
}

/** A period, and which preposition it takes. */
export function periodWords(place: Pick<Place, "from" | "to">): { period: "all" | "month" | "days"; when: string } {
  const { from, to } = place;
  const month = monthOf(place);
  if (month !== "") return { period: "month", when: monthWords(month) };
  const day = (text: string): string => Number.isNaN(Date.parse(text)) ? text : dayWords(Date.parse(text), { day: "numeric", month: "long", year: "numeric" });
  if (from !== "" && to !== "") return { period: "days", when: say("ask-dates", { first: day(from), last: day(to) }) };
  if (from !== "") return { period: "days", when: say("ask-since", { day: day(from) }) };
  if (to !== "") return { period: "days", when: say("ask-until", { day: day(to) }) };
  return { period: "all", when: say("ask-every-survey") };
}

export function percentOf(share: number | null): string {
  return number(100 * (share ?? 0));
}

/** "85 to 94 %". */
export function lowHigh({ low, high }: Estimate): string {
  return low === null || high === null ? "–" : say("ask-low-high", { low: percentOf(low), high: percentOf(high) });
}

/** What was taken at some time; sections whose places nobody said have a number alone. */
export type Use = Pick<AskedUse, "occupancy" | "accumulation">;

/** "88 %", or "3.5" vehicles. */
export function amountOf({ occupancy, accumulation }: Use): string {
  if (occupancy.value !== null) return percent(100 * occupancy.value);
  return accumulation.value === null ? "–" : number(accumulation.value, 1);
}

/** "85 to 94 %", or "3 to 5.5". */
export function rangeOf({ occupancy, accumulation }: Use): string {
  const { low, high } = accumulation;
  if (occupancy.value !== null || low === null || high === null) return lowHigh(occupancy);
  return say("ask-range", { low: number(low, 1), high: number(high, 1) });
}

/** How dark a time is drawn, 0 to 1: by its share; by the largest number where that alone is known. */
export function shadeOf(answer: AskedUse, { occupancy, accumulation }: Use): number {
  return Math.min(1, occupancy.value ?? (accumulation.value ?? 0) / mostOf(answer));
}

/** The largest number of vehicles in an hour of the week or at a survey, 1 at least. */
export function mostOf({ cells, surveys }: AskedUse): number {
  return Math.max(1, ...[...cells, ...surveys].map(({ accumulation }) => accumulation.value ?? 0));
}

/** An hour of a weekday: "8:00 to 9:00". */
export function hourWords(hour: number): string {
  return say("ask-hour-from", { first: hour, last: hour + 1 });
}

/** The answer in sentences: stalls, the fullest and the emptiest hour. */
export function answerWords(answer: AskedUse): string {
  const { fullest, emptiest } = answer;
  const taken = takenWords(answer);
  if (!fullest || !emptiest || fullest === emptiest || (fullest.weekday === emptiest.weekday && fullest.hour === emptiest.hour)) return taken;
  const day = (name: string): string => dayName(WEEKDAYS.indexOf(name), "long");
  const hour = (value: number): string => say("ask-hour", { hour: value });
  return sentences(
    taken,
    say("ask-ends", {
      fullDay: day(fullest.weekday), fullHour: hour(fullest.hour), full: amountOf(fullest),
      emptyDay: day(emptiest.weekday), emptyHour: hour(emptiest.hour), empty: amountOf(emptiest),
    }),
  );
}

/** How much is taken on average, with its unit: stalls, or vehicles of the places of sections. */
function takenWords({ accumulation, stalls, places, unit }: AskedUse): string {
  const digits = unit === "stalls" ? 0 : 1;
  const [low, high] = [number(accumulation.low ?? 0, digits), number(accumulation.high ?? 0, digits)];
  if (unit === "stalls") return say("ask-stalls", { exact: low === high ? "yes" : "no", low, high, stalls });
  const value = number(accumulation.value ?? 0, 1);
  return places === null ? say("ask-vehicles", { value, low, high }) : say("ask-places", { value, low, high, places });
}

/** What stands behind an answer: surveys, days, dates, clock, and the asked hours at which nobody flew. */
export function behindWords(answer: AskedUse): string {
  const dates = answer.surveys.map(({ at }) => Date.parse(`${at.slice(0, 10)}T00:00Z`)).sort((one, other) => one - other);
  const [first, last] = [dates[0], dates.at(-1)];
  if (first === undefined || last === undefined) return "";
  const range = dateFormat(dateLanguage(), { day: "numeric", month: "long", year: "numeric", timeZone: "UTC" }).formatRange(first, last);
  const never = answer.asked.hours.filter((hour) => !answer.cells.some((cell) => cell.is_asked && cell.hour === hour && cell.days > 0));
  return sentences(
    say("ask-behind", { surveys: answer.accumulation.surveys, days: answer.days, dates: range, clock: clockWords(answer.clock) }),
    never.length === 0 || answer.asked.hours.length === HOURS ? "" : say("ask-nobody-at", { hours: alternatives(never.map(String)) }),
    answer.left_out.length === 0 ? "" : say("archive-left-out-count", { surveys: answer.left_out.length }),
  );
}

const WEEKDAYS: readonly string[] = ["Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday", "Sunday"];

/** "7, 8 or 9". */
function alternatives(words: string[]): string {
  return new Intl.ListFormat(language(), { type: "disjunction" }).format(words);
}
