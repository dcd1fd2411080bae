import { patterns, type Pattern } from "../dev/keys.ts";
import { messagesOf } from "./french.ts";

/** A piece of text that a person reads or hears, and whether it is marked as English. */
export interface Spoken {
  text: string;
  isEnglish: boolean;
}

const HEARD = ["aria-label", "aria-description", "title", "placeholder"];

/** Everything that a part of the page says: its texts, and the attributes that are shown or read aloud. */
export function spoken(root: Element): Spoken[] {
  const found: Spoken[] = [];
  const add = (text: string, element: Element): void => {
    const bare = text.replace(/[ \n]+/g, " ").trim();
    if (/\p{L}{2}/u.test(bare)) found.push({ text: bare, isEnglish: element.closest("[lang]")?.getAttribute("lang") === "en" });
  };
  const look = (element: Element): void => {
    for (const name of HEARD) add(element.getAttribute(name) ?? "", element);
    for (const node of element.childNodes) {
      if (node.nodeType === 3) add(node.textContent ?? "", element);
      else if (node.nodeType === 1) look(node as Element);
    }
  };
  look(root);
  return found;
}

/** Words of the English messages, and of those of another language that say something else. */
export class EnglishWords {
  private readonly whole: RegExp[];

  constructor(other: "fr") {
    const [english, translated] = [patterns(messagesOf("en")), patterns(messagesOf(other))];
    const same = new Set([...translated.values()].flatMap(versions));
    const texts = [...english.values()].flatMap(versions).filter((text) => !same.has(text) && /[a-z]{2}/i.test(text.replaceAll(VALUE, "")));
    this.whole = texts.map((text) => new RegExp(`(^|[.] )${text.split(VALUE).map(escape).join(".+")}( |$)`));
  }

  /** Those messages of which a text is one, or has one as a sentence. */
  in(text: string): string[] {
    return this.whole.filter((pattern) => pattern.test(text)).map(String);
  }
}

const VALUE = "\u0000";

/** Every text that a message can be; values are marks. */
function versions(pattern: Pattern): string[] {
  if (typeof pattern === "string") return [pattern];
  return pattern.reduce<string[]>(
    (made, element) => {
      const next =
        typeof element === "string" ? [element] : element.type === "select" ? element.variants.flatMap(({ value }) => versions(value)) : [VALUE];
      return made.flatMap((before) => next.map((text) => before + text));
    },
    [""],
  );
}

function escape(text: string): string {
  return text.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");
}
