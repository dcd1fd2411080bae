import { html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import type { ListedLot } from "../api.ts";
import { type Place, type ViewName, VIEWS } from "../route/place.ts";
import type { Route } from "../route/route.ts";
import type { LanguageChoice } from "../state/preferences.ts";
import { icon } from "../ui/icons.ts";
import { nameOrder } from "../words/find.ts";
import { type LanguageName, LANGUAGES } from "../words/languages.ts";
import { clockWords, keepClock, timeOnClock } from "../words/clock.ts";
import { language, say } from "../words/say.ts";

/** What the bar says of the drone, with the view that a press on it leads to. */
export interface DroneChip {
  title: string;
  detail: string;
  tone: string;
}

/** A lot that may be chosen, and what is said of it. */
export type BarLot = Pick<ListedLot, "id" | "name" | "time_zone"> & { survey_count: number | null; last_survey: { id: string; ended: string } | null };

/** Lots that a list shows: among more, a person searches the table of all. */
const MOST_CHOSEN = 500;

/** On every view: the lot, the views, the drone's state, language and help. */
@customElement("hawk-top")
export class TopBar extends LitElement {
  @property({ attribute: false }) place!: Place;
  @property({ attribute: false }) route!: Route;
  @property({ attribute: false }) views: readonly ViewName[] = [];
  /** Null: there is nothing to choose. */
  @property({ attribute: false }) lots: readonly BarLot[] | null = null;
  @property({ attribute: false }) drone: DroneChip | null = null;
  /** Redraws the bar in another language. */
  @property() spoken = "";
  @property({ attribute: false }) speak: (choice: LanguageChoice) => void = () => undefined;

  /** Those of the menu, by name. */
  private chosen: readonly BarLot[] = [];

  /** All parts write their times by another clock now. */
  @property({ attribute: false }) clocked: () => void = () => undefined;

  protected override createRenderRoot(): HTMLElement {
    return this;
  }

  override willUpdate(changed: PropertyValues<this>): void {
    if (changed.has("lots") || changed.has("spoken")) {
      const compare = nameOrder();
      this.chosen = (this.lots?.length ?? 0) > MOST_CHOSEN ? [] : [...(this.lots ?? [])].sort((one, other) => compare(one.name, other.name));
    }
    if (keepClock(this.lot?.time_zone)) this.clocked();
  }

  private get lot(): BarLot | undefined {
    return this.lots?.find(({ id }) => id === this.place.lot) ?? this.lots?.[0];
  }

  override render(): TemplateResult {
    return html`<header class="top no-print ${this.place.view}">
      ${this.picker()}
      ${viewLinks(this.views, this.route)}
      <span class="grow"></span>
      ${this.drone === null ? nothing : html`<a class="drone" href=${addressOf("fly", this.route)}><i class="mark ${this.drone.tone}"></i><span><b>${this.drone.title}</b><span class="sub">${this.drone.detail}</span></span></a>`}
      <label class="language"><span class="unseen">${say("language")}</span>${icon("globe")}<select @change=${(event: Event) => this.speak((event.target as HTMLSelectElement).value as LanguageName)}>
        ${Object.entries(LANGUAGES).map(([name, { label }]) => html`<option value=${name} lang=${name} title=${label} ?selected=${name === language()}>${name.toUpperCase()}</option>`)}
      </select></label>
      <a class="help" href="docs/" hreflang="en" target="_blank" rel="noopener" aria-label=${say("documentation")}>${icon("help")}</a>
    </header>`;
  }

  /** The lot, with its surveys and whose clock it is: every time of these views is by that. */
  private picker(): TemplateResult | typeof nothing {
    const { lot, lots, place } = this;
    if (lots === null || lot === undefined) return nothing;
    const go = (event: Event): void => this.route.go({ lot: (event.target as HTMLSelectElement).value, survey: "", before: "", after: "", stall: "", section: "", recording: "", t: "", parts: [] });
    const choice = (): TemplateResult => html`<span class="unseen">${say("archive-lot")}</span><select @change=${go}>${this.chosen.map(({ id, name }) => html`<option value=${id} ?selected=${id === place.lot}>${name}</option>`)}</select>`;
    const name = html`<b>${lot.name}</b>`;
    const shown = lots.length > MOST_CHOSEN ? html`<a href=${addressOf("lots", this.route, "all")} title=${say("all-lots")}>${name}</a>` : lots.length > 1 ? choice() : name;
    return html`<label class="lot">${shown}<span class="sub" title=${clockWords(lot.time_zone)}>${about(lot, place)}</span></label>`;
  }
}

/** The day of the newest survey, where that is shown; how many there are elsewhere; whose clock it is, also where there is little room. */
function about({ last_survey: last, survey_count: surveys, time_zone: zone }: BarLot, { view, survey }: Place): TemplateResult {
  const isShown = view === "lots" && last !== null && (survey === "" || survey === last.id);
  const when = isShown ? timeOnClock(last.ended, zone, { weekday: "short", day: "numeric", month: "short" }) : surveys === null ? "" : say("lot-surveys", { surveys });
  return html`${when === "" ? nothing : html`<span class="when">${when} · </span>`}${clockWords(zone)}`;
}

/** Without a store of lots there are recordings, and the flight where a drone is. */
export function viewsOf(hasLots: boolean, isDesk: boolean): readonly ViewName[] {
  if (hasLots) return VIEWS;
  return isDesk ? ["recordings"] : ["fly", "recordings"];
}

/** Links to the views of a lot. */
export function viewLinks(views: readonly ViewName[], route: Route): TemplateResult {
  const shown = route.place.view;
  return html`<nav aria-label=${say("views")}>${views.map(
    (view) => html`<a href=${addressOf(view, route)} aria-current=${view === shown ? "page" : nothing}>${say(`view-${view}`)}</a>`,
  )}</nav>`;
}

/** The lot is kept; the survey and the stall of another view are not this one's. */
function addressOf(view: ViewName, route: Route, show: Place["show"] = ""): string {
  return route.hashTo({ view, survey: "", before: "", after: "", stall: "", section: "", recording: "", t: "", show });
}
