import type { Film, SurveyGround, SurveyMap } from "../api.ts";
import { LocalPlane } from "../fence/plane.ts";
import { rowMarks } from "../map/draw-labels.ts";
import { EMPTY_SCENE, type Scene } from "../map/flight-scene.ts";
import { type Coordinate, type Extent, extentOf, type Rectangle } from "../map/geometry.ts";
import type { Point } from "../protocol.ts";
import type { Stall } from "../state/map-store.ts";
import { type Feature, onMap, planeOf, stallsOf, type SurveyOnMap } from "../views/survey-source.ts";
import { type Instant, seenBy, trailBy } from "./film.ts";

/** A stall in another survey or plan is the same one where their middles are no farther apart, metres. */
const SAME_M = 1.6;
const MARGIN_M = 8;

/** A stall that is to be found, with its label. */
export type Expected = Rectangle & { label: string };

/** What a film's flight made in the store: the survey's stalls, and its picture of the ground. */
export interface Outcome {
  survey: string;
  map: SurveyMap;
  ground: SurveyGround | null;
}

/** The stalls that a flight was to find or has found, in the frame of its film; those of the plan where nothing was stored. */
export function expected(film: Film, outcome: Outcome | null): Expected[] {
  const { datum, plan } = film;
  const plane = outcome && planeOf(outcome.map, outcome.ground);
  if (!plane || !datum) return plan;
  const found = onMap(outcome.survey, outcome.map, outcome.ground, plane);
  const { north = 0, east = 0, turn = 0 } = outcome.ground?.place ?? {};
  const shift = outcome.ground ? { North: 0, East: 0 } : new LocalPlane(degrees(datum)).toMap(found.plane.origin);
  const [sine, cosine] = [Math.sin(turn), Math.cos(turn)];
  return found.stalls.map((stall) => {
    const [up, right] = [stall.north - north, stall.east - east];
    return { ...stall, north: up * cosine + right * sine + shift.North, east: right * cosine - up * sine + shift.East, angle: stall.angle - turn };
  });
}

function degrees([Latitude, Longitude]: readonly [number, number]): { Latitude: number; Longitude: number } {
  return { Latitude, Longitude };
}

/** The stalls of a film at a moment, as the map shows them, and those that it has still to find. */
export function filmOnMap(film: Film, features: readonly Feature[], all: readonly Expected[], outcome: Outcome | null, seen: readonly (readonly Point[])[]): { shown: SurveyOnMap; unseen: Expected[] } | null {
  if (film.datum === null) return null;
  const plane = new LocalPlane(degrees(film.datum));
  const place = { north: 0, east: 0, turn: 0 };
  const ground = outcome?.ground ? { ...outcome.ground, datum: film.datum, place } : null;
  const found = features.filter(({ properties }) => properties.state !== "suggested");
  const stalls = stallsOf(found, plane).filter((stall) => isSeen(stall, seen));
  const left = new Set(all);
  const labelled = stalls.map((stall, index): Stall => {
    const same = nearest(stall, left);
    if (same) left.delete(same);
    return { ...stall, id: index, label: stall.label || (same?.label ?? "") };
  });
  const shown = { survey: outcome?.survey ?? "", plane, stalls: labelled, ids: labelled.map(({ id }) => String(id)), rows: rowMarks(all), ground };
  return { shown, unseen: [...left] };
}

/** A stall of the plan that the camera has not passed is unclear, but nobody looked: it is one to be found. */
function isSeen(stall: Stall, seen: readonly (readonly Point[])[]): boolean {
  return stall.state !== "unknown" || seen.length === 0 || seen.some((ring) => holds(ring, stall));
}

function holds(ring: readonly Point[], { north, east }: Rectangle): boolean {
  let inside = false;
  ring.forEach((one, k) => {
    const other = ring[(k + 1) % ring.length] ?? one;
    if (one.North > north !== other.North > north && east < one.East + ((north - one.North) * (other.East - one.East)) / (other.North - one.North)) inside = !inside;
  });
  return inside;
}

function nearest(stall: Rectangle, all: Iterable<Expected>): Expected | null {
  let [found, least]: [Expected | null, number] = [null, SAME_M];
  for (const each of all) {
    const away = Math.hypot(each.north - stall.north, each.east - stall.east);
    if (away <= least) [found, least] = [each, away];
  }
  return found;
}

/** What lies over the ground at a moment. */
export function sceneAt(film: Film, at: number, { drone, home, fence, zones, footprint }: Instant, unseen: readonly Expected[]): Scene {
  const seen = film.footprints.length > 0 ? seenBy(film, at) : null;
  return { ...EMPTY_SCENE, drone, home, fence, zones, footprint, trail: trailBy(film, at), seen, unseen };
}

/** All that a film shows of the ground; null without a place. */
export function extentOfFilm(film: Film, all: readonly Expected[]): Extent | null {
  const track = film.track.map(([, north, east]): Coordinate => [east ?? 0, north ?? 0]);
  const found = extentOf([...track, ...all.map(({ east, north }): Coordinate => [east, north])]);
  return found && [found[0] - MARGIN_M, found[1] - MARGIN_M, found[2] + MARGIN_M, found[3] + MARGIN_M];
}
