import { ofDrone } from "./drone.ts";
import type { LogLine } from "../state/flight.ts";

/** Which messages are shown: those that contain `text` in any case, `troubles`: warnings and errors alone. */
export interface LogFilter {
  text: string;
  troubles: boolean;
}

export function matching(lines: readonly LogLine[], filter: LogFilter): LogLine[] {
  const wanted = filter.text.trim().toLowerCase();
  return lines.filter((line) => isShown(line, filter.troubles) && `${ofDrone(line.text)}\n${ofDrone(line.details)}`.toLowerCase().includes(wanted));
}

function isShown(line: LogLine, troubles: boolean): boolean {
  return !troubles || line.level === "warning" || line.level === "error";
}

/** Messages as a text file, the oldest first: time in UTC, level, text, and the details on lines of their own. */
export function logText(lines: readonly LogLine[]): string {
  return lines
    .toReversed()
    .map((line) => `${[`${line.time} ${line.level.padEnd(7)} ${line.text}`, ...detailLines(line)].join("\n")}\n`)
    .join("");
}

function detailLines(line: LogLine): string[] {
  return line.details === "" ? [] : line.details.split("\n").map((detail) => `    ${detail}`);
}

/** Name of the file, by the time (UTC, ISO 8601) of the newest message; Windows allows no colon in it. */
export function logName(newest: string): string {
  return `hawk-messages-${newest.slice(0, 19).replaceAll(":", "-")}.txt`;
}
