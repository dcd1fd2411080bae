import type { Stall } from "../state/map-store.ts";
import * as format from "./format.ts";

/** What is known of one stall: how sure, how often and when it was seen. */
export function stallDetail(stall: Stall, lastSeenAt: number | null): string {
  const taken = stall.taken === null ? null : Math.round(stall.taken * 100);
  const sure = taken === null ? "" : stall.state === "unknown" ? unsure(taken) : "";
  const times = stall.seen === null ? "" : stall.seen === 0 ? "Not seen itself, found from its row" : `Seen ${format.count(stall.seen, "time", "times")}`;
  const last = lastSeenAt === null || stall.seen === 0 ? "" : `last at ${format.clock(lastSeenAt)}`;
  const seen = [times, last].filter((part) => part !== "").join(", ");
  return [sure, seen === "" ? "" : `${seen}.`].filter((part) => part !== "").join(" ");
}

function unsure(taken: number): string {
  if (taken === 50) return "As likely free as taken.";
  return taken < 50 ? `Probably free (${100 - taken} %).` : `Probably taken (${taken} %).`;
}
