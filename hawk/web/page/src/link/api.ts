import type { Problem } from "../api.ts";
import { learn } from "../words/drone.ts";
import { say } from "../words/say.ts";

/** Address of the drone's API. */
export const API = "api/v1";
/** How long a busy drone is asked again, and the pause between where it names none, ms. */
const PATIENCE_MS = 60_000;
const PAUSE_MS = 2_000;
const BUSY = 503;
/** The most items of a part of a list. */
const AT_ONCE = "1000";

/** Who edits a plan, and since when (UTC in ISO 8601). */
export interface Editor {
  who: string;
  since: string;
}

/** A question that the drone refused; the text says why. Without an answer the status is 0, and the text empty. */
export class Refused extends Error {
  readonly status: number;
  /** What is wrong of what was sent: a field of the address or of the body; "" where none is. */
  readonly field: string;
  /** The person who edits the plan that was to be changed. */
  readonly editor: Editor | null;

  /** The link that was shared opens nothing any more. */
  get isEndedLink(): boolean {
    return this.status === 404 && /^(token|share)$/.test(this.field);
  }

  /** The drone has too much to do, or reads what was asked for. */
  get isBusy(): boolean {
    return this.status === BUSY;
  }

  /** No answer came, or the drone is busy: the same may be answered later. */
  get isForNow(): boolean {
    return this.status === 0 || this.isBusy;
  }

  constructor(reason = "", status = 0, editor: Editor | null = null, field = "") {
    super(reason);
    this.status = status;
    this.field = field;
    this.editor = editor;
  }
}

/** Part of a list; `next` is where the following one begins. */
export interface Part<T> {
  items: T[];
  next: string | null;
}

/** Reads a whole list of the API, part by part. */
export async function readAll<T>(name: string, filter: Record<string, string> = {}): Promise<T[]> {
  const found: T[] = [];
  let after = "";
  for (;;) {
    const { items, next } = await read<Part<T>>(`${API}/${name}${query({ ...filter, limit: AT_ONCE, after })}`);
    found.push(...items);
    if (next === null) return found;
    after = next;
  }
}

/** Values as the query of an address, without those that are empty; a list says its name again for each. */
export function query(values: Record<string, string | readonly string[]>): string {
  const all = Object.entries(values).flatMap(([name, value]) => [value].flat().map((each) => [name, each]));
  const given = new URLSearchParams(all.filter(([, value]) => value !== "")).toString();
  return given && `?${given}`;
}

/** Asks for JSON, which the drone lets nobody keep unasked. Rejects with Refused, in the drone's words where it gave some. */
export function read<T>(address: string): Promise<T> {
  return asked(address, {});
}

/** Asks for JSON by a link that was shared. One that is none says so in the reader's language. */
export async function readByLink<T>(address: string): Promise<T> {
  try {
    return await read<T>(address);
  } catch (error) {
    const { status, field, isEndedLink } = error as Refused;
    if (status === 429) throw new Refused(say("link-too-often"), status);
    throw isEndedLink ? new Refused(say("link-ended"), status, null, field) : error;
  }
}

/** Asks for JSON; null where there is none. */
export function answer<T>(address: string): Promise<T | null> {
  return orNull(read<T>(address));
}

/** The answer to a question; null where it was refused, or none came. */
export function orNull<T>(asked: Promise<T>): Promise<T | null> {
  return asked.catch(() => null);
}

/** Posts a change, or a file, to an address of the API; returns the answer. Rejects with Refused. */
export function post<T>(path: string, body: object = {}): Promise<T> {
  const sent = body instanceof Blob ? { body } : { headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) };
  return asked(`${API}/${path}`, { method: "POST", ...sent });
}

/** Reads a file with the name that the drone gives it, else `name`. Rejects as `read`. */
export function readFile(address: string, name: string): Promise<{ name: string; content: Blob }> {
  return taken(address, { cache: "no-cache" }, async (found) => {
    const given = /filename="([^"]+)"/.exec(found.headers.get("Content-Disposition") ?? "");
    return { name: given?.[1] ?? name, content: await found.blob() };
  });
}

function asked<T>(address: string, options: RequestInit): Promise<T> {
  return taken(address, options, async (found) => (await found.json()) as T);
}

/** A busy drone is asked again, but not for a change, which it may have made. */
async function taken<T>(address: string, options: RequestInit, take: (found: Response) => Promise<T>): Promise<T> {
  for (let left = options.method === undefined ? PATIENCE_MS : 0; ; ) {
    let found: Response;
    try {
      found = await fetch(address, options);
      if (found.ok) return await take(found);
    } catch {
      throw new Refused();
    }
    const pause = 1000 * Number(found.headers.get("Retry-After")) || PAUSE_MS;
    if (found.status !== BUSY || pause > left) throw refusal(found.status, await found.text());
    left -= pause;
    await new Promise((resolve) => setTimeout(resolve, pause));
  }
}

function refusal(status: number, text: string): Refused {
  try {
    const { field, detail, who, since, sentences = [] } = JSON.parse(text) as Pick<Problem, "field" | "detail" | "who" | "since"> & Partial<Problem>;
    const said = field ? `${field}: ${detail}` : detail;
    learn(sentences.map((each) => ({ Text: each.text === detail ? said : each.text, Code: each.code, Values: each.values })));
    return new Refused(said, status, who && since ? { who, since } : null, field);
  } catch {
    return new Refused(text, status);
  }
}
