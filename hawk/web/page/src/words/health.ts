import type { HealthItem } from "../protocol.ts";

const PARTS: Record<string, string> = {
  link: "Autopilot link",
  position: "Position",
  ground: "On the ground or not",
  home: "Home",
  rangefinder: "Rangefinder",
  "remote control": "Remote control",
  "remote id": "Remote ID",
  vision: "Finding stalls",
  mapper: "Map",
  planner: "Route",
  camera: "Camera",
  recording: "Recording",
  requests: "Requests to the autopilot",
  tasks: "Parts of the program",
  loop: "Computer",
};

export function partName(item: HealthItem): string {
  return PARTS[item.Name] ?? item.Name;
}

export function healthSummary(items: readonly HealthItem[]): string {
  const bad = items.filter((item) => !item.Healthy);
  if (items.length === 0) return "–";
  if (bad.length === 0) return `all ${items.length} working`;
  return `${bad.length} of ${items.length} in trouble`;
}
