import { html, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import type { RecordingsOfSurvey } from "../api.ts";
import { API, post, read } from "../link/api.ts";
import { bytes } from "../words/format.ts";
import { say } from "../words/say.ts";
import { Asked, View, wordsOf } from "./view.ts";

/** While a drone is asked the desk is looked at again after so long. */
const AGAIN_MS = 5000;

/** The recordings of a survey that a drone sent to this desk: an operator asks for them, and they come when it stands. */
@customElement("archive-asked-recordings")
export class AskedRecordings extends View {
  /** Id of the survey. */
  @property() survey = "";
  private readonly found = new Asked<RecordingsOfSurvey>(this);
  private looks = 0;
  private timer: ReturnType<typeof setTimeout> | undefined;
  /** The survey that was seen asked for. */
  private wasAsked = "";

  override willUpdate(): void {
    this.found.ask(`${this.survey} ${this.revision} ${this.looks}`, () => read(`${API}/surveys/${this.survey}/recordings`), this.survey);
  }

  override updated(): void {
    const { value, waiting } = this.found;
    if (waiting || value === null) return;
    clearTimeout(this.timer);
    if (isAsked(value)) {
      this.wasAsked = value.survey;
      this.timer = setTimeout(() => {
        this.looks++;
        if (this.isConnected) this.requestUpdate();
      }, AGAIN_MS);
    } else if (value.state === "here" && this.wasAsked === value.survey) {
      this.wasAsked = "";
      this.changed(); // it can be watched now
    }
  }

  override disconnectedCallback(): void {
    clearTimeout(this.timer);
    super.disconnectedCallback();
  }

  override render(): TemplateResult | typeof nothing {
    const { value } = this.found;
    if (value?.drone == null || value.state === "here") return nothing;
    const words = wordsFor(value, value.drone);
    const wanted = !isAsked(value);
    return html`${words === "" ? nothing : html`<p class="sub" role="status">${words}</p>`}
      ${value.problem === "" ? nothing : html`<p class="warning" lang="en">${value.problem}</p>`}
      <p><button class="small" @click=${() => void this.want(wanted)}>${say(wanted ? "asked-recordings-ask" : "asked-recordings-take-back")}</button></p>`;
  }

  private async want(ask: boolean): Promise<void> {
    try {
      await post(`surveys/${this.survey}/recordings/ask`, { asked: ask });
    } catch (error) {
      this.said(wordsOf(error));
    }
    this.looks++;
    this.requestUpdate();
  }
}

function isAsked({ state }: RecordingsOfSurvey): boolean {
  return state === "asked" || state === "coming";
}

function wordsFor({ state, stored, bytes: size }: RecordingsOfSurvey, drone: string): string {
  if (state === "coming") return say("asked-recordings-coming", { received: bytes(stored), size: bytes(size ?? stored), drone });
  return state === "asked" || state === "never" || state === "gone" ? say(`asked-recordings-${state}`, { drone }) : "";
}
