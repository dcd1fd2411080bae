import type { AskedUse, Cell } from "../api.ts";
import type { Place } from "../route/place.ts";

/** Days of the week as a question names them, as in the drone's statistics. */
export const DAYS = ["mon", "tue", "wed", "thu", "fri", "sat", "sun"] as const;
export const HOURS = 24;
export const KINDS_OF_PARTS = ["row", "zone", "kind", "section"] as const;
export type KindOfPart = (typeof KINDS_OF_PARTS)[number];

/** Numbers that follow each other, from the first to the last one. */
export type Run = readonly [number, number];

/** The parameters that `statistics/ask` and the report take; "" for what is not given. */
export function askedOf({ parts, days, hours, from, to }: Place): Record<string, string | string[]> {
  return { ...Object.fromEntries(KINDS_OF_PARTS.map((kind) => [kind, namesOf(parts, kind)])), weekday: days, hour: hours, from, to };
}

/** Names of the rows, zones or kinds out of the parts of a question. */
export function namesOf(parts: readonly string[], kind: KindOfPart): string[] {
  return parts.filter((part) => part.startsWith(`${kind}.`)).map((part) => part.slice(kind.length + 1));
}

/** Parts with one more, or one less. Sections count vehicles: they are not asked together with stalls. */
export function switchedPart(parts: readonly string[], part: string): string[] {
  const isSection = part.startsWith("section.");
  return parts.includes(part) ? parts.filter((each) => each !== part) : [...parts.filter((each) => each.startsWith("section.") === isSection), part];
}

/** Days 0 to 6 of "mon-fri,sun"; all where nothing is asked, or it cannot be read. A run may go over the week's end. */
export function daysOf(text: string): number[] {
  const found = runsOf(text, (day) => DAYS.findIndex((each) => each === day)).flatMap(([first, last]) =>
    Array.from({ length: ((last - first + DAYS.length) % DAYS.length) + 1 }, (_, k) => (first + k) % DAYS.length),
  );
  return some(found, DAYS.length);
}

/** Hours 0 to 23 of "7-11,16"; the end of a run is not one of them. */
export function hoursOf(text: string): number[] {
  const found = runsOf(text, (hour) => (hour === "" ? -1 : Number(hour))).flatMap(([first, last, isOne]) => upTo(first, isOne ? first : last - 1));
  return some(found, HOURS);
}

export function daysText(days: readonly number[]): string {
  if (days.length === DAYS.length) return "";
  return runs(days).map(([first, last]) => (first === last ? DAYS[first] : `${DAYS[first]}-${DAYS[last]}`)).join(",");
}

export function hoursText(hours: readonly number[]): string {
  if (hours.length === HOURS) return "";
  return runs(hours).map(([first, last]) => (first === last ? String(first) : `${first}-${last + 1}`)).join(",");
}

/** Numbers in order as runs. */
export function runs(numbers: readonly number[]): Run[] {
  const found: [number, number][] = [];
  for (const each of [...new Set(numbers)].sort((one, other) => one - other)) {
    const last = found.at(-1);
    if (last?.[1] === each - 1) last[1] = each;
    else found.push([each, each]);
  }
  return found;
}

export function upTo(first: number, last: number): number[] {
  return Array.from({ length: Math.max(0, last - first + 1) }, (_, k) => first + k);
}

/** The cells of an answer by weekday and hour. */
export function cellAt({ cells }: AskedUse, day: number, hour: number): Cell | undefined {
  return cells[day * HOURS + hour];
}

/** Hours that are worth a column: flown or asked, twelve at least. */
export function hoursShown(answer: AskedUse): Run {
  const worth = answer.cells.filter(({ days, is_asked: isAsked }) => days > 0 || (isAsked && answer.asked.hours.length < HOURS)).map(({ hour }) => hour);
  const [first, last] = [Math.min(7, ...worth), Math.max(18, ...worth)];
  return [first, last];
}

/** The line that prints the same answer; `lot` is its name. */
export function commandOf(lot: string, { parts, days, hours, from, to }: Place): string {
  const named = parts.map((part) => ["--" + part.slice(0, part.indexOf(".")), part.slice(part.indexOf(".") + 1)]);
  const whole = [...parts, days, hours].join("") === "" ? "mon-sun" : days;
  const given = [...named, ["--weekday", whole], ["--hour", hours], ["--from", from], ["--to", to]].filter(([, value]) => value !== "");
  return ["hawk-drone stats", quoted(lot), ...given.map(([name, value = ""]) => `${name} ${quoted(value)}`)].join(" ");
}

/** As a shell takes it for one word. */
function quoted(text: string): string {
  return /^[\w.,:/-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`;
}

function runsOf(text: string, read: (value: string) => number): [number, number, boolean][] {
  return text.split(",").map((each) => {
    const [first = "", last] = each.split("-");
    return [read(first), read(last ?? first), last === undefined];
  });
}

/** All where one of them is none, or there is none. */
function some(found: readonly number[], count: number): number[] {
  const isRight = found.length > 0 && found.every((each) => Number.isInteger(each) && each >= 0 && each < count);
  return isRight ? [...new Set(found)].sort((one, other) => one - other) : upTo(0, count - 1);
}
