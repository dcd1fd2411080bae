import { html, type TemplateResult } from "lit";
import type { Route } from "../route/route.ts";
import { say } from "../words/say.ts";
import type { LotAccess } from "../views/lot-views.ts";

/** The views of lots, read when one of them is opened first: the flight's page does not wait for them. */
export class LateViews {
  private state: "none" | "asked" | "there" | "failed" = "none";
  private readonly drawAgain: () => void;
  private readonly load: () => Promise<unknown>;

  constructor(drawAgain: () => void, load: () => Promise<unknown> = loadViews) {
    this.drawAgain = drawAgain;
    this.load = load;
  }

  render(route: Route, access: LotAccess, spoken: string): TemplateResult {
    if (this.state === "none") this.ask();
    if (this.state === "failed")
      return html`<div class="page"><p role="alert">${say("archive-unanswered")}</p><button @click=${() => this.ask()}>${say("archive-ask-again")}</button></div>`;
    if (this.state !== "there") return html`<div class="page"><p>${say("archive-asking")}</p></div>`;
    return html`<hawk-views .route=${route} .access=${access} .spoken=${spoken}></hawk-views>`;
  }

  private ask(): void {
    this.state = "asked";
    void this.load().then(
      () => this.become("there"),
      () => this.become("failed"),
    );
  }

  private become(state: "there" | "failed"): void {
    this.state = state;
    this.drawAgain();
  }
}

async function loadViews(): Promise<void> {
  await Promise.all([import("../views/lot-views.ts"), styleSheet("views.css")]);
}

/** The form of a plan's sections, read when one is drawn first. */
export function readSectionForm(): void {
  void import("../ui/plan-section.ts");
}

/** Adds a style sheet to the document, once it is there. */
function styleSheet(name: string): Promise<void> {
  return new Promise((resolve, reject) => {
    const link = document.createElement("link");
    link.rel = "stylesheet";
    link.href = name;
    link.onload = () => resolve();
    link.onerror = () => reject(new Error(name));
    document.head.append(link);
  });
}
