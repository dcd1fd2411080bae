import * as format from "./format.ts";
import { say } from "./say.ts";
import { OLD_S } from "./view.ts";

/** Age of the picture in a few words; null before the first. */
export function pictureWords(age: number | null, simulated: boolean): string {
  if (age === null) return say("no-picture-yet");
  const words = { age: format.age(age) };
  if (age > OLD_S) return simulated ? say("simulation-age-old", words) : say("age", words);
  return simulated ? say("simulation-age", words) : say("live-age", words);
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
