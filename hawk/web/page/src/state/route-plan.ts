import type { Point } from "../protocol.ts";

/** Asks for the way to a place of the map, (north, east) in metres. */
export interface RouteRequest {
  kind: "route_request";
  id: string;
  target: [number, number];
}

/** The way that would be flown, or why there is none. */
export interface RouteAnswer {
  kind: "route";
  id: string;
  points: [number, number][];
  length_m: number | null;
  refused: string | null;
}

export type RouteState = "none" | "asking" | "known" | "refused";

/** The way to the place that is being asked about. Only the answer to the last question counts. */
export class RoutePlan {
  state: RouteState = "none";
  points: readonly Point[] = [];
  metres: number | null = null;
  reason = "";
  private asked = 0;

  ask(target: Point): RouteRequest {
    this.clear();
    this.state = "asking";
    return { kind: "route_request", id: this.id, target: [target.North, target.East] };
  }

  /** Takes an answer; whether it was to the last question. */
  take(answer: RouteAnswer): boolean {
    if (this.state !== "asking" || answer.id !== this.id) return false;
    const finite = answer.points.every((point) => point.every(Number.isFinite));
    if (answer.refused !== null || !finite || answer.points.length === 0) {
      this.state = "refused";
      this.reason = answer.refused ?? "There is no way there.";
      return true;
    }
    this.state = "known";
    this.points = routePoints(answer.points);
    this.metres = answer.length_m;
    return true;
  }

  /** Nothing is asked about any longer. */
  clear(): void {
    this.asked += 1;
    this.state = "none";
    this.points = [];
    this.metres = null;
    this.reason = "";
  }

  private get id(): string {
    return `route-${this.asked}`;
  }
}

/** (north, east) pairs as places of the map. */
export function routePoints(pairs: readonly (readonly [number, number])[]): Point[] {
  return pairs.map(([North, East]) => ({ North, East }));
}
