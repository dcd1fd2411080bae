import { answer, list, refusal } from "./api.ts";
import type { Operation, PlanSection, PlanStall, PlanZone, SaidOfSection } from "../src/plan/values.ts";

interface Edit {
  edit: string;
  who: string;
  since: string;
}

/** The drone's store of one lot as a page sees it through fetch: it removes, moves and confirms. */
export class PlanStore {
  stalls = new Map<string, PlanStall>();
  zones: PlanZone[] = [];
  sections: PlanSection[] = [];
  revision = 0;
  open: Edit | null = null;
  /** What was asked, in its order. */
  readonly asked: [path: string, body: Record<string, unknown>][] = [];
  readonly steps: Operation[] = [];
  /** The next answers in place of the store's own: "lost" after it was done, "down" before, or a refusal. */
  readonly next: ("lost" | "down" | Response)[] = [];
  private readonly before: Map<string, PlanStall>[] = [];
  private readonly after: Map<string, PlanStall>[] = [];
  private count = 0;

  constructor(labels: readonly string[]) {
    labels.forEach((label, index) => {
      const shape = { north: 0, east: 2.5 * index, angle: 0, width: 2.5, length: 5 };
      this.stalls.set(label, { id: label, label, ...shape, kind: "", is_confirmed: false, is_named: false });
    });
  }

  /** Another person takes the plan over. */
  take(who: string): void {
    this.count += 1;
    this.open = { edit: `edit-${this.count}`, who, since: "2026-05-04T10:30:00Z" };
  }

  change(operation: Operation): void {
    this.steps.push(operation);
    this.before.push(new Map(this.stalls));
    this.after.length = 0;
    const ids = "all" in operation ? [...this.stalls.keys()] : "stalls" in operation ? operation.stalls : this.idsOf("row" in operation ? [operation.row] : operation.do === "swap" ? operation.rows : []);
    for (const id of ids) this.changeOne(id, operation);
    if (operation.do === "draw_zone") this.zones = [...this.zones, { id: `zone-${this.revision}`, name: operation.name, kind: operation.kind, outline: operation.outline.map(([north, east]) => [north, east]) }];
    if (operation.do === "erase_zone") this.zones = this.zones.filter(({ id }) => id !== operation.zone);
    if (operation.do === "draw_section") this.sections = [...this.sections, sectionOf(`section-${this.revision}`, operation)];
    if (operation.do === "change_section") this.sections = this.sections.map((each) => (each.id === operation.section ? { ...each, ...sectionOf(each.id, operation) } : each));
    if (operation.do === "remove_section") this.sections = this.sections.filter(({ id }) => id !== operation.section);
    this.revision += 1;
  }

  readonly fetch = async (address: string | URL | Request, options?: RequestInit): Promise<Response> => {
    await Promise.resolve();
    const path = (address as string).replace(/^api\/v1\/lots\/lot\/?/, "");
    if (options?.method !== "POST") return this.read(path);
    const body = JSON.parse(options.body as string) as Record<string, unknown>;
    this.asked.push([path, body]);
    const next = this.next.shift();
    if (next === "down") throw new TypeError("no link");
    if (next !== undefined && next !== "lost") return next;
    const answer = this.act(path, body);
    if (next === "lost") throw new TypeError("no link");
    return answer;
  };

  private read(path: string): Response {
    if (this.next[0] === "down") {
      this.next.shift();
      throw new TypeError("no link");
    }
    const edit = this.open && { who: this.open.who, since: this.open.since };
    return answer(path, {
      "": { id: "lot", name: "Lot 1", datum: [48, 11] },
      surveys: list(),
      comparison: { survey: null, found: [], missed: [] },
      plan: { lot: "lot", revision: this.revision, edit, whole: true, stalls: [...this.stalls.values()], gone: [], zones: [], named_zones: this.zones, sections: this.sections },
    });
  }

  private act(path: string, body: Record<string, unknown>): Response {
    if (path === "edit") return this.begin(body);
    if (this.open?.edit !== body.edit) {
      const who = this.open ? { who: this.open.who, since: this.open.since } : {};
      return refusal(409, "it was closed", { field: "edit", ...who });
    }
    if (path === "edit/close") {
      this.open = null;
      return Response.json({ seq: 1, layout: this.steps.length > 0 ? 2 : null });
    }
    if (path === "plan") this.change(body.operation as Operation);
    else if (!this.step(path)) return refusal(409, "nothing of it is left to undo", { field: "edit" });
    return Response.json(this.done());
  }

  private begin({ who, take_over }: Record<string, unknown>): Response {
    if (this.open && this.open.who !== who && take_over !== true) {
      return refusal(409, "another edits", { who: this.open.who, since: this.open.since });
    }
    if (this.open?.who !== who) this.take(who as string);
    return Response.json({ ...this.open, undo: this.before.length, redo: this.after.length });
  }

  private step(path: string): boolean {
    const [from, to] = path === "plan/undo" ? [this.before, this.after] : [this.after, this.before];
    const stalls = from.pop();
    if (!stalls) return false;
    to.push(this.stalls);
    this.stalls = stalls;
    this.revision += 1;
    return true;
  }

  private idsOf(rows: readonly string[]): string[] {
    return [...this.stalls.values()].filter(({ label }) => rows.includes(label.split(" ")[0] ?? "")).map(({ id }) => id);
  }

  private changeOne(id: string, operation: Operation): void {
    const stall = this.stalls.get(id);
    if (!stall) return;
    if (operation.do === "remove") this.stalls.delete(id);
    if (operation.do === "confirm") this.stalls.set(id, { ...stall, is_confirmed: true, is_named: true });
    const [row = "", number = ""] = stall.label.split(" ");
    const name = (label: string): unknown => this.stalls.set(id, { ...stall, label, is_named: true });
    if (operation.do === "rename") name(`${operation.to} ${number}`);
    if (operation.do === "shift") name(`${row} ${Number(number) + operation.by}`);
    if (operation.do === "swap") name(`${operation.rows[operation.rows[0] === row ? 1 : 0]} ${number}`);
    if (operation.do === "move") this.stalls.set(id, { ...stall, north: stall.north + operation.north, east: stall.east + operation.east });
  }

  private done(): object {
    const every = new Set([...this.stalls.keys(), ...this.before.flatMap((stalls) => [...stalls.keys()])]);
    const gone = [...every].filter((id) => !this.stalls.has(id));
    const left = { undo: this.before.length, redo: this.after.length };
    return { edit: this.open?.edit, revision: this.revision, stalls: [...this.stalls.values()], gone, zones: [], named_zones: this.zones, sections: this.sections, ...left };
  }
}

/** A section as the store answers it; one place every 5.5 m of 44 m where nobody says how many. */
function sectionOf(id: string, { name, kind, capacity, note }: SaidOfSection): PlanSection {
  return { id, name, kind, note, outline: [[0, 0], [0, 44], [-2.5, 44]], length_m: 44, capacity: capacity ?? 8, is_capacity_given: capacity !== null };
}
