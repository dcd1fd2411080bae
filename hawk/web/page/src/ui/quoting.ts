import { html, type TemplateResult } from "lit";
import type { CheckItem } from "../protocol.ts";
import { droneSentences } from "../words/quotes.ts";
import { translated } from "../words/drone.ts";
import { language } from "../words/say.ts";
import type { View } from "../words/view.ts";

type Words = string | TemplateResult;

/** Words of the drone's program in the language of the page. Where that has none they are English, and read aloud as such. */
export function drone(text: string): Words {
  if (language() === "en" || text === "") return text;
  return translated(text) ?? html`<span lang="en">${text}</span>`;
}

/** Words of the page with a sentence of the drone's program among them, which is one of those given. */
export function quoting(text: string, sentences: readonly string[]): Words {
  if (language() === "en") return text;
  const [quoted] = sentences.filter((each) => each !== "" && text.includes(each)).sort((a, b) => b.length - a.length);
  if (quoted === undefined) return text;
  const at = text.indexOf(quoted);
  return html`${text.slice(0, at)}${drone(quoted)}${text.slice(at + quoted.length)}`;
}

/** A check with its value, both in the drone's words. */
export function checkWords({ Name, Value }: CheckItem): Words {
  return language() === "en" ? `${Name}: ${Value}` : html`${drone(Name)}\u00a0: ${drone(Value)}`;
}

/** A note or a reason: the page's own words, or those of the drone. */
export function noted(view: View, text: string, ...more: string[]): Words {
  return language() === "en" ? text : quoting(text, [...droneSentences(view), ...more]);
}
