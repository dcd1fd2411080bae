import { control } from "./actions.ts";
import * as format from "./format.ts";
import { say } from "./say.ts";
import { linkOf, option, type View } from "./view.ts";

/** Words about the survey on the map, before the next flight goes on with it; null where there is nothing to choose. */
export function earlierSurvey(view: View): string | null {
  const heartbeat = view.heartbeat;
  if (heartbeat?.State !== "Idle" || linkOf(view) !== "live" || control(view) !== "mine" || !option(view, "New Survey").Possible) return null;
  const stalls = heartbeat.Free + heartbeat.Taken + heartbeat.Unknown;
  const area = heartbeat["Lot Area"];
  return area ? say("earlier-on", { stalls, area: format.area(area, view.units) }) : say("earlier", { stalls });
}
