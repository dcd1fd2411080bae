import { html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { EMPTY_SCENE, type Scene } from "../map/flight-scene.ts";
import { cardPlace, corners, type Extent, extentOf, showScale, toCoordinate } from "../map/geometry.ts";
import type { Arrived } from "../map/ground-tiles.ts";
import type { Stall } from "../state/map-store.ts";
import { cssVars } from "../ui/css-vars.ts";
import { icon, type IconName } from "../ui/icons.ts";
import { swatch } from "../ui/swatch.ts";
import * as format from "../words/format.ts";
import type { ListedSection, SectionChange } from "../api.ts";
import type { LocalPlane } from "../fence/plane.ts";
import { middleOf, type SectionShape } from "../map/sections-layer.ts";
import type { Point } from "../protocol.ts";
import { capital, language, number, say } from "../words/say.ts";
import { likelihood } from "../words/stall.ts";
import type { Operator } from "../state/operator.ts";
import { ALL_LAYERS } from "../state/preferences.ts";
import { PlanOnMap } from "../map/plan-on-map.ts";
import "../ui/plan-tools.ts";
import { RedrawOnChange } from "../ui/redraw-on-change.ts";
import { MapPane } from "./map-pane.ts";
import { sectionCard, shapesOf } from "./sections.ts";
import type { SurveyOnMap } from "./survey-source.ts";
import { swipeHandle } from "./swipe.ts";

const ZOOM = 1.6;
const NOBODY = new EventTarget();
const NONE: readonly SectionShape[] = [];
/** Height of the cards of two surveys, with the room about them. */
const CARDS_PX = 88;
const CARD = { width: 120, height: 192 };
/** A side whose share of the map is less has no room for its card. */
const LEAST_SHARE = 0.12;

/** How the later of two surveys lies on the map: over the earlier one right of a line, over all of it, or beside it. */
export type By = "swipe" | "fade" | "side";

/** Date and counts of a survey, as its card on the map says them. */
export interface SideCard {
  title: string;
  detail: string;
}

/** One stored survey on the map of the flight, or two: pictures, stalls with states and labels. */
@customElement("hawk-survey-map")
export class SurveyMap extends LitElement {
  @property({ attribute: false }) source: SurveyOnMap | null = null;
  /** The later survey; undefined: one survey is shown. */
  @property({ attribute: false }) later: SurveyOnMap | null | undefined = undefined;
  @property() by: By = "swipe";
  /** Share of the later survey, 0 to 1. */
  @property({ attribute: false }) at = 0.5;
  /** What the cards of two surveys say. */
  @property({ attribute: false }) cards: readonly SideCard[] = [];
  /** Ids of the stalls that are framed. */
  @property({ attribute: false }) marked: ReadonlySet<string> = new Set();
  /** Ids of stalls that the survey before has under another one. */
  @property({ attribute: false }) earlier: ReadonlyMap<string, string> = new Map();
  /** Id of the stall that was chosen. */
  @property() chosen = "";
  /** Sections with what the survey counted in them, and the id of the one that was chosen. */
  @property({ attribute: false }) sections: readonly ListedSection[] = [];
  @property() section = "";
  /** How the sections changed between two surveys; null: what one survey counted is shown. */
  @property({ attribute: false }) changes: readonly SectionChange[] | null = null;
  /** What lies over the survey: the drone, say. */
  @property({ attribute: false }) scene: Scene = EMPTY_SCENE;
  /** What is shown first, and is the whole; null: all stalls. */
  @property({ attribute: false }) extent: Extent | null = null;
  /** What a screen reader says of the map. */
  @property() label = "";
  /** Another one where the theme is another one. */
  @property() theme = "";
  /** What is known of the chosen stall, in place of how sure its state is. */
  @property() known = "";
  /** What the colours mean, in place of the states. */
  @property({ attribute: false }) legend: TemplateResult | null = null;
  /** Whose plan editor lies over the map while it `isPlanning`. */
  @property({ attribute: false }) operator: Operator | null = null;
  @property({ attribute: false }) isPlanning = false;
  @state() private metres = "";
  private plan: PlanOnMap | null = null;
  private shapes: readonly SectionShape[] = [];
  private drawnSections: readonly ListedSection[] = [];
  private drawnChanges: readonly SectionChange[] | null = null;
  private drawnPlane: LocalPlane | undefined;
  private spoken = "";
  /** The section that was brought into view last. */
  private brought = "";
  private panes: MapPane[] = [];

  constructor() {
    super();
    new RedrawOnChange(this, () => (this.isPlanning ? this.operator : null) ?? NOBODY);
  }

  protected override createRenderRoot(): HTMLElement {
    return this;
  }

  override connectedCallback(): void {
    super.connectedCallback();
    this.requestUpdate();
  }

  override disconnectedCallback(): void {
    this.plan?.update(false);
    this.plan = null;
    for (const { map } of this.panes) map.dispose();
    this.panes = [];
    super.disconnectedCallback();
  }

  private get isPair(): boolean {
    return this.later !== undefined;
  }

  override render(): TemplateResult {
    const shown = this.panes.map((pane, index) => pane.stall(this.idIn(index)));
    return html`<section class="map ${this.isPair ? `pair by-${this.by}` : ""} ${this.isPlanning ? "planning" : ""} ${this.isPlanning && this.operator?.plan.drawing.tool !== "choose" ? "picking" : ""}" aria-label=${say("map")} @keydown=${this.planKey} ${cssVars({ "--at": String(this.at) })}>
      <div class="ol" tabindex="0" role="application" aria-label=${this.isPair ? `${say("archive-before")}: ${this.cardWords(0)}` : this.label}></div>
      ${this.isPair ? html`<div class="ol over" tabindex=${this.by === "side" ? "0" : "-1"} role="application" aria-label=${`${say("archive-after")}: ${this.cardWords(1)}`}></div>${this.pairParts()}` : nothing}
      ${this.isPlanning ? html`<hawk-plan-tools .model=${this.operator}></hawk-plan-tools>` : nothing}
      <div class="tools">
        <div class="group">${this.tool(say("zoom-in"), "plus", () => this.panes[0]?.map.zoom(ZOOM))}${this.tool(say("zoom-out"), "minus", () => this.panes[0]?.map.zoom(1 / ZOOM))}</div>
        <div class="group">${this.tool(say("whole-lot"), "whole", () => this.showWhole())}</div>
      </div>
      <div class="mapfoot"><span class="scale"></span><span>${this.metres}</span>${this.isPlanning ? nothing : this.legend ?? (["free", "taken", "unknown"] as const).map((each) => html`${swatch(each)}<span>${say(each)}</span>`)}</div>
      ${shown.some((stall) => stall !== undefined) ? this.card(shown) : nothing}
      ${this.chosenSection ? sectionCard(this.chosenSection, this.changes?.find(({ id }) => id === this.section), () => this.chooseSection("")) : nothing}
    </section>`;
  }

  /** The line between both surveys, their cards, and the choice of how they are compared. */
  private pairParts(): TemplateResult {
    const moved = (at: number, isLast: boolean): void => {
      this.at = at;
      if (isLast) this.dispatchEvent(new CustomEvent<number>("at", { detail: at, bubbles: true }));
    };
    const isShown = [this.by !== "swipe" || this.at > LEAST_SHARE, this.by !== "swipe" || this.at < 1 - LEAST_SHARE];
    const values = { share: number(100 * (this.by === "swipe" ? 1 - this.at : this.at)), before: this.cards[0]?.title ?? "", after: this.cards[1]?.title ?? "" };
    return html`${this.cards.map(({ title, detail }, index) => html`<div class="date ${index === 0 ? "first" : "second"}" ?hidden=${!isShown[index]}><b>${title}</b><span>${detail}</span></div>`)}
      ${this.by === "side" ? nothing : swipeHandle({ at: this.at, label: say(`compare-${this.by}-handle`), words: say(`compare-${this.by}-at`, values), moved })}
      <div class="modes" role="group" aria-label=${say("compare-modes")}>${(["swipe", "fade", "side"] as const).map(
        (by) => html`<button aria-pressed=${by === this.by} @click=${() => this.dispatchEvent(new CustomEvent<By>("by", { detail: by, bubbles: true }))}>${say(`compare-${by}`)}</button>`,
      )}</div>`;
  }

  private get chosenSection(): ListedSection | undefined {
    return this.isPlanning ? undefined : this.sections.find(({ id }) => id === this.section && (this.changes?.some((each) => each.id === id) ?? true));
  }

  private cardWords(index: number): string {
    const card = this.cards[index];
    return card ? `${card.title}, ${card.detail}` : "";
  }

  private tool(label: string, name: IconName, run: () => void): TemplateResult {
    return html`<button aria-label=${label} title=${label} @click=${run}>${icon(name)}</button>`;
  }

  private card(shown: readonly (Stall | undefined)[]): TemplateResult {
    const label = shown.findLast((stall) => stall !== undefined)?.label ?? "";
    return html`<div class="pop stall ${this.isPair ? "two" : ""}" data-stall>
      <button class="plain close" aria-label=${say("close")} @click=${() => this.choose("")}>${icon("close")}</button>
      ${shown.map(
        (stall, index) => html`<canvas class="crop" data-pane=${index} width=${CARD.width} height=${CARD.height} role="img" aria-label=${say("stall-picture", { stall: label })} ?hidden=${stall === undefined}></canvas>
        <div>
          ${index === 0 ? html`<div class="h">${say("archive-stall-of", { label })}</div>` : nothing}
          ${this.isPair ? html`<div class="sub">${say(index === 0 ? "archive-before" : "archive-after")}</div>` : nothing}
          ${stall && this.known !== "" ? html`<div class="sub">${this.known}</div>` : stall ? html`<div class="kind">${swatch(stall.state)} ${capital(likelihood(stall))}</div><div class="sub">${stall.taken === null ? "" : say("archive-chance-taken", { value: number(100 * stall.taken) })}</div>` : html`<div class="kind">${say("compare-not-there")}</div>`}
        </div>`,
      )}
    </div>`;
  }

  override updated(changed: PropertyValues<this>): void {
    if (!this.isConnected) return;
    this.makePanes();
    if (changed.has("theme") && changed.get("theme") !== undefined) for (const { map } of this.panes) map.recolour();
    const isOther = this.panes.map((pane, index) => pane.show((index === 0 ? this.source : this.later) ?? null));
    this.markDrawn();
    const isNew = this.showSections();
    if (isOther[0] || (isNew && this.source?.stalls.length === 0)) this.showWhole();
    this.bringSection();
    this.showPlan(changed.has("isPlanning"));
    this.panes.forEach((pane, index) => pane.mark(index === 0 ? this.scene : EMPTY_SCENE, this.marked, pane.stall(this.idIn(index))));
    if (isOther.includes(true)) this.requestUpdate(); // now the stall that was chosen has a card
    this.placeMarks();
  }

  /** The sections on the survey's map: while the plan is open the plan's are there. Returns whether they are the first ones. */
  private showSections(): boolean {
    const plane = this.source?.plane;
    const before = this.shapes.length;
    if (this.sections !== this.drawnSections || this.changes !== this.drawnChanges || plane !== this.drawnPlane || language() !== this.spoken) {
      Object.assign(this, { drawnSections: this.sections, drawnChanges: this.changes, drawnPlane: plane, spoken: language() });
      this.shapes = plane ? shapesOf(this.sections, plane, this.changes) : [];
    }
    for (const pane of this.panes) pane.sections.show(this.isPlanning ? NONE : this.shapes, this.section);
    return before === 0 && this.shapes.length > 0;
  }

  /** The plan lies where the survey does: their frames are those of the lot. */
  private showPlan(isNew: boolean): void {
    const { operator, panes } = this;
    const [pane] = panes;
    if (!operator || !pane) return;
    this.plan ??= new PlanOnMap(pane.map, operator, () => this.source?.plane ?? null, false);
    this.plan.update(this.isPlanning);
    if (isNew) pane.map.showLayers(ALL_LAYERS, null); // the survey's stalls make room for the plan's
  }

  /** The editor's own keys do not go to the map. */
  private readonly planKey = {
    capture: true,
    handleEvent: (event: KeyboardEvent): void => {
      if (!this.isPlanning || !(event.target as HTMLElement).matches(".ol, .ol *") || this.plan?.key(event) !== true) return;
      event.preventDefault();
      event.stopPropagation();
    },
  };

  /** As many maps as surveys; the second one shows the place of the first. */
  private makePanes(): void {
    if (this.panes.length === 0 && !this.source && !this.later) return; // nobody sees an empty map drawn
    const holders = [...this.querySelectorAll<HTMLElement>(".ol")];
    while (this.panes.length > holders.length) this.panes.pop()?.map.dispose();
    for (const [index, holder] of holders.entries()) {
      if (this.panes[index]) continue;
      const clicked = (place: Point, stall: number | null): void => {
        const section = stall === null ? (this.panes[index]?.sections.at(toCoordinate(place)) ?? "") : "";
        if (section !== "" || this.section !== "") this.chooseSection(section);
        if (section === "") this.choose(this.laterId(index, this.panes[index]?.idOf(stall) ?? ""));
      };
      const looking = (how: string): void => {
        if (how === "free") this.panes.forEach(({ map }, other) => (other === index ? undefined : map.stay()));
      };
      const drawn = (pictures: Arrived): void => {
        const pane = this.panes[index];
        if (pane?.source) pane.drawn = pictures;
        this.markDrawn();
      };
      const pane = new MapPane(holder, { clicked, moved: () => this.placeMarks(), looking, drawn }, this.panes[0] ?? null);
      if (this.isPair) pane.map.above = CARDS_PX;
      this.panes.push(pane);
    }
  }

  /** Names on the element what is drawn: "first" pictures or "all", and the stalls. What measures the map waits for it. */
  private markDrawn(): void {
    const drawn = this.panes.map((pane) => pane.drawn);
    if (drawn.length === 0 || drawn.includes(null)) delete this.dataset.drawn;
    else this.dataset.drawn = drawn.includes("first") ? "first" : "all";
  }

  private showWhole(): void {
    const rings = this.shapes.flatMap(({ ring }) => ring);
    const around = rings.length > 0 ? extentOf([...rings, ...(this.source?.stalls ?? []).flatMap(corners)]) : null;
    const extent = this.extent ?? around;
    if (extent) this.panes[0]?.map.fit(extent);
    else this.panes[0]?.map.look("whole");
  }

  /** The id that a survey has for the stall that was chosen. */
  private idIn(index: number): string {
    return index === 0 && this.isPair ? (this.earlier.get(this.chosen) ?? this.chosen) : this.chosen;
  }

  /** The later survey's id for a stall of one of both. */
  private laterId(index: number, id: string): string {
    if (index !== 0 || !this.isPair) return id;
    return [...this.earlier].find(([, before]) => before === id)?.[0] ?? id;
  }

  private chooseSection(section: string): void {
    this.dispatchEvent(new CustomEvent<string>("section", { detail: section, bubbles: true }));
  }

  private choose(stall: string): void {
    this.dispatchEvent(new CustomEvent<string>("stall", { detail: stall, bubbles: true }));
  }

  /** Brings a section into view that was chosen elsewhere than on the map. */
  private bringSection(): void {
    const shape = this.shapes.find(({ id }) => id === this.section);
    const isOther = this.brought !== this.section;
    if (!shape) this.brought = "";
    if (!shape || !isOther || this.isPlanning) return;
    this.brought = this.section;
    this.panes[0]?.map.bringInView(shape.ring);
  }

  /** Puts the card of a section beside its middle. */
  private placeSection({ map }: MapPane): void {
    const [card, frame] = [this.querySelector<HTMLElement>("[data-section]"), this.querySelector<HTMLElement>(".map")];
    const shape = this.shapes.find(({ id }) => id === this.section);
    if (!card || !frame || !shape) return;
    const [east, north] = middleOf(shape.ring);
    const pixel = map.pixelOf({ North: north, East: east });
    if (!pixel) return;
    const [left, top] = cardPlace(pixel, card, frame);
    card.style.transform = `translate(${left}px, ${top}px)`;
  }

  /** Brings a stall into view. */
  lookAt(id: string): void {
    for (const [index, pane] of this.panes.entries()) {
      const stall = pane.stall(index === 0 ? (this.earlier.get(id) ?? id) : id);
      if (!stall) continue;
      pane.map.lookAt({ North: stall.north, East: stall.east });
      return;
    }
  }

  /** Puts the scale's length, and the card of the stall beside its place. */
  private placeMarks(): void {
    const [first] = this.panes;
    if (!first) return;
    this.metres = format.scaleLength(showScale(this, first.map.resolution), "metres");
    this.placeSection(first);
    const [card, frame] = [this.querySelector<HTMLElement>("[data-stall]"), this.querySelector<HTMLElement>(".map")];
    if (!card || !frame) return;
    for (const crop of card.querySelectorAll<HTMLCanvasElement>(".crop")) {
      const pane = this.panes[Number(crop.dataset.pane)];
      const stall = pane?.stall(this.idIn(Number(crop.dataset.pane)));
      crop.hidden = !stall || pane?.map.drawStall(stall, crop) !== true;
    }
    const index = this.panes.findIndex((pane, each) => pane.stall(this.idIn(each)));
    const stall = this.panes[index]?.stall(this.idIn(index));
    const pixel = stall && this.panes[index]?.map.pixelOf({ North: stall.north, East: stall.east });
    if (!pixel) return;
    const [left, top] = cardPlace(pixel, card, frame);
    card.style.transform = `translate(${left}px, ${top}px)`;
  }
}
