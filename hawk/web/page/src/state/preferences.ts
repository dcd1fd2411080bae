export type Theme = "auto" | "light" | "dark";

export interface Preferences {
  theme: Theme;
  leftHanded: boolean;
}

type Storage = Pick<globalThis.Storage, "getItem" | "setItem">;

const KEY = "hawk-page";
const STANDARD: Preferences = { theme: "auto", leftHanded: false };

/** Reads the preferences that this browser stored; those that cannot be read have their defaults. */
export function readPreferences(storage: Storage): Preferences {
  try {
    const stored: unknown = JSON.parse(storage.getItem(KEY) ?? "{}");
    if (typeof stored !== "object" || stored === null) return STANDARD;
    const { theme, leftHanded } = stored as Partial<Preferences>;
    return {
      theme: theme === "light" || theme === "dark" ? theme : "auto",
      leftHanded: leftHanded === true,
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
