import { type Action, type ActionName, control } from "./actions.ts";
import type { View } from "./view.ts";

/** The step of a flight that comes next for the one in control; null while the drone is busy with one. */
export function nextStep(view: View, actions: Action[]): ActionName | null {
  if (control(view) !== "mine") return null;
  const wanted = wantedIn(view);
  return actions.find((action) => action.name === wanted && action.kind === "possible")?.name ?? null;
}

/** Steps of this flight that are behind the drone: they need no room. */
export function isDone(view: View, name: ActionName): boolean {
  const heartbeat = view.heartbeat;
  if (heartbeat?.Armed !== true) return false;
  if (name === "arm") return true;
  return name === "takeoff" && heartbeat.Landed === "IN_AIR" && heartbeat.State !== "Takeoff";
}

function wantedIn(view: View): ActionName | null {
  switch (view.heartbeat?.State) {
    case "Idle":
    case "Configure":
      return "arm";
    case "Arm":
      return "takeoff";
    case "Hover":
      return view.heartbeat["Explore Done"] ? "home" : "explore";
    case "Manual":
      return "resume";
    default:
      return null;
  }
}
