import type { ListedSection, PlanSection, SectionChange, SectionLook } from "../api.ts";
import { number, say } from "./say.ts";

export const SECTION_KINDS: readonly PlanSection["kind"][] = ["parallel", "across", ""];

/** How full a section is: "alone" where nobody knows its places. */
export type Fullness = "room" | "full" | "over" | "alone" | "unseen";

/** How the vehicles of a section changed; "surely" where the intervals of both surveys do not meet. */
export type Trend = "more" | "fewer" | "surely-more" | "surely-fewer" | "same" | "unseen";

/** Count of a section, by a stored survey or by the flight so far. */
export type Counted = Pick<SectionLook, "parked" | "least" | "most" | "room" | "capacity" | "hidden_share" | "seen_share">;

/** Vehicles and places, of one section or of several. */
export type Parked = Pick<SectionLook, "parked" | "capacity">;

export function trend({ before, after, is_changed: isSure }: SectionChange): Trend {
  if (before === null || after === null) return "unseen";
  if (before.parked === after.parked) return "same";
  const found = after.parked > before.parked ? "more" : "fewer";
  return isSure === true ? `surely-${found}` : found;
}

/** "3, then 6 of 8 parked". */
export function changeWords({ before, after, capacity }: SectionChange): string {
  if (before === null || after === null) return say("section-unseen");
  return say("section-then", { before: before.parked, after: parkedWords({ parked: after.parked, capacity }) });
}

/** All sections that were seen, together; null without one, and without places where one has none. */
export function parkedInAll(seen: readonly (Parked | null)[]): Parked | null {
  const found = seen.filter((each) => each !== null);
  if (found.length === 0) return null;
  const places = found.map(({ capacity }) => capacity).filter((each) => each !== null);
  const sum = (all: readonly number[]): number => all.reduce((total, each) => total + each, 0);
  return { parked: sum(found.map(({ parked }) => parked)), capacity: places.length < found.length ? null : sum(places) };
}

/** Room in the gaps of all sections that were seen; null where that of one is not known. */
export function roomInAll(seen: readonly (Counted | null)[]): number | null {
  const found = seen.filter((each) => each !== null).map(({ room }) => room);
  const known = found.filter((each) => each !== null);
  return found.length === 0 || known.length < found.length ? null : known.reduce((total, each) => total + each, 0);
}

export function fullness(look: Parked | null): Fullness {
  if (look === null) return "unseen";
  if (look.capacity === null) return "alone";
  return look.parked > look.capacity ? "over" : look.parked === look.capacity ? "full" : "room";
}

/** "3 of 8 parked", "12 of 10 parked, over-full", "3 vehicles", "not seen". */
export function parkedWords(look: Parked | null): string {
  const full = fullness(look);
  if (look === null) return say("section-unseen");
  if (look.capacity === null) return say("section-vehicles", { parked: look.parked });
  const words = say("section-parked", { parked: look.parked, capacity: look.capacity });
  return full === "over" ? say("section-over", { words }) : full === "full" ? say("section-full", { words }) : words;
}

/** The true number, 9 times in 10. */
export function intervalWords({ least, most }: SectionLook): string {
  return say("section-interval", { least, most });
}

export function roomWords({ room }: { room: number | null }): string {
  return room === null ? "" : say("section-room", { room });
}

export function capacityWords({ capacity, is_capacity_given }: Pick<PlanSection, "capacity" | "is_capacity_given">): string {
  if (capacity === null) return say("section-no-capacity");
  return say(is_capacity_given ? "section-capacity-given" : "section-capacity-by-length", { capacity });
}

export function sectionKindWords(kind: PlanSection["kind"]): string {
  return say(kind === "" ? "section-kind-any" : `section-kind-${kind}`);
}

/** What a survey did not see of a section, and how its vehicles were counted; "" where all is as usual. */
export function doubtWords(look: SectionLook): string {
  const [hidden, unseen] = [look.hidden_share, 1 - look.seen_share].map((share) => number(100 * share));
  return [
    hidden === "0" ? "" : say("section-hidden", { hidden: hidden ?? "" }),
    unseen === "0" ? "" : say("section-not-seen", { unseen: unseen ?? "" }),
    look.source === "stalls" ? say("section-by-stalls") : "",
  ]
    .filter((each) => each !== "")
    .join(" ");
}

/** All that is said of one section, line by line. */
export function sectionLines({ look, ...section }: ListedSection): string[] {
  const seen = look === null ? [] : [intervalWords(look), roomWords(look), doubtWords(look)];
  return [...seen, capacityWords(section), sectionKindWords(section.kind), section.note].filter((each) => each !== "");
}
