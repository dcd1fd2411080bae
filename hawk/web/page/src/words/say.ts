import { FluentBundle, FluentNumber, FluentResource } from "@fluent/bundle";
import englishText from "../messages/en.ftl";
import type { Messages } from "../messages/keys.ts";
import { type LanguageName, LANGUAGES } from "./languages.ts";

interface Speech {
  name: LanguageName;
  bundle: FluentBundle;
  /** Messages that nobody has asked for, by their names: each is parsed when it is wanted first. */
  unread: Map<string, string>;
  /** By the least and the largest number of decimals. */
  numbers: Map<string, Intl.NumberFormat>;
}

type Values<Key extends keyof Messages> = Messages[Key] extends Record<string, never> ? [] : [values: Messages[Key]];

/** Behind each text in a sentence of the drone, so that one full stop is left where it ends with one itself. */
const END = "\u2060";
const STOPPED_TWICE = /([.!?])\u2060\./g;

const ENGLISH = speech("en", englishText);
/** One for the whole document, as its attribute lang is. */
let spoken = ENGLISH;

/** A message in the language of the page; in English where that language lacks it. */
export function say<Key extends keyof Messages>(key: Key, ...values: Values<Key>): string {
  const [given = {}] = values as [Record<string, string | number>?];
  return format(spoken, key, given) ?? format(ENGLISH, key, given) ?? key;
}

/** A sentence of the drone's program in the language of the page; null where that lacks the code. */
export function sayOfDrone(code: string, values: Record<string, string | number>): string | null {
  const marked = Object.entries(values).map(([name, value]) => [name, typeof value === "string" ? `${value}${END}` : value] as const);
  const text = format(spoken, `drone-${code}`, Object.fromEntries(marked));
  return text?.replaceAll(STOPPED_TWICE, "$1").replaceAll(END, "").trim() ?? null;
}

/** From now on the page speaks this language, of which `text` is the file of messages; English needs none. */
export function speak(name: LanguageName, text = englishText): void {
  spoken = name === "en" ? ENGLISH : speech(name, text);
}

/** The language that the page speaks. */
export function language(): LanguageName {
  return spoken.name;
}

/** A number in the digits of the language, with at most `decimals` and at least `least` of them; never a zero below 0. */
export function number(value: number, decimals = 0, least = decimals): string {
  const rounded = Number(value.toFixed(decimals));
  return numberFormat(least, decimals).format(rounded === 0 ? 0 : rounded);
}

/** A number as it is typed: without groups of digits. */
export function typedNumber(value: number, decimals: number): string {
  return value.toLocaleString(spoken.name, { maximumFractionDigits: decimals, useGrouping: false });
}

/** Of a message, what a finger or a mouse does. */
export function pointer(touch: boolean): "finger" | "mouse" {
  return touch ? "finger" : "mouse";
}

/** Whole sentences, one after the other; those that are empty are left out. */
export function sentences(...parts: string[]): string {
  return parts.filter((part) => part !== "").join(" ");
}

/** A word that stands alone, with a large first letter. */
export function capital(word: string): string {
  return word.charAt(0).toLocaleUpperCase(spoken.name) + word.slice(1);
}

function numberFormat(minimumFractionDigits: number, maximumFractionDigits: number): Intl.NumberFormat {
  const key = `${minimumFractionDigits} ${maximumFractionDigits}`;
  const found = spoken.numbers.get(key);
  if (found) return found;
  const useGrouping = LANGUAGES[spoken.name].grouping;
  const made = new Intl.NumberFormat(spoken.name, { minimumFractionDigits, maximumFractionDigits, useGrouping });
  spoken.numbers.set(key, made);
  return made;
}

function speech(name: LanguageName, text: string): Speech {
  const bundle = new FluentBundle(name, { useIsolating: false, transform: LANGUAGES[name].typography });
  const unread = new Map(text.split(/\n(?=[\w-])/).map((message) => [/^[\w-]*/.exec(message)?.[0] ?? "", message]));
  return { name, bundle, unread, numbers: new Map() };
}

/** Parses a message that was not read, and those that it names. */
function readMessage(speech: Speech, key: string): void {
  const text = speech.unread.get(key);
  if (text === undefined) return;
  speech.unread.delete(key);
  for (const error of speech.bundle.addResource(new FluentResource(text))) console.error(`messages of ${speech.name}:`, error.message);
  for (const [, named = ""] of text.matchAll(/\{\s*(-?[a-z][\w-]*)/g)) readMessage(speech, named);
}

function format(speech: Speech, key: string, given: Record<string, string | number>): string | null {
  const { name, bundle } = speech;
  readMessage(speech, key);
  const pattern = bundle.getMessage(key)?.value;
  if (pattern == null) return null;
  const { grouping: useGrouping } = LANGUAGES[name];
  const values: Record<string, string | FluentNumber> = {};
  for (const [each, value] of Object.entries(given)) {
    values[each] = typeof value === "number" ? new FluentNumber(value, { useGrouping }) : value;
  }
  return bundle.formatPattern(pattern, values, []);
}
