import { html, LitElement, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import type { ViewName } from "../route/place.ts";
import { Route } from "../route/route.ts";
import type { LanguageChoice } from "../state/preferences.ts";
import { RedrawOnChange } from "../ui/redraw-on-change.ts";
import { language } from "../words/say.ts";
import "./top-bar.ts";
import { LateViews } from "./views.ts";

const VIEWS: readonly ViewName[] = ["lots", "compare", "report"];

/** One lot for who has its link: no login, no drone, nothing is changed. */
@customElement("hawk-guest")
export class Guest extends LitElement {
  @property({ attribute: false }) route = new Route();
  @property({ attribute: false }) token = "";
  @property({ attribute: false }) speak: (choice: LanguageChoice) => void = () => undefined;
  readonly late = new LateViews(() => this.requestUpdate());

  constructor() {
    super();
    new RedrawOnChange(this, () => this.route);
  }

  protected override createRenderRoot(): HTMLElement {
    return this;
  }

  override render(): TemplateResult {
    const access = { lots: [], token: this.token, mayChange: false };
    return html`<hawk-top .route=${this.route} .place=${this.route.place} .views=${VIEWS} .spoken=${language()} .speak=${this.speak}></hawk-top>
      <div class="view" role="main">${this.late.render(this.route, access, language())}</div>`;
  }
}
