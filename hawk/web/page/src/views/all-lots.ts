import type { ListedLot } from "../api.ts";
import type { LocalPlane } from "../fence/plane.ts";
import type { LotMark } from "../map/lot-groups.ts";
import { language } from "../words/say.ts";

/** Orders of the table: by name, the fullest first, the one that was seen longest ago first, the one that is due first, by drone. */
export type LotOrder = "name" | "free" | "seen" | "due" | "drone";

/** Share of the stalls with a known state that the newest survey found taken; null where it knows none. */
export function takenShare({ last_survey: last }: Pick<ListedLot, "last_survey">): number | null {
  const known = last === null ? 0 : last.free + last.taken;
  return last === null || known === 0 ? null : last.taken / known;
}

/** Letters without their accents and in lower case: "etoile" finds "Étoile". */
function plain(text: string): string {
  return text.normalize("NFD").replaceAll(/\p{M}/gu, "").toLowerCase();
}

/** The lots whose names, or drones, hold all words that are wanted, in an order; those that nobody saw are the first by age. */
export function lotsFound(lots: readonly ListedLot[], wanted: string, order: LotOrder): ListedLot[] {
  const words = plain(wanted).split(/\s+/).filter((word) => word !== "");
  const found = lots.filter((lot) => {
    const here = plain(`${lot.name} ${droneOf(lot)}`);
    return words.every((word) => here.includes(word));
  });
  const { compare } = new Intl.Collator(language(), { numeric: true });
  const seen = ({ last_survey: last }: ListedLot): number => (last === null ? -Infinity : Date.parse(last.ended));
  const due = (lot: ListedLot): number => (lot.due === null ? Infinity : Date.parse(lot.due));
  const full = (lot: ListedLot): number => takenShare(lot) ?? -1;
  const first = { name: () => 0, free: (one: ListedLot, other: ListedLot) => full(other) - full(one), seen: (one: ListedLot, other: ListedLot) => seen(one) - seen(other), due: (one: ListedLot, other: ListedLot) => ordered(due(one), due(other)), drone: (one: ListedLot, other: ListedLot) => compare(droneOf(one), droneOf(other)) }[order];
  return found.sort((one, other) => first(one, other) || compare(one.name, other.name));
}

/** The drone or desk that sent the newest survey; "" for one that was stored here. */
export function droneOf({ last_survey: last }: Pick<ListedLot, "last_survey">): string {
  return last?.drone ?? "";
}

/** Compares numbers that may both be without an end. */
function ordered(one: number, other: number): number {
  return one === other ? 0 : one - other;
}

/** Marks of the lots whose place a survey says, metres about the plane's origin. */
export function marksOf(lots: readonly ListedLot[], plane: LocalPlane, words: (lot: ListedLot) => string): LotMark[] {
  return lots.flatMap((lot): LotMark[] => {
    const [Latitude, Longitude] = lot.last_survey?.datum ?? [];
    if (Latitude === undefined || Longitude === undefined) return [];
    const { East, North } = plane.toMap({ Latitude, Longitude });
    return [{ id: lot.id, name: lot.name, words: words(lot), taken: takenShare(lot), place: [East, North] }];
  });
}
