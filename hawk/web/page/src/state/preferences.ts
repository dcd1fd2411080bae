export type Theme = "auto" | "light" | "dark" | "outdoor";

export interface Preferences {
  theme: Theme;
  leftHanded: boolean;
  /** What the others call this operator; null: not asked yet, empty: none. */
  name: string | null;
  /** Tone and voice report what others do. */
  sound: boolean;
}

type Storage = Pick<globalThis.Storage, "getItem" | "setItem">;

const KEY = "hawk-page";
const STANDARD: Preferences = { theme: "auto", leftHanded: false, name: null, sound: true };

/** Reads the preferences that this browser stored; those that cannot be read have their defaults. */
export function readPreferences(storage: Storage): Preferences {
  try {
    const stored: unknown = JSON.parse(storage.getItem(KEY) ?? "{}");
    if (typeof stored !== "object" || stored === null) return STANDARD;
    const { theme, leftHanded, name, sound } = stored as Partial<Preferences>;
    return {
      theme: theme === "light" || theme === "dark" || theme === "outdoor" ? theme : "auto",
      leftHanded: leftHanded === true,
      name: typeof name === "string" ? name : null,
      sound: sound !== false,
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
