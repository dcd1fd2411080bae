import type { ListedLot, LotPlaces, Survey } from "../api.ts";
import { API, read } from "./api.ts";

/** A lot as the bar, the map and the table of all lots show it. `place`: latitude and longitude. */
export interface LotPlace extends Pick<ListedLot, "id" | "name" | "time_zone" | "stalls" | "survey_count" | "due"> {
  place: readonly [number, number];
  last_survey: Pick<Survey, "id" | "ended" | "free" | "taken" | "unknown" | "drone"> | null;
}

/** Asks for every lot in one answer. Rejects with Refused. */
export async function readLots(): Promise<LotPlace[]> {
  return lotsOf(await read<LotPlaces>(`${API}/lots/places`));
}

/** The lots of an answer that has a list for each value. */
export function lotsOf(all: LotPlaces): LotPlace[] {
  const at = <T>(values: readonly T[], k: number): T => values[k] as T; // the lists are of one length
  return all.ids.map((id, k): LotPlace => {
    const [survey, ended] = [at(all.surveys, k), at(all.ended, k)];
    const counted = { free: at(all.free, k) ?? 0, taken: at(all.taken, k) ?? 0, unknown: at(all.unknown, k) ?? 0 };
    const last = survey === null || ended === null ? null : { id: survey, ended, drone: at(all.drones, k), ...counted };
    return { id, name: at(all.names, k), time_zone: at(all.time_zones, k), stalls: at(all.stalls, k), survey_count: at(all.survey_counts, k), due: at(all.due, k), place: [at(all.latitudes, k), at(all.longitudes, k)], last_survey: last };
  });
}
