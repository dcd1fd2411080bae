import type { Setting, SettingValue } from "../link/settings.ts";
import { say } from "./say.ts";

/** A setting in words. `changed`: it is not the default. */
export interface SettingWords {
  name: string;
  value: string;
  bounds: string;
  text: string;
  changed: boolean;
}

export function settingWords(setting: Setting): SettingWords {
  const { Key, Unit, Value, Default, Lowest, Highest, Text } = setting;
  return {
    name: Key,
    value: withUnit(valueWords(Value), Value === null ? "" : Unit),
    bounds: Lowest === null || Highest === null ? "" : withUnit(say("setting-bounds", { lowest: String(Lowest), highest: String(Highest) }), Unit),
    text: Text,
    changed: JSON.stringify(Value) !== JSON.stringify(Default),
  };
}

/** Settings by section, those alone that contain every word of a search in section, name or text. */
export function settingGroups(settings: readonly Setting[], search: string): [section: string, settings: SettingWords[]][] {
  const words = search.toLowerCase().split(/\s+/).filter(Boolean);
  const groups = new Map<string, SettingWords[]>();
  for (const setting of settings) {
    const all = `${setting.Section} ${setting.Key} ${setting.Text}`.toLowerCase();
    if (!words.every((word) => all.includes(word))) continue;
    groups.set(setting.Section, [...(groups.get(setting.Section) ?? []), settingWords(setting)]);
  }
  return [...groups];
}

function valueWords(value: SettingValue): string {
  if (value === null) return say("setting-not-set");
  if (Array.isArray(value)) return value.length === 0 ? say("setting-none") : value.join(", ");
  return String(value); // as it must be written in the file, in any language
}

function withUnit(text: string, unit: string): string {
  return unit === "°" || unit === "" ? `${text}${unit}` : `${text} ${unit}`;
}
