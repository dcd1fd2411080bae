import { html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { LocalPlane } from "../fence/plane.ts";
import type { LotPlace } from "../link/lot-places.ts";
import { showScale } from "../map/geometry.ts";
import { LotsMap } from "../map/lots-map.ts";
import { LOT_ORDERS, type LotOrder, type Place } from "../route/place.ts";
import { icon } from "../ui/icons.ts";
import { timeOnClock } from "../words/clock.ts";
import * as format from "../words/format.ts";
import { number, say } from "../words/say.ts";
import { droneOf, firstLots, lotsFound, marksOf } from "./all-lots.ts";

const ZOOM = 1.6;
/** Number of lots that are listed first: a person searches among more. */
const FIRST = 100;
/** Number of lots of one report: `hawk.report.options.MOST_LOTS`. */
const MOST_REPORTED = 50;

/** Every lot of the store, on one map and in one table: how full each was, and when it was seen last. */
@customElement("archive-all-lots")
export class AllLotsView extends LitElement {
  @property({ attribute: false }) lots: readonly LotPlace[] = [];
  /** Redraws the view in another language. */
  @property() spoken = "";
  /** Another one where the theme is another one. */
  @property() theme = "";
  /** What the address says of search and order; it follows the person, and brings both back. */
  @property({ attribute: false }) place: Pick<Place, "search" | "order"> = { search: "", order: "" };
  @state() private wanted = "";
  @state() private order: LotOrder = "name";
  @state() private most = FIRST;
  /** Lots that the map shows; null where the table has others, too. */
  @state() private inSight: ReadonlySet<string> | null = null;
  /** Length of the scale in words. */
  @state() private metres = "";
  @query(".ol") private holder!: HTMLElement | null;
  private map: LotsMap | null = null;
  private found: readonly LotPlace[] = [];

  protected override createRenderRoot(): HTMLElement {
    return this;
  }

  override disconnectedCallback(): void {
    this.map?.dispose();
    this.map = null;
    super.disconnectedCallback();
  }

  override willUpdate(changed: PropertyValues): void {
    if (changed.has("place")) {
      this.wanted = this.place.search;
      this.order = this.place.order || "name";
    }
    if (["lots", "wanted"].some((name) => changed.has(name))) this.found = lotsFound(this.lots, this.wanted);
  }

  override render(): TemplateResult {
    const { found } = this;
    const wanted = this.shown;
    const listed = firstLots(wanted, this.order, this.most);
    return html`<section class="map lots" aria-label=${say("map")}>
        <div class="ol" tabindex="0" role="application" aria-label=${say("all-lots-map", { lots: found.length })}></div>
        <div class="tools"><div class="group">${this.tool(say("zoom-in"), "plus", () => this.map?.zoom(ZOOM))}${this.tool(say("zoom-out"), "minus", () => this.map?.zoom(1 / ZOOM))}</div>
          <div class="group">${this.tool(say("all-lots-whole"), "whole", () => this.map?.showAll())}</div></div>
        <div class="mapfoot"><span class="scale"></span><span>${this.metres}</span></div>
      </section>
      <div class="card">
        <div class="fields">
          <label>${say("all-lots-search")}<input type="search" .value=${this.wanted} @input=${(event: Event) => this.find((event.target as HTMLInputElement).value, this.order)} /></label>
          <label>${say("all-lots-order")}<select @change=${(event: Event) => this.find(this.wanted, (event.target as HTMLSelectElement).value as LotOrder)}>${LOT_ORDERS.map((each) => html`<option value=${each} ?selected=${each === this.order}>${say(`all-lots-by-${each}`)}</option>`)}</select></label>
          <label class="toggle"><input type="checkbox" .checked=${this.inSight !== null} @change=${(event: Event) => this.look((event.target as HTMLInputElement).checked)} />${say("all-lots-in-sight")}</label>
          <button ?disabled=${wanted.length === 0 || wanted.length > MOST_REPORTED} @click=${() => this.report()}>${icon("download")}${say("all-lots-report", { lots: wanted.length })}</button>
          ${wanted.length > MOST_REPORTED ? html`<span class="sub">${say("all-lots-report-most", { lots: MOST_REPORTED })}</span>` : nothing}
          <span class="sub" role="status">${say("all-lots-found", { lots: wanted.length, all: this.lots.length })}</span>
        </div>
        ${listed.length === 0 ? nothing : this.table(listed)}
        ${wanted.length > listed.length ? html`<button @click=${() => (this.most += FIRST)}>${say("all-lots-more", { lots: Math.min(FIRST, wanted.length - listed.length) })}</button>` : nothing}
      </div>`;
  }

  override updated(changed: PropertyValues): void {
    if (this.holder === null) return;
    const isNew = this.map === null;
    this.map ??= new LotsMap(this.holder, (lot) => this.open(lot), () => this.moved());
    if (changed.has("theme") && changed.get("theme") !== undefined) this.map.recolour(this.holder);
    if (isNew || ["lots", "wanted", "spoken"].some((name) => changed.has(name))) this.mark(this.map);
    this.moved();
  }

  private mark(map: LotsMap): void {
    const [first] = this.lots;
    if (!first) return;
    const [Latitude, Longitude] = first.place;
    const words = (lot: LotPlace): string => (lot.last_survey === null ? say("all-lots-never") : say("all-lots-free", { free: lot.last_survey.free }));
    map.show(marksOf(this.found, new LocalPlane({ Latitude, Longitude }), words));
    this.dataset.drawn = "all"; // by the browser's next picture
  }

  private tool(label: string, name: "plus" | "minus" | "whole", run: () => void): TemplateResult {
    return html`<button aria-label=${label} title=${label} @click=${run}>${icon(name)}</button>`;
  }

  private table(lots: readonly LotPlace[]): TemplateResult {
    const heads = ["archive-lot", "archive-free", "archive-taken", "archive-unknown", "all-lots-stalls", "all-lots-surveys", "all-lots-seen", "all-lots-drone", "all-lots-due"] as const;
    const cell = (column: (typeof heads)[number], value: string): TemplateResult => html`<td data-column=${say(column)}>${value}</td>`;
    return html`<div class="wide" tabindex="0" role="region" aria-label=${say("all-lots")}><table class="cards">
      <thead><tr>${heads.map((key) => html`<th scope="col">${say(key)}</th>`)}</tr></thead>
      <tbody>${lots.map((lot) => {
        const { last_survey: last } = lot;
        const seen = last === null ? say("all-lots-never") : timeOnClock(last.ended, lot.time_zone, { day: "numeric", month: "short", year: "numeric" });
        const due = lot.due === null ? "–" : timeOnClock(lot.due, lot.time_zone, { weekday: "short", day: "numeric", month: "short", hour: "2-digit", minute: "2-digit" });
        return html`<tr><th scope="row"><button class="plain link" @click=${() => this.open(lot.id)}>${lot.name}</button></th>
          ${cell("archive-free", last ? number(last.free) : "–")}${cell("archive-taken", last ? number(last.taken) : "–")}${cell("archive-unknown", last ? number(last.unknown) : "–")}
          ${cell("all-lots-stalls", number(lot.stalls))}${cell("all-lots-surveys", number(lot.survey_count))}${cell("all-lots-seen", seen)}
          ${cell("all-lots-drone", droneOf(lot) || "–")}${cell("all-lots-due", lot.due !== null && Date.parse(lot.due) <= Date.now() ? say("all-lots-due-since", { when: due }) : due)}</tr>`;
      })}</tbody>
    </table></div>`;
  }

  private moved(): void {
    if (this.inSight !== null) this.look(true);
    if (this.map) this.metres = format.scaleLength(showScale(this, this.map.resolution), "metres");
  }

  /** Lists those lots alone that the map shows, or all that were found. */
  private look(isInSight: boolean): void {
    const found = isInSight && this.map ? this.map.inSight() : null;
    const idsOf = (lots: ReadonlySet<string> | null): string => (lots === null ? "" : `of ${[...lots].join()}`);
    if (idsOf(found) !== idsOf(this.inSight)) this.inSight = found;
  }

  /** The lots that were found, those alone that the map shows where a person wants these. */
  private get shown(): readonly LotPlace[] {
    const { inSight } = this;
    return inSight === null ? this.found : this.found.filter(({ id }) => inSight.has(id));
  }

  private find(wanted: string, order: LotOrder): void {
    [this.wanted, this.order] = [wanted, order];
    this.go({ search: wanted, order: order === "name" ? "" : order });
  }

  /** Opens the report over the lots of the table, in their order. */
  private report(): void {
    const lots = firstLots(this.shown, this.order, MOST_REPORTED).map(({ id }) => id);
    this.go({ show: "document", lots });
  }

  /** Opens the newest survey of a lot. */
  private open(lot: string): void {
    this.go({ lot, survey: "", stall: "", section: "", show: "" });
  }

  private go(detail: Partial<Place>): void {
    this.dispatchEvent(new CustomEvent("archive-go", { detail, bubbles: true }));
  }
}
