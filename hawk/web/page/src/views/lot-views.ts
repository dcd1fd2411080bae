import { html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import type { LotPlace } from "../link/lot-places.ts";
import { isOfLots, type Place } from "../route/place.ts";
import type { Route } from "../route/route.ts";
import type { Operator } from "../state/operator.ts";
import { RedrawOnChange } from "../ui/redraw-on-change.ts";
import { say } from "../words/say.ts";
import { droneOf } from "./all-lots.ts";
import { LotSource } from "./link.ts";
import { wordsOf } from "./view.ts";

/** What the views show: the person's lots, or the lot of a link. */
export interface LotAccess {
  /** Null until they are read. */
  lots: readonly LotPlace[] | null;
  /** Why they could not be read. */
  unlisted: string;
  /** Token of a shared link; null with a login. */
  token: string | null;
  mayChange: boolean;
  /** Whose plan editor is opened here; null for a link. */
  operator: Operator | null;
  /** The role is for some lots: recordings and arrivals are of all. */
  isForSome: boolean;
}

/** What the page says, with what undoes it and its name. */
interface Notice {
  text: string;
  undo?: () => Promise<unknown>;
  name?: string;
}

const PARTS = ["all", "", "stalls", "links", "arrivals"] as const;
const NAMES = { all: "all-lots", "": "archive-surveys", stalls: "archive-stalls", links: "archive-links", arrivals: "arrivals" } as const;

/** The views of lots over time: surveys by date, compared, asked about, stall by stall, on paper; and the recordings. Each is there with its part of the page. */
@customElement("hawk-views")
export class LotViews extends LitElement {
  @property({ attribute: false }) route!: Route;
  @property({ attribute: false }) access!: LotAccess;
  /** Language of the page. */
  @property() spoken = "";
  /** Rises when something was changed: what was read is read again. */
  @state() private revision = 0;
  @state() private notice: Notice | null = null;
  private readonly kept = new Map<string, LotSource>();

  constructor() {
    super();
    new RedrawOnChange(this, () => this.route);
  }

  protected override createRenderRoot(): HTMLElement {
    return this;
  }

  /** The parts have nothing else that changes with the language. */
  override willUpdate(changed: PropertyValues<this>): void {
    if (changed.get("spoken")) this.revision += 1;
  }

  override render(): TemplateResult {
    const { place } = this.route;
    return html`<div class="page" @archive-go=${(event: CustomEvent<Partial<Place>>) => this.route.go(event.detail)}
        @archive-changed=${() => this.renew()}
        @archive-said=${(event: CustomEvent<Notice>) => (this.notice = event.detail)}>
        <h1 class="unseen">${say(`view-${place.view}`)}</h1>
        ${this.route.unread.length === 0 ? nothing : html`<p class="card" role="alert">${say("address-unread", { parts: this.route.unread.join(", ") })}</p>`}
        ${place.view === "lots" ? this.head(place) : nothing} ${this.content(place)}
      </div>
      <div class="notice no-print" role="status">${this.notice === null ? nothing : this.saying(this.notice)}</div>`;
  }

  /** Parts of the view, and the period that it is about. */
  private head(place: Place): TemplateResult {
    const day = (end: "from" | "to"): TemplateResult => html`<label>${say(`archive-${end}`)}<input type="date" .value=${place[end]} @change=${(event: Event) => this.route.go({ [end]: (event.target as HTMLInputElement).value })} /></label>`;
    return html`<div class="head no-print">${this.parts(place)}
      ${place.show === "stalls" || isOfLots(place) ? html`<div class="fields">${day("from")} ${day("to")}</div>` : nothing}</div>`;
  }

  private parts(place: Place): TemplateResult {
    const { lots, token, mayChange, isForSome } = this.access;
    const hidden = { all: (lots?.length ?? 0) < 2, "": false, stalls: false, links: token !== null, arrivals: token !== null || isForSome || !mayChange || !lots?.some((lot) => droneOf(lot) !== "") };
    const parts = PARTS.filter((part) => !hidden[part]);
    return html`<nav aria-label=${say("archive-view-parts")}>${parts.map(
      (part) => html`<button aria-current=${part === place.show ? "page" : "false"} @click=${() => this.route.go({ show: part })}>${say(NAMES[part])}</button>`,
    )}</nav>`;
  }

  private content(place: Place): TemplateResult | typeof nothing {
    const { revision } = this;
    const { mayChange, token } = this.access;
    const isShared = token !== null;
    if (place.view === "recordings") return isShared ? nothing : html`<archive-recordings .place=${place} .revision=${revision} .mayChange=${mayChange} .zone=${this.access.lots?.find(({ id }) => id === place.lot)?.time_zone} .sourceOf=${this.sourceOf}></archive-recordings>`;
    if (!isShared && place.lot === "") return this.withoutLot();
    if (!isShared && place.view === "lots" && place.show === "all") return html`<archive-all-lots .lots=${this.access.lots ?? []} .place=${place} .spoken=${this.spoken} .theme=${document.documentElement.dataset.theme ?? ""}></archive-all-lots>`;
    if (!isShared && place.view === "lots" && place.show === "arrivals" && !this.access.isForSome) return html`<archive-arrivals .lots=${this.access.lots ?? []} .revision=${revision}></archive-arrivals>`;
    const source = this.sourceOf(place.lot);
    if (place.view === "compare") return html`<archive-compare .source=${source} .place=${place} .revision=${revision}></archive-compare>`;
    if (place.show === "document") return html`<archive-document .source=${source} .place=${place} .revision=${revision}></archive-document>`;
    if (place.view === "report") return html`<archive-ask .source=${source} .place=${place} .revision=${revision}></archive-ask>`;
    if (place.show === "stalls") return html`<archive-stalls .source=${source} .place=${place} .revision=${revision}></archive-stalls>`;
    if (place.show === "links" && !isShared) return html`<archive-links .source=${source} .place=${place} .revision=${revision} .mayChange=${mayChange}></archive-links>`;
    return html`<archive-surveys .source=${source} .place=${place} .revision=${revision} .mayChange=${mayChange && !isShared} .operator=${this.access.operator}></archive-surveys>`;
  }

  private withoutLot(): TemplateResult {
    const { lots, unlisted } = this.access;
    if (unlisted !== "") return html`<p role="alert">${unlisted}</p>`;
    return html`<p>${say(lots === null ? "archive-asking" : "archive-no-lot")}</p>`;
  }

  /** The same for every view of a lot. */
  private readonly sourceOf = (lot: string): LotSource => {
    const { token, isForSome } = this.access;
    const base = token === null ? `lots/${lot}` : `shared/${token}`;
    const source = this.kept.get(base) ?? new LotSource(base, !isForSome);
    this.kept.set(base, source);
    return source;
  };

  private renew(): void {
    for (const source of this.kept.values()) source.forget();
    this.revision += 1;
  }

  private saying({ text, undo, name }: Notice): TemplateResult {
    return html`<span>${text}</span>
      ${undo === undefined ? nothing : html`<button @click=${() => void this.undo(undo)}>${name ?? say("archive-undo")}</button>`}
      <button @click=${() => (this.notice = null)}>${say("close")}</button>`;
  }

  private async undo(work: () => Promise<unknown>): Promise<void> {
    try {
      await work();
      this.notice = null;
    } catch (error) {
      this.notice = { text: wordsOf(error) };
    }
    this.renew();
  }
}
