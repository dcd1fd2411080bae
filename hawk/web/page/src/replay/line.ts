/** Time line of a recorded flight, as the drone's program has it. Times are seconds of the replay. */
export interface Line {
  name: string;
  utc: string;
  maker: string;
  damage: string;
  seconds: number;
  events: Event[];
  /** Seconds, latitude, longitude, height above the arm place in metres. */
  track: [number, number, number, number][];
  pictures: number[];
  maps: number[];
}

export interface Event {
  at: number;
  kind: "message" | "state" | "command" | "decision";
  text: string;
  level: string;
}

export const SPEEDS = [0.25, 0.5, 1, 2, 4, 8, 16] as const;

/** The last of some rising times that is not after another one; -1 before the first. */
export function lastAt(times: readonly number[], at: number): number {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((times[middle] ?? Infinity) <= at) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/** The state that the drone was in: that of the last event of its kind. */
export function stateAt(events: readonly Event[], at: number): string {
  return events.filter((event) => event.kind === "state" && event.at <= at).at(-1)?.text ?? "";
}

/** A time on the bar: 3:07. */
export function clockOf(seconds: number): string {
  const whole = Math.max(0, Math.floor(seconds));
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
}
