import type { Done, PlanChange } from "../link/plan.ts";
import { type Operation, type PlanSection, type PlanStall, type PlanZone, rowsOf, usualSize } from "./values.ts";

export interface Summary {
  /** Width and length that most stalls have about, metres. */
  usual: { width: number; length: number };
  /** Names of the rows. */
  rows: readonly string[];
  confirmed: number;
  /** Labels that no person gave or confirmed. */
  guessed: number;
}

/** A plan as a person sees it: as the store has it, with what was asked of the store and is not answered yet. */
export class ShownPlan {
  /** By id. */
  readonly stalls = new Map<string, PlanStall>();
  /** Areas without stalls. */
  zones: readonly PlanZone[] = [];
  /** Zones whose stalls are counted together. */
  named: readonly PlanZone[] = [];
  /** Strips and areas whose vehicles are counted. */
  sections: readonly PlanSection[] = [];
  revision = 0;
  private readonly known = new Map<string, PlanStall>();
  private sum: Summary | null = null;

  /** What is said of all its stalls; found once for each change. */
  get summary(): Summary {
    this.sum ??= summaryOf([...this.stalls.values()]);
    return this.sum;
  }

  get(id: string): PlanStall | undefined {
    return this.stalls.get(id);
  }

  /** Takes a plan, or what changed of it. Returns the ids of what may look otherwise. */
  take(change: PlanChange, waiting: readonly Operation[]): Set<string> {
    const gone = change.whole ? [...this.known.keys()] : change.gone;
    return this.put(gone, change, waiting);
  }

  /** Takes what the store did; `waiting` is what it was asked for besides. */
  done(answer: Done, waiting: readonly Operation[], asked: Operation | null): Set<string> {
    const gone = answer.whole === true ? [...this.known.keys()] : answer.gone;
    const changed = this.put(gone, answer, waiting);
    if (asked) for (const id of idsOf(asked, this.known)) if (!changed.has(id)) this.show(id, waiting, changed);
    return changed;
  }

  /** Shows what was asked for before the store has answered. */
  foresee(waiting: readonly Operation[], asked: Operation): Set<string> {
    const changed = new Set<string>();
    for (const id of idsOf(asked, this.known)) this.show(id, waiting, changed);
    return changed;
  }

  private put(gone: Iterable<string>, { revision, stalls, zones, named_zones, sections }: PlanChange | Done, waiting: readonly Operation[]): Set<string> {
    const changed = new Set<string>();
    this.revision = revision;
    this.zones = zones;
    this.named = named_zones;
    this.sections = sections;
    for (const id of gone) this.known.delete(id);
    for (const stall of stalls) this.known.set(stall.id, stall);
    for (const id of gone) this.show(id, waiting, changed);
    for (const { id } of stalls) this.show(id, waiting, changed);
    return changed;
  }

  private show(id: string, waiting: readonly Operation[], changed: Set<string>): void {
    let shown = this.known.get(id) ?? null;
    for (const each of waiting) if (shown) shown = foreseen(each, shown);
    changed.add(id);
    this.sum = null;
    if (shown) this.stalls.set(id, shown);
    else this.stalls.delete(id);
  }
}

function summaryOf(stalls: readonly PlanStall[]): Summary {
  const count = (is: (stall: PlanStall) => boolean): number => stalls.filter(is).length;
  return { usual: usualSize(stalls), rows: rowsOf(stalls), confirmed: count((each) => each.is_confirmed), guessed: count((each) => !each.is_named) };
}

/** Ids that an operation names. */
function idsOf(asked: Operation, known: ReadonlyMap<string, PlanStall>): Iterable<string> {
  if ("all" in asked) return known.keys();
  return "stalls" in asked ? asked.stalls : [];
}

/** A stall after an operation, as far as a page knows that; null for a removed one. What it does not know the store answers. */
export function foreseen(asked: Operation, stall: PlanStall): PlanStall | null {
  const isMeant = "all" in asked || ("stalls" in asked && asked.stalls.includes(stall.id));
  if (!isMeant) return stall;
  switch (asked.do) {
    case "remove":
      return null;
    case "confirm":
      return { ...stall, is_confirmed: true, is_named: true };
    case "move":
      return { ...stall, north: stall.north + asked.north, east: stall.east + asked.east };
    case "set_kind":
      return { ...stall, kind: asked.kind };
    default:
      return stall;
  }
}
