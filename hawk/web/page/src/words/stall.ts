import type { Stall } from "../state/map-store.ts";
import * as format from "./format.ts";

/** Seen in this number of pictures or more, a stall is known well. */
const OFTEN = 10;

/** What is known of one stall: how sure, when it was seen, and that it was seen seldom. */
export function stallDetail(stall: Stall, lastSeenAt: number | null): string {
  const taken = stall.taken === null ? null : Math.round(stall.taken * 100);
  const sure = taken === null ? "" : stall.state === "unknown" ? unsure(taken) : "";
  const times = seenWords(stall.seen);
  const last = lastSeenAt === null || stall.seen === 0 ? "" : `${times === "" ? "Last seen" : "last"} at ${format.clock(lastSeenAt)}`;
  const seen = [times, last].filter((part) => part !== "").join(", ");
  return [sure, seen === "" ? "" : `${seen}.`].filter((part) => part !== "").join(" ");
}

/** The number of pictures, for a stall that was seen seldom. */
function seenWords(pictures: number | null): string {
  if (pictures === null || pictures >= OFTEN) return "";
  if (pictures === 0) return "Not seen itself, found from its row";
  return `Seen in ${format.count(pictures, "picture", "pictures")} only`;
}

function unsure(taken: number): string {
  if (taken === 50) return "As likely free as taken.";
  return taken < 50 ? `Probably free (${100 - taken} %).` : `Probably taken (${taken} %).`;
}
