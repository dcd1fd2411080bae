import { isLanguage, type LanguageName } from "../words/languages.ts";
import type { Units } from "../words/units.ts";

export type Theme = "auto" | "light" | "dark" | "outdoor";

/** Auto: the first of the browser's languages that the page speaks. */
export type LanguageChoice = "auto" | LanguageName;

/** What can be left out of the map. */
export const LAYERS = ["stalls", "picture", "fence", "outline", "trail", "background"] as const;
export type Layer = (typeof LAYERS)[number];
/** Which layers are drawn. */
export type Layers = Readonly<Record<Layer, boolean>>;
export const ALL_LAYERS: Layers = { stalls: true, picture: true, fence: true, outline: true, trail: true, background: true };

export interface Preferences {
  theme: Theme;
  leftHanded: boolean;
  /** What the others call this operator; null: not asked yet, empty: none. */
  name: string | null;
  /** Tone and voice report what others do. */
  sound: boolean;
  layers: Layers;
  units: Units;
  language: LanguageChoice;
  /** The map turns with the drone's nose, which is always up. */
  droneUp: boolean;
}

type Storage = Pick<globalThis.Storage, "getItem" | "setItem">;

const KEY = "hawk-page";
export const STANDARD: Preferences = {
  theme: "auto",
  leftHanded: false,
  name: null,
  sound: true,
  layers: ALL_LAYERS,
  units: "metres",
  language: "auto",
  droneUp: false,
};

/** Reads the preferences that this browser stored; those that cannot be read have their defaults. */
export function readPreferences(storage: Storage): Preferences {
  try {
    const stored: unknown = JSON.parse(storage.getItem(KEY) ?? "{}");
    if (typeof stored !== "object" || stored === null) return STANDARD;
    const { theme, leftHanded, name, sound, layers, units, language, droneUp } = stored as Partial<Preferences>;
    return {
      theme: theme === "light" || theme === "dark" || theme === "outdoor" ? theme : "auto",
      leftHanded: leftHanded === true,
      name: typeof name === "string" ? name : null,
      sound: sound !== false,
      layers: readLayers(layers),
      units: units === "feet" ? "feet" : "metres",
      language: isLanguage(language) ? language : "auto",
      droneUp: droneUp === true,
    };
  } catch {
    return STANDARD;
  }
}

/** Stores them; a browser that keeps nothing (private window) is no error. */
export function writePreferences(storage: Storage, preferences: Preferences): void {
  try {
    storage.setItem(KEY, JSON.stringify(preferences));
  } catch {
    return;
  }
}

/** A layer that is not known to be off is on. */
function readLayers(stored: unknown): Layers {
  const known: Partial<Record<Layer, unknown>> = typeof stored === "object" && stored !== null ? stored : {};
  return Object.fromEntries(LAYERS.map((layer) => [layer, known[layer] !== false])) as Record<Layer, boolean>;
}
