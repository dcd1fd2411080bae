import type { LocalPlane } from "../fence/plane.ts";
import type { LotPlace } from "../link/lot-places.ts";
import type { LotMark } from "../map/lot-groups.ts";
import type { LotOrder } from "../route/place.ts";
import { nameOrder, withWords } from "../words/find.ts";

/** Share of the stalls with a known state that the newest survey found taken; null where it knows none. */
export function takenShare({ last_survey: last }: Pick<LotPlace, "last_survey">): number | null {
  const known = last === null ? 0 : last.free + last.taken;
  return last === null || known === 0 ? null : last.taken / known;
}

/** The lots whose names, or drones, hold all words that are wanted. */
export function lotsFound(lots: readonly LotPlace[], wanted: string): readonly LotPlace[] {
  return withWords(lots, wanted, (lot) => `${lot.name} ${droneOf(lot)}`);
}

/** The first ones of lots in an order, `most` of them; those that nobody saw are the first by age. */
export function firstLots(lots: readonly LotPlace[], order: LotOrder, most: number): LotPlace[] {
  const compare = inOrder(order);
  const found: LotPlace[] = [];
  for (const lot of lots) {
    const last = found[most - 1];
    if (last !== undefined && compare(lot, last) >= 0) continue; // ten thousand names are not sorted for a hundred
    let [low, high] = [0, found.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      const other = found[middle];
      if (other !== undefined && compare(lot, other) < 0) high = middle;
      else low = middle + 1;
    }
    found.splice(low, 0, lot);
    if (found.length > most) found.pop();
  }
  return found;
}

function inOrder(order: LotOrder): (one: LotPlace, other: LotPlace) => number {
  const compare = nameOrder();
  const seen = ({ last_survey: last }: LotPlace): number => (last === null ? -Infinity : Date.parse(last.ended));
  const due = (lot: LotPlace): number => (lot.due === null ? Infinity : Date.parse(lot.due));
  const full = (lot: LotPlace): number => takenShare(lot) ?? -1;
  const first = { name: () => 0, free: (one: LotPlace, other: LotPlace) => full(other) - full(one), seen: (one: LotPlace, other: LotPlace) => seen(one) - seen(other), due: (one: LotPlace, other: LotPlace) => ordered(due(one), due(other)), drone: (one: LotPlace, other: LotPlace) => compare(droneOf(one), droneOf(other)) }[order];
  return (one, other) => first(one, other) || compare(one.name, other.name);
}

/** The drone or desk that sent the newest survey; "" for one that was stored here. */
export function droneOf({ last_survey: last }: Pick<LotPlace, "last_survey">): string {
  return last?.drone ?? "";
}

/** Compares numbers that may both be without an end. */
function ordered(one: number, other: number): number {
  return one === other ? 0 : one - other;
}

/** Marks of lots, metres about the plane's origin. */
export function marksOf(lots: readonly LotPlace[], plane: LocalPlane, words: (lot: LotPlace) => string): LotMark[] {
  return lots.map((lot): LotMark => {
    const [Latitude, Longitude] = lot.place;
    const { East, North } = plane.toMap({ Latitude, Longitude });
    return { id: lot.id, name: lot.name, words: () => words(lot), taken: takenShare(lot), place: [East, North] };
  });
}
