import { answer } from "./api.ts";

export type SettingValue = boolean | number | string | string[] | null;

/** A setting of the drone's program, as it runs with it. Bounds are null for what is no number. */
export interface Setting {
  Section: string;
  Key: string;
  Text: string;
  Unit: string;
  Value: SettingValue;
  Default: SettingValue;
  Lowest: number | null;
  Highest: number | null;
}

/** Asks the drone for its settings; null when it does not answer. */
export async function fetchSettings(): Promise<Setting[] | null> {
  const found = await answer<{ Settings?: Setting[] } | null>("api/settings.json");
  return Array.isArray(found?.Settings) ? found.Settings : null;
}
