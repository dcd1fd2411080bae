import { html, type TemplateResult } from "lit";
import type { Place } from "../route/place.ts";
import type { Route } from "../route/route.ts";
import { say } from "../words/say.ts";
import type { LotAccess } from "../views/lot-views.ts";
import { LatePart, READING } from "./late-part.ts";

/** The parts in which the views of lots are read. */
type PartName = "maps" | "figures";

async function loadPart(name: PartName): Promise<void> {
  await Promise.all([READING[name](), styleSheet("views.css")]);
}

/** The views of lots, read when one of them is opened first: the flight's page does not wait for them, nor one that has no map for the map. */
export class LateViews {
  private readonly parts = new Map<PartName, LatePart>();
  private readonly drawAgain: () => void;
  private readonly load: (name: PartName) => Promise<unknown>;

  constructor(drawAgain: () => void, load: (name: PartName) => Promise<unknown> = loadPart) {
    this.drawAgain = drawAgain;
    this.load = load;
  }

  render(route: Route, access: LotAccess, spoken: string): TemplateResult {
    const part = this.part(partOf(route.place));
    const isThere = part.want();
    return isThere ? html`<hawk-views .route=${route} .access=${access} .spoken=${spoken}></hawk-views>` : waitingFor(part);
  }

  private part(name: PartName): LatePart {
    const part = this.parts.get(name) ?? new LatePart(() => this.load(name), this.drawAgain);
    this.parts.set(name, part);
    return part;
  }
}

function partOf({ view, show, recording }: Place): PartName {
  const isPlain = view === "recordings" ? recording === "" : view === "report" || show === "document" || show === "links" || show === "arrivals";
  return isPlain ? "figures" : "maps";
}

/** What is said while a part is read, and when it cannot be. */
export function waitingFor(part: LatePart): TemplateResult {
  if (part.state === "failed") return html`<div class="page"><p role="alert">${say("archive-unanswered")}</p><button @click=${() => part.ask()}>${say("archive-ask-again")}</button></div>`;
  return html`<div class="page"><p>${say("archive-asking")}</p></div>`;
}

const styles = new Map<string, Promise<void>>();

/** Adds a style sheet to the document, once it is there. */
function styleSheet(name: string): Promise<void> {
  const adding = styles.get(name) ?? addStyleSheet(name);
  styles.set(name, adding);
  adding.catch(() => styles.delete(name));
  return adding;
}

function addStyleSheet(name: string): Promise<void> {
  return new Promise((resolve, reject) => {
    const link = document.createElement("link");
    link.rel = "stylesheet";
    link.href = name;
    link.onload = () => resolve();
    link.onerror = () => reject(new Error(name));
    document.head.append(link);
  });
}
