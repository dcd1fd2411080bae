import type { HealthItem } from "../protocol.ts";
import { say } from "./say.ts";

const PARTS = {
  link: "part-link",
  position: "part-position",
  ground: "part-ground",
  home: "part-home",
  rangefinder: "part-rangefinder",
  "remote control": "part-remote-control",
  "remote id": "part-remote-id",
  witness: "part-witness",
  vision: "part-vision",
  mapper: "part-mapper",
  planner: "part-planner",
  camera: "part-camera",
  recording: "part-recording",
  requests: "part-requests",
  tasks: "part-tasks",
  loop: "part-loop",
} as const;

export function partName(item: HealthItem): string {
  return Object.hasOwn(PARTS, item.Name) ? say(PARTS[item.Name as keyof typeof PARTS]) : item.Name;
}

export function healthSummary(items: readonly HealthItem[]): string {
  const bad = items.filter((item) => !item.Healthy);
  if (items.length === 0) return "–";
  if (bad.length === 0) return say("parts-working", { parts: items.length });
  return say("parts-in-trouble", { bad: bad.length, parts: items.length });
}
