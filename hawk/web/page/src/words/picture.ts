import * as format from "./format.ts";
import { OLD_S } from "./view.ts";

/** Age of the picture in a few words; null before the first. */
export function pictureWords(age: number | null, simulated: boolean): string {
  if (age === null) return "No picture yet";
  if (age > OLD_S) return simulated ? `Simulation, ${format.age(age)} old` : `${format.age(age)} old`;
  return simulated ? `Simulation, ${format.age(age)}` : `Live, ${format.age(age)}`;
}

/**
 * File name of a saved picture by the time of its light (UTC) and the drone's place, as
 * "hawk-2026-11-24T15-48-01Z-43.26012N-79.92034W.jpg".
 */
export function snapshotName(
  milliseconds: number,
  place: { latitude: number | null; longitude: number | null },
  simulated: boolean,
): string {
  const time = new Date(milliseconds).toISOString().slice(0, 19).replaceAll(":", "-");
  const parts = [simulated ? "hawk-simulation" : "hawk", `${time}Z`];
  if (place.latitude !== null && place.longitude !== null) {
    parts.push(degrees(place.latitude, "N", "S"), degrees(place.longitude, "E", "W"));
  }
  return `${parts.join("-")}.jpg`;
}

function degrees(value: number, plus: string, minus: string): string {
  return `${Math.abs(value).toFixed(5)}${value < 0 ? minus : plus}`;
}
