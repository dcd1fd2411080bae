import { html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import type { Refused } from "../link/api.ts";
import { type LotPlace, readLots } from "../link/lot-places.ts";
import type { ViewName } from "../route/place.ts";
import { Route } from "../route/route.ts";
import { type DroneChip, viewLinks, viewsOf } from "../shell/top-bar.ts";
import { LatePart, READING } from "../shell/late-part.ts";
import { LateViews, waitingFor } from "../shell/views.ts";
import { isFlying, isSteered } from "../state/flight.ts";
import type { Operator } from "../state/operator.ts";
import type { LanguageChoice } from "../state/preferences.ts";
import { isViewer } from "../words/actions.ts";
import { stateWords } from "../words/glance.ts";
import { language, say } from "../words/say.ts";
import { stallCount, type View } from "../words/view.ts";
import { leaveByEscape } from "./escape.ts";
import { icon } from "./icons.ts";
import { actOnKey } from "./keys.ts";
import type { MapPanel } from "./map-panel.ts";
import type { TabName } from "./tabs.ts";
import { undoByKey } from "./plan-keys.ts";
import { RedrawOnChange } from "./redraw-on-change.ts";

type Panel = "none" | "menu" | "actions" | "keys";
const PANEL_NAMES = { menu: "menu", actions: "more-actions", keys: "keys" } as const;

/** A view that was opened first is drawn before Fly is read, which it needs once the drone flies. */
const AFTER_VIEW_MS = 3000;
/** HTTP's status of what is not here. */
const NOT_THERE = 404;
/** Views of a role that is for some lots: the others are of a drone. */
const OF_LOTS: readonly ViewName[] = ["lots", "compare", "report"];

/** A person whose role is for some lots. */
export interface Person {
  person: string;
  role: "viewer" | "operator";
}

/** Lots that could not be read are asked for again after so long. */
const AGAIN_MS = 5000;

/** The page: the views, and in Fly glance line, banner, map with video and side column, bar. */
@customElement("hawk-app")
export class App extends LitElement {
  model!: Operator;
  /** The role is for some lots: nothing of a drone is read or shown. */
  @property({ type: Boolean, attribute: "some-lots" }) isForSome = false;
  /** Whose role that is, once it is known. */
  @property({ attribute: false }) person: Person | null = null;
  @property({ attribute: false }) route = new Route();
  @state() private lots: LotPlace[] | null = null;
  /** Why the lots could not be read. */
  @state() private unlisted = "";
  /** There is no store of lots. */
  @state() private isAlone = false;
  /** The lot that the address named is not there: the first one is shown. */
  @state() private isLotGone = false;
  private listedFor: ViewName | null = null;
  @state() private panel: Panel = "none";
  @state() private survey = false;
  @state() private swapped = false;
  @state() private tab: TabName | "" = "";
  @query("hawk-map") private map!: MapPanel | null;
  /** Fly is made when it is opened first: a person who opens another view does not wait for its map. */
  private wasOpen = false;
  /** Glance line, map, bar: read at once where they are shown, else once the view that was opened is. */
  private readonly fly = new LatePart(READING.fly, () => this.requestUpdate());
  private landedAt: string | null = null;
  private readonly dark = matchMedia("(prefers-color-scheme: dark)");
  readonly late = new LateViews(() => this.requestUpdate());

  constructor() {
    super();
    new RedrawOnChange(this, () => this.model);
    this.addEventListener("lots-listed", () => void this.listLots());
    this.addEventListener("open-panel", (event) => this.open((event as CustomEvent<string>).detail));
    this.dark.addEventListener("change", () => this.dress());
  }

  override connectedCallback(): void {
    super.connectedCallback();
    document.addEventListener("keydown", this.key);
    this.route.addEventListener("change", this.moved);
    this.listedFor = this.route.place.view;
    void this.listLots();
    if (!this.isForSome) setTimeout(() => this.fly.want(), AFTER_VIEW_MS);
  }

  override disconnectedCallback(): void {
    document.removeEventListener("keydown", this.key);
    this.route.removeEventListener("change", this.moved);
    super.disconnectedCallback();
  }

  protected override createRenderRoot(): HTMLElement {
    return this;
  }

  override willUpdate(changed: PropertyValues<this>): void {
    if (changed.has("route")) this.follow(changed.get("route"));
    this.dress();
    this.wasOpen ||= this.route.place.view === "fly" && !this.isForSome;
    const view = this.model.view();
    if (isFlying(view.heartbeat)) this.survey = false;
    const landed = view.landedAt !== this.landedAt && view.landedAt !== null;
    if (landed && stallCount(view) + view.sections.length > 0 && view.heartbeat?.Killed !== true) this.survey = true; // after a cut its remedy stays in sight
    this.landedAt = view.landedAt;
    document.title = this.titleOf(view);
  }

  /** The page's script gives the route when the element stands already. */
  private follow(before: Route | undefined): void {
    before?.removeEventListener("change", this.moved);
    this.route.addEventListener("change", this.moved);
  }

  private titleOf(view: View): string {
    const { place } = this.route;
    const lot = this.lots?.find(({ id }) => id === place.lot);
    if (place.view !== "fly" || this.isForSome) return say("title-view", { view: say(`view-${place.view}`), lot: lot?.name ?? "Parking Lot Hawk" });
    if (view.welcome?.Desk) return say("title", { state: say("desk-words") });
    return say(view.welcome?.Simulation ? "title-simulation" : "title", { state: stateWords(view).title });
  }

  override render(): TemplateResult {
    return this.isForSome ? this.someLots() : this.whole();
  }

  private someLots(): TemplateResult {
    const { person, role } = this.person ?? { person: "", role: "viewer" };
    const isOfLots = OF_LOTS.includes(this.route.place.view);
    return html`<div class="simline desk" role="region" aria-label=${say("some-lots")}><b>${say("some-lots-mark")}</b> ${person === "" ? nothing : say("some-lots-words", { name: person })} <button class="plain link" @click=${() => this.model.logOut()}>${say("log-out")}</button></div>
      ${this.top(OF_LOTS, null)}
      ${isOfLots ? this.away(role === "operator") : html`<div class="view" role="main"><div class="page"><h1>${say("some-lots-no-drone-title")}</h1><p>${say("some-lots-no-drone")}</p></div></div>`}`;
  }

  private top(views: readonly ViewName[], drone: DroneChip | null): TemplateResult {
    const { model, route } = this;
    return html`<hawk-top .route=${route} .place=${route.place} .views=${views} .lots=${this.lots} .drone=${drone} .spoken=${language()} .speak=${(choice: LanguageChoice) => model.prefer({ language: choice })} .clocked=${() => model.dispatchEvent(new Event("change"))}></hawk-top>`;
  }

  /** A view of lots. */
  private away(mayChange: boolean): TemplateResult {
    const { lots, unlisted, model, isForSome } = this;
    return html`<div class="view" role="main">${this.isLotGone ? html`<p class="card" role="alert">${say("lot-gone")}</p>` : nothing}${this.late.render(this.route, { lots, unlisted, token: null, mayChange, operator: model, isForSome }, language())}</div>`;
  }

  private whole(): TemplateResult {
    const { model } = this;
    const view = model.view();
    const isDesk = view.welcome?.Desk === true;
    const isAway = this.route.place.view !== "fly";
    const isSteering = !isDesk && (!isAway || isSteered(view.heartbeat));
    const isRead = (isSteering || !isAway) && this.fly.want();
    const flies = isSteering && isRead;
    return html`${flies ? html`<nav class="skipping" aria-label=${say("skip")}><a class="skip" href="#bar" @click=${(event: Event) => this.skip(event)}>${say("skip-to-actions")}</a></nav>` : nothing}
      ${this.line(view, isDesk)}
      ${this.top(viewsOf(!this.isAlone, isDesk), isSteering ? null : chipOf(view))}
      ${flies ? html`<hawk-glance .model=${model}></hawk-glance>` : nothing}
      ${flies || (!isAway && isRead) ? html`<div class="strips">
            <hawk-banner .model=${model}></hawk-banner>
            ${isDesk ? nothing : html`<hawk-control .model=${model}></hawk-control><hawk-earlier .model=${model} .isShown=${this.survey && !isAway}></hawk-earlier>`}
          </div>` : nothing}
      ${!isAway && !isRead ? waitingFor(this.fly) : !this.wasOpen || this.fly.state !== "there" ? nothing : isDesk ? this.desk(model, isAway) : this.flight(model, isAway)}
      ${isAway ? this.away(!isViewer(view)) : nothing}
      ${isDesk || this.fly.state !== "there" ? nothing : html`<hawk-kill .model=${model}></hawk-kill>`}
      ${flies ? html`<hawk-bar .model=${model} .classAt=${(place: { North: number; East: number }) => this.map?.classAt(place) ?? 0}></hawk-bar>` : nothing}`;
  }

  private line(view: View, isDesk: boolean): TemplateResult | typeof nothing {
    if (isDesk) return html`<div class="simline desk" role="region" aria-label=${say("desk")}><b>${say("desk-mark")}</b> ${say("desk-words")}</div>`;
    if (view.welcome?.Simulation !== true) return nothing;
    return html`<div class="simline" role="region" aria-label=${say("simulation")}><b>${say("simulation-mark")}</b> ${say("no-real-drone")}</div>`;
  }

  /** Map, video and side column stay while another view is shown: what they hold is there at once again. */
  private flight(model: Operator, isAway: boolean): TemplateResult {
    const main = [isAway ? "away" : "", this.swapped ? "swapped" : "", this.survey || model.plan.open ? "surveyed" : "", model.drawing ? "fencing" : ""].join(" ");
    return html`<main class=${main}>
        <h1 class="unseen">Parking Lot Hawk</h1>
        <hawk-map .model=${model} .isAway=${isAway}></hawk-map>
        ${isAway ? nothing : html`<hawk-video .model=${model}></hawk-video>`}
        <aside class="side">
          ${model.plan.open && !isAway
            ? html`<hawk-plan .model=${model} .placed=${this.map?.planPlaced ?? "own"}></hawk-plan>`
            : this.survey
            ? html`<hawk-survey .model=${model}></hawk-survey>`
            : html`<hawk-counts .model=${model}></hawk-counts>
                <hawk-tabs .model=${model} .chosen=${this.tab}></hawk-tabs>`}
        </aside>
        ${this.sheet()}
      </main>`;
  }

  /** Without a drone: lots and plans alone. */
  private desk(model: Operator, isAway: boolean): TemplateResult {
    return html`<main class="surveyed ${isAway ? "away" : ""}">
        <h1 class="unseen">Parking Lot Hawk</h1>
        <hawk-map .model=${model} .isAway=${isAway}></hawk-map>
        <aside class="side">
          ${model.plan.open && !isAway ? html`<hawk-plan .model=${model} .placed=${this.map?.planPlaced ?? "own"}></hawk-plan>` : html`<section class="card scroll"><hawk-lots .model=${model}></hawk-lots><hawk-settings .model=${model}></hawk-settings></section>`}
        </aside>
      </main>`;
  }

  /** A flight may have made a lot since another view was shown; steps within a view ask for nothing. */
  private readonly moved = (): void => {
    const { view } = this.route.place;
    const isUnknown = this.lots?.every(({ id }) => id !== this.route.place.lot) ?? false;
    if (view !== "fly" && (view !== this.listedFor || isUnknown)) void this.listLots();
    this.listedFor = view;
    this.isLotGone = false;
    this.requestUpdate();
  };

  /** The lots to choose from; the first one where the address names none. */
  private async listLots(): Promise<void> {
    try {
      this.list(await readLots());
    } catch (error) {
      const { message, status, isForNow } = error as Refused;
      this.isAlone = status === NOT_THERE;
      if (this.isAlone) this.list([]);
      this.unlisted = this.isAlone ? "" : message || say("archive-unanswered");
      if (isForNow) setTimeout(() => void (this.isConnected && this.lots === null && this.listLots()), AGAIN_MS);
    }
  }

  /** An address of a lot that is not there says so: another lot has other figures. */
  private list(lots: LotPlace[]): void {
    this.lots = lots;
    this.unlisted = "";
    const { lot } = this.route.place;
    if (lots.some(({ id }) => id === lot)) return;
    const [first] = lots;
    if (!first) return;
    this.route.settle({ lot: first.id });
    this.isLotGone = lot !== "";
  }

  private sheet(): TemplateResult | typeof nothing {
    if (this.panel === "none") return nothing;
    return html`<div class="sheet" role="dialog" aria-label=${say(PANEL_NAMES[this.panel])}>
      <button class="plain close" aria-label=${say("close")} @click=${() => (this.panel = "none")}>${icon("close")}</button>
      ${this.inSheet(this.panel)}
    </div>`;
  }

  private inSheet(panel: Exclude<Panel, "none">): TemplateResult {
    if (panel === "menu") return html`<div class="views">${viewLinks(viewsOf(!this.isAlone, this.model.view().welcome?.Desk === true), this.route)}</div><hawk-tabs .model=${this.model} .chosen=${this.tab}></hawk-tabs>`;
    if (panel === "keys") return html`<hawk-keys .model=${this.model}></hawk-keys>`;
    return html`<hawk-more .model=${this.model} @click=${() => this.leaveActions()}></hawk-more>`;
  }

  /** An action was chosen: its list goes, unless what it opened has taken its place. */
  private leaveActions(): void {
    if (this.panel === "actions") this.panel = "none";
  }

  private readonly key = (event: KeyboardEvent): void => {
    undoByKey(event, this.model);
    leaveByEscape(event, this.model, () => (this.panel = "none"));
    if (!this.isForSome && this.model.flight.welcome?.Desk !== true) actOnKey(event, this.model, (action) => this.open(action));
  };

  private skip(event: Event): void {
    event.preventDefault();
    const buttons = [...this.querySelectorAll<HTMLElement>("hawk-bar .primary:not(:disabled), hawk-bar .ask, hawk-bar button:not(:disabled)")];
    const seen = buttons.filter((each) => each.offsetParent !== null);
    (seen.find((each) => each.matches(".primary, .ask")) ?? seen[0] ?? this.querySelector<HTMLElement>("#bar"))?.focus();
  }

  private open(what: string): void {
    if (this.route.place.view !== "fly" && what !== "close") this.route.go({ view: "fly" });
    if (what === "swap") this.swapped = !this.swapped;
    else if (what === "survey") this.survey = true;
    else if (what === "close") this.survey = false;
    else if (what === "map") this.showMap();
    else if (what === "fence" || what === "outline") this.draw(what);
    else if (what === "settings" || what === "checks") this.openTab(what === "settings" ? "Settings" : "Checks");
    else if (what === "menu" || what === "actions" || what === "keys") this.panel = this.panel === what ? "none" : what;
  }

  /** What covers the map goes. */
  private showMap(): void {
    this.panel = "none";
    this.swapped = false;
  }

  /** Fence and outline are drawn on the map: what covers it or has made it small goes. */
  private draw(what: "fence" | "outline"): void {
    this.panel = "none";
    this.survey = false;
    this.swapped = false;
    if (what === "fence") this.model.editFence();
    else this.model.editOutline();
  }

  private openTab(tab: TabName): void {
    this.survey = false;
    this.tab = "";
    const side = this.querySelector<HTMLElement>(".side .tablist");
    this.panel = side?.offsetParent == null ? "menu" : "none";
    void this.showTab(tab);
  }

  /** Chooses the tab once the panels stand, and brings what failed in sight. */
  private async showTab(tab: TabName): Promise<void> {
    await this.updateComplete;
    this.tab = tab;
    await this.updateComplete;
    await new Promise((drawn) => requestAnimationFrame(drawn)); // the tab's own content
    const where = this.querySelector(this.panel === "menu" ? ".sheet" : ".side");
    const failed = tab === "Checks" ? where?.querySelector<HTMLElement>(".fix") : null;
    failed?.scrollIntoView({ block: "nearest" });
    failed?.querySelector<HTMLElement>("button:not(:disabled)")?.focus({ preventScroll: true });
  }

  /** Puts theme and hand where the style sheet looks for them. */
  private dress(): void {
    const { theme, leftHanded } = this.model.preferences;
    const shown = theme === "auto" ? (this.dark.matches ? "dark" : "light") : theme;
    document.documentElement.dataset.theme = shown;
    document.documentElement.classList.toggle("left", leftHanded);
  }
}

/** What the bar says of the drone where the line of its state is not shown. */
function chipOf(view: View): DroneChip {
  if (view.welcome?.Desk) return { title: say("no-drone"), detail: say("desk"), tone: "idle" };
  const { title, short, tone } = stateWords(view);
  return { title, detail: typeof short === "string" ? short : "", tone };
}
