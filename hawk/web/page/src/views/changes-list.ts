import { html, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import type { Change } from "../api.ts";
import { API, type Part, post, query, read } from "../link/api.ts";
import { say } from "../words/say.ts";
import { moment } from "./figures.ts";
import type { DeletedSurvey } from "./link.ts";
import { Asked, View, wordsOf } from "./view.ts";

const SHOWN = "6";
const KINDS = {
  delete: "change-delete",
  drop: "change-drop",
  import: "change-import",
  merge: "change-merge",
  move: "change-move",
  name: "change-name",
  pin: "change-pin",
  place: "change-place",
  plan: "change-plan",
  split: "change-split",
  take_over: "change-take-over",
  time_zone: "change-time-zone",
} as const;

/** The newest changes that persons made in a lot, each with its undo: it lasts longer than the page. */
@customElement("hawk-changes")
export class ChangesList extends View {
  /** The lot's time zone, whose clock all times of the view are by. */
  @property() clock = "UTC";
  private readonly listed = new Asked<Part<Change>>(this);
  /** The end of each deleted survey, by the number of its change: it distinguishes one from another. */
  private readonly deleted = new Asked<DeletedSurvey[]>(this);

  override willUpdate(): void {
    const { lot } = this.place;
    if (lot !== "") this.listed.ask(`${lot} ${this.revision}`, () => read(`${API}/changes${query({ lot, limit: SHOWN })}`));
    if (this.listed.value?.items.some(({ kind, undone }) => kind === "delete" && undone === null)) this.deleted.ask(`${lot} ${this.revision}`, () => this.source.deleted({ from: "", to: "" }));
  }

  override render(): TemplateResult | typeof nothing {
    const { value, problem } = this.listed;
    if (problem !== "") return html`<p role="alert">${problem}</p>`;
    if (value === null || value.items.length === 0) return nothing;
    return html`<section aria-label=${say("changes")}><h3>${say("changes")}</h3><ul class="changes">${value.items.map((change) => this.row(change))}</ul></section>`;
  }

  private row(change: Change): TemplateResult {
    const { kind, who, made, undone, kept } = change;
    const ended = this.deleted.value?.find(({ seq }) => seq === change.seq)?.ended;
    const known = Object.hasOwn(KINDS, kind) ? say(KINDS[kind as keyof typeof KINDS]) : kind;
    const words = ended === undefined ? known : `${known} (${moment(ended, this.clock)})`;
    const can = undone === null && kept === null && this.mayChange;
    return html`<li><span>${words} <span class="sub">${[moment(made, this.clock), who, undone === null ? "" : say("change-undone")].filter((each) => each !== "").join(" · ")}</span></span>
      ${can ? html`<button class="small" aria-label=${say("change-undo", { change: words, when: moment(made, this.clock) })} @click=${() => void this.undo(change)}>${say("archive-undo")}</button>` : nothing}</li>`;
  }

  private async undo({ seq }: Change): Promise<void> {
    try {
      await post(`changes/${seq}/undo`);
    } catch (error) {
      this.said(wordsOf(error));
    }
    this.changed();
  }
}
