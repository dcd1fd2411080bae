import type { PlanSection, PlanStall, PlanZone } from "../api.ts";
import type { Rectangle } from "../map/geometry.ts";

export type { PlanSection, PlanStall, PlanZone };

/** North, east: metres in the lot's frame. */
export type Spot = readonly [number, number];

/** OpenStreetMap's values of parking_space, in the order of a menu. */
export const KINDS = ["", "disabled", "charging", "parent", "delivery", "private", "motorcycle", "staff", "bus", "hgv", "taxi"] as const satisfies readonly PlanStall["kind"][];
export type Kind = PlanStall["kind"];

/** Marks on stalls of a kind. */
export const MARKS: Record<Kind, string> = {
  "": "",
  disabled: "D",
  charging: "E",
  parent: "P",
  delivery: "L",
  private: "R",
  motorcycle: "M",
  staff: "S",
  bus: "B",
  hgv: "H",
  taxi: "T",
};

/** A row that is drawn: its front from end to end, and a place on the far side. */
export interface RowSketch {
  front: readonly [Spot, Spot];
  far: Spot;
  count: number;
  /** Radians from square to the front towards its second end. */
  lean: number;
  double: boolean;
}

/** What the drone's store is asked to do with the plan: docs/how-to/correct-the-plan.md. */
export type Operation =
  | ({ do: "remove" | "confirm" } & Chosen)
  | ({ do: "move"; north: number; east: number } & Chosen)
  | ({ do: "turn"; by: number; about: "middle" | "each" } & Chosen)
  | ({ do: "widen"; width?: number; length?: number } & Chosen)
  | ({ do: "set_kind"; kind: Kind } & Chosen)
  | { do: "renumber"; stalls: string[]; letter: string; first: number }
  | ({ do: "rename"; to: string } & (Chosen | { row: string }))
  | ({ do: "reverse" } & (Chosen | { row: string }))
  | ({ do: "shift"; by: number } & (Chosen | { row: string }))
  | { do: "swap"; rows: [string, string] }
  | { do: "split"; stall: string; parts: number }
  | { do: "add_stall"; north: number; east: number; angle: number; width: number; length: number; kind: Kind }
  | { do: "add_row"; front: readonly [Spot, Spot]; far: Spot; count: number; lean?: number; parallel?: boolean; double?: boolean; kind: Kind }
  | { do: "forbid"; outline: readonly Spot[]; name: string; private?: boolean }
  | { do: "draw_zone"; outline: readonly Spot[]; name: string; kind: Kind }
  | { do: "allow" | "erase_zone"; zone: string }
  | ({ do: "draw_section" } & SaidOfSection & ({ line: readonly Spot[]; side: Side; width: number } | { outline: readonly Spot[] }))
  | ({ do: "change_section"; section: string } & SaidOfSection)
  | { do: "remove_section"; section: string };

export type Side = "left" | "right";

/** What a person says of a section; `capacity`: null where it follows from the length. */
export interface SaidOfSection {
  name: string;
  kind: PlanSection["kind"];
  capacity: number | null;
  note: string;
}

/** Stalls by their ids, or all of them. */
export type Chosen = { stalls: string[] } | { all: true };

/** Usual stall of a plan that has none, metres. */
export const USUAL = { width: 2.5, length: 5 };

/** Width and length that most stalls of a plan have about, metres. */
export function usualSize(stalls: readonly Rectangle[]): { width: number; length: number } {
  if (stalls.length === 0) return USUAL;
  const median = (values: number[]): number => values.sort((a, b) => a - b)[values.length >> 1] ?? 0;
  return { width: median(stalls.map(({ width }) => width)), length: median(stalls.map(({ length }) => length)) };
}

/** A label's row and number: "B 12"; null for a label of another form. */
export function partsOf(label: string): { row: string; number: number } | null {
  const found = /^(.+) (\d+)$/.exec(label);
  return found ? { row: found[1] ?? "", number: Number(found[2]) } : null;
}

/** Names of the rows of a plan: A to Z, AA and so on. */
export function rowsOf(stalls: Iterable<PlanStall>): string[] {
  const found = new Set<string>();
  for (const { label } of stalls) {
    const parts = partsOf(label);
    if (parts) found.add(parts.row);
  }
  return [...found].sort((one, other) => one.length - other.length || (one < other ? -1 : 1));
}

/** Stalls in the order of their labels: rows by letter, then numbers. */
export function inOrder(stalls: readonly PlanStall[]): PlanStall[] {
  const keyed = stalls.map((stall) => {
    const parts = partsOf(stall.label);
    return { stall, row: parts ? parts.row.padStart(3) : `~${stall.label}`, number: parts?.number ?? 0 };
  });
  keyed.sort((one, other) => (one.row < other.row ? -1 : one.row > other.row ? 1 : one.number - other.number));
  return keyed.map(({ stall }) => stall);
}
