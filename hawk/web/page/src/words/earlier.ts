import { control } from "./actions.ts";
import * as format from "./format.ts";
import { linkOf, option, type View } from "./view.ts";

/** Words about the survey on the map, before the next flight goes on with it; null where there is nothing to choose. */
export function earlierSurvey(view: View): string | null {
  const heartbeat = view.heartbeat;
  if (heartbeat?.State !== "Idle" || linkOf(view) !== "live" || control(view) !== "mine" || !option(view, "New Survey").Possible) return null;
  const stalls = format.count(heartbeat.Free + heartbeat.Taken + heartbeat.Unknown, "stall", "stalls");
  const area = heartbeat["Lot Area"];
  return `${stalls}${area ? ` on ${format.area(area, view.units)}` : ""}. The next flight goes on with it.`;
}
