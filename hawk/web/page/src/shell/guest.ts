import { html, LitElement, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import type { SurveysUse } from "../api.ts";
import { API, readByLink, Refused } from "../link/api.ts";
import type { ViewName } from "../route/place.ts";
import { Route } from "../route/route.ts";
import type { LanguageChoice } from "../state/preferences.ts";
import { RedrawOnChange } from "../ui/redraw-on-change.ts";
import { language, say } from "../words/say.ts";
import type { BarLot } from "./top-bar.ts";
import "./top-bar.ts";
import { LateViews } from "./views.ts";

/** Views by the number of surveys that count: none is shown that would be empty. */
const VIEWS: readonly [ViewName, number][] = [["lots", 0], ["compare", 2], ["report", 1]];

/** Number of the newest surveys that are looked at whether they count. */
const NEWEST = 8;

/** One lot for who has its link: no login, no drone, nothing is changed. */
@customElement("hawk-guest")
export class Guest extends LitElement {
  @property({ attribute: false }) route = new Route();
  @property({ attribute: false }) token = "";
  @property({ attribute: false }) speak: (choice: LanguageChoice) => void = () => undefined;
  /** What the link shows; the words of its refusal. */
  @state() private shown: SurveysUse | null = null;
  @state() private problem = "";
  private askedIn = "";
  readonly late = new LateViews(() => this.requestUpdate());

  constructor() {
    super();
    new RedrawOnChange(this, () => this.route);
  }

  protected override createRenderRoot(): HTMLElement {
    return this;
  }

  /** Asked for again in another language: a refusal is said in that. */
  override willUpdate(): void {
    if (this.askedIn === language()) return;
    this.askedIn = language();
    if (this.shown === null) void this.ask();
  }

  private async ask(): Promise<void> {
    try {
      this.shown = await readByLink<SurveysUse>(`${API}/shared/${this.token}/statistics/surveys?newest=${NEWEST}`);
      this.problem = "";
    } catch (error) {
      this.problem = error instanceof Refused && error.field !== "" ? error.message : "";
    }
  }

  override render(): TemplateResult {
    const { shown, route } = this;
    const access = { lots: [], unlisted: "", token: this.token, mayChange: false, operator: null, isForSome: false };
    const counted = shown?.surveys.filter((row) => row.left_out_code === "").length ?? 0;
    const views = this.problem === "" ? VIEWS.filter(([, least]) => counted >= least).map(([view]) => view) : [];
    return html`<hawk-top .route=${route} .place=${route.place} .views=${views} .lots=${shown && this.problem === "" ? [lotOf(shown)] : null} .spoken=${language()} .speak=${this.speak}></hawk-top>
      <div class="view" role="main" @archive-ended=${({ detail }: CustomEvent<string>) => (this.problem = detail)}>${this.problem === "" ? this.late.render(route, access, language()) : html`<div class="page"><h1>${say("link-shows-nothing")}</h1><p role="alert">${this.problem}</p></div>`}</div>`;
  }
}

function lotOf({ lot, name, clock, surveys }: SurveysUse): BarLot {
  return { id: lot, name, time_zone: clock, survey_count: null, last_survey: surveys[0] ?? null };
}
