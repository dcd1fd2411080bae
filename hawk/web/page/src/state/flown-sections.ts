import type { SectionUpdate, SectionsUpdate } from "../protocol.ts";
import type { Counted } from "../words/section.ts";

/** A section of the lot that is flown over, with its count so far; null while next to nothing of it was seen. */
export interface FlownSection {
  id: string;
  name: string;
  /** East and north on the map of the flight, metres. */
  ring: [number, number][];
  look: Counted | null;
}

export const NO_SECTIONS: readonly FlownSection[] = [];

/** The sections after what a heartbeat says of them, by their names; the same array where it says nothing. */
export function afterUpdate(before: readonly FlownSection[], update: SectionsUpdate | null): readonly FlownSection[] {
  if (update === null) return before;
  const left = new Map(before.map((each) => [each.id, each]));
  for (const id of update.Removed) left.delete(id);
  for (const each of update.Changed) left.set(each.Id, flown(each));
  return [...left.values()].sort((a, b) => a.name.localeCompare(b.name));
}

function flown(section: SectionUpdate): FlownSection {
  const { Parked: parked, Least: least, Most: most, Room: room, Capacity: capacity } = section;
  const isSeen = parked !== null && least !== null && most !== null;
  return {
    id: section.Id,
    name: section.Name,
    ring: section.Outline.map(({ North, East }) => [East, North]),
    look: isSeen ? { parked, least, most, room, capacity, seen_share: section["Seen Share"] ?? 0, hidden_share: section["Hidden Share"] ?? 0 } : null,
  };
}
