import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import type { ListedLot } from "../api.ts";
import { say } from "../words/say.ts";
import "./compare-view.ts";
import "./figures-view.ts";
import { LotSource } from "./link.ts";
import "./links-view.ts";
import { hashOf, type Place, placeOf, type ViewName } from "./place.ts";
import "./recordings-view.ts";
import "./report-view.ts";
import "./stalls-view.ts";
import "./surveys-view.ts";
import { wordsOf } from "./view.ts";

type NamedLot = Pick<ListedLot, "id" | "name">;

/** What the page needs of its surroundings. */
export interface Outside {
  /** Everything behind the "#" of the address. */
  hash: () => string;
  setHash: (hash: string) => void;
  /** Token of a shared link; null with a login. */
  token: string | null;
  lots: () => Promise<NamedLot[]>;
  isOperator: () => Promise<boolean>;
}

const OF_LINKS: readonly ViewName[] = ["surveys", "compare", "figures", "stalls", "report"];
const OF_OWN: readonly ViewName[] = [...OF_LINKS, "links", "recordings"];

/** Lots over time: surveys by date, compared, in figures, stall by stall, on paper. */
@customElement("hawk-archive")
export class Archive extends LitElement {
  @property({ attribute: false }) outside!: Outside;
  @state() private place: Place = placeOf("");
  @state() private lots: NamedLot[] | null = null;
  @state() private problem = "";
  @state() private mayChange = false;
  @state() private revision = 0;
  private readonly kept = new Map<string, LotSource>();
  @state() private notice: { text: string; undo?: () => Promise<unknown> } | null = null;

  protected override createRenderRoot(): HTMLElement {
    return this;
  }

  /** Begins: reads the address, the lots and the role. */
  async begin(): Promise<void> {
    this.read();
    if (this.outside.token !== null) return;
    this.mayChange = await this.outside.isOperator();
    try {
      this.lots = await this.outside.lots();
    } catch (error) {
      this.problem = wordsOf(error);
    }
    const [first] = this.lots ?? [];
    if (first && !this.lots?.some(({ id }) => id === this.place.lot)) this.go({ lot: first.id, survey: "", before: "", after: "", stall: "" });
  }

  /** Reads the address again: somebody went back, or followed a link. */
  read(): void {
    this.place = placeOf(this.outside.token === null ? this.outside.hash() : this.outside.hash().replace(/^#[\w-]+/, ""));
  }

  /** Speaks and draws again: in another language, say. */
  drawAgain(): void {
    this.revision += 1;
  }

  private go(change: Partial<Place>): void {
    this.place = { ...this.place, ...change };
    const { token } = this.outside;
    const hash = hashOf(this.place);
    this.outside.setHash(token === null ? hash : `#${token}${hash.replace("#", "&")}`);
  }

  override render(): TemplateResult {
    const isShared = this.outside.token !== null;
    return html`<header>
        ${isShared ? nothing : html`<a class="button no-print" href="./">${say("archive-to-map")}</a>`}
        <h1>${say("archive-title")}</h1>
        ${this.fields(isShared)}
      </header>
      <nav class="no-print" aria-label=${say("archive-title")}>${(isShared ? OF_LINKS : OF_OWN).map(
        (view) => html`<button class=${view === this.place.view ? "on" : ""} aria-current=${view === this.place.view ? "page" : "false"} @click=${() => this.go({ view })}>${say(`archive-${view}`)}</button>`,
      )}</nav>
      <main @archive-go=${(event: CustomEvent<Partial<Place>>) => this.go(event.detail)}
        @archive-changed=${() => this.renew()}
        @archive-said=${(event: CustomEvent<{ text: string; undo?: () => Promise<unknown> }>) => (this.notice = event.detail)}>
        ${this.problem === "" ? nothing : html`<p role="alert">${this.problem}</p>`} ${this.content(isShared)}
      </main>
      <div class="notice no-print" role="status">${this.notice === null ? nothing : this.saying(this.notice)}</div>`;
  }

  private fields(isShared: boolean): TemplateResult {
    const day = (end: "from" | "to"): TemplateResult => html`<label>${say(`archive-${end}`)}<input type="date" .value=${this.place[end]} @change=${(event: Event) => this.go({ [end]: (event.target as HTMLInputElement).value })} /></label>`;
    return html`<div class="fields">
      ${isShared ? nothing : html`<label>${say("archive-lot")}<select @change=${(event: Event) => this.go({ lot: (event.target as HTMLSelectElement).value, survey: "", before: "", after: "", stall: "" })}>
        ${(this.lots ?? []).map(({ id, name }) => html`<option value=${id} ?selected=${id === this.place.lot}>${name}</option>`)}
      </select></label>`}
      ${day("from")} ${day("to")}
    </div>`;
  }

  private content(isShared: boolean): TemplateResult | typeof nothing {
    const { place, revision, mayChange } = this;
    if (!isShared && place.view === "recordings") return html`<archive-recordings .place=${place} .revision=${revision} .mayChange=${mayChange}></archive-recordings>`;
    if (!isShared && place.lot === "") return this.lots === null ? nothing : html`<p>${say("archive-no-lot")}</p>`;
    const source = this.sourceOf(isShared, place.lot);
    const shared = { source, place, revision, mayChange: mayChange && !isShared };
    switch (place.view) {
      case "compare":
        return html`<archive-compare .source=${source} .place=${place} .revision=${revision}></archive-compare>`;
      case "figures":
        return html`<archive-figures .source=${source} .place=${place} .revision=${revision}></archive-figures>`;
      case "stalls":
        return html`<archive-stalls .source=${source} .place=${place} .revision=${revision}></archive-stalls>`;
      case "report":
        return this.reports(isShared);
      case "links":
        return isShared ? nothing : html`<archive-links .place=${place} .revision=${revision} .mayChange=${mayChange}></archive-links>`;
      default:
        return html`<archive-surveys .source=${shared.source} .place=${place} .revision=${revision} .mayChange=${shared.mayChange}></archive-surveys>`;
    }
  }

  /** The report of the lot, or of every lot, a page each. */
  private reports(isShared: boolean): TemplateResult {
    const { place, revision, lots } = this;
    const isChoice = !isShared && (lots ?? []).length > 1;
    const ids = isChoice && place.every ? (lots ?? []).map(({ id }) => id) : [place.lot];
    return html`<div class="fields no-print">
        <button class="primary" @click=${() => print()}>${say("archive-print")}</button>
        ${isChoice ? html`<label class="tick"><input type="checkbox" .checked=${place.every !== ""} @change=${(event: Event) => this.go({ every: (event.target as HTMLInputElement).checked ? "1" : "" })} />${say("archive-every-lot")}</label>` : nothing}
      </div>${repeat(ids, (id) => id, (id) => html`<archive-report .source=${this.sourceOf(isShared, id)} .place=${id === place.lot ? place : { ...place, lot: id, survey: "" }} .revision=${revision}></archive-report>`)}`;
  }

  /** The same for every view of a lot. */
  private sourceOf(isShared: boolean, lot: string): LotSource {
    const base = isShared ? `shared/${this.outside.token ?? ""}` : `lots/${lot}`;
    const source = this.kept.get(base) ?? new LotSource(base);
    this.kept.set(base, source);
    return source;
  }

  private renew(): void {
    for (const source of this.kept.values()) source.forget();
    this.revision += 1;
  }

  private saying({ text, undo }: { text: string; undo?: () => Promise<unknown> }): TemplateResult {
    return html`<span>${text}</span>
      ${undo === undefined ? nothing : html`<button @click=${() => void this.undo(undo)}>${say("archive-undo")}</button>`}
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
