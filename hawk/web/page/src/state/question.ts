import type { Slid } from "../command-table.ts";
import type { Point } from "../protocol.ts";
import type { MoveKind } from "../words/move.ts";

/** What the operator is asked to confirm in the bar. */
export type Question =
  | { about: "move"; target: Point; kind?: MoveKind; /** To look at this stall again. */ stall?: number; /** Of a Compulsive Move, metres above where it was armed. */ height?: number }
  | { about: Exclude<Slid, MoveKind> };
