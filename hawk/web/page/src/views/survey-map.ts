import { html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { API } from "../link/api.ts";
import type { Point } from "../protocol.ts";
import { EMPTY_SCENE } from "../map/flight-scene.ts";
import { cardPlace, scaleBar } from "../map/geometry.ts";
import { LotMap } from "../map/lot-map.ts";
import { MapStore, type Stall } from "../state/map-store.ts";
import { ALL_LAYERS } from "../state/preferences.ts";
import { icon, type IconName } from "../ui/icons.ts";
import { swatch } from "../ui/swatch.ts";
import * as format from "../words/format.ts";
import { capital, number, say } from "../words/say.ts";
import { likelihood } from "../words/stall.ts";
import type { SurveyOnMap } from "./survey-source.ts";

/** As the drone makes pictures of the ground. */
const GRID = { cells: 256, cellSize: 0.1 };
const ZOOM = 1.6;
const LONGEST_BAR_PX = 120;
const CARD = { width: 120, height: 192 };

/** A stored survey on the map of the flight: its picture, and its stalls with states and labels. */
@customElement("hawk-survey-map")
export class SurveyMap extends LitElement {
  @property({ attribute: false }) source: SurveyOnMap | null = null;
  /** Id of the stall that was chosen. */
  @property() chosen = "";
  /** What a screen reader says of the map. */
  @property() label = "";
  /** Another one where the theme is another one. */
  @property() theme = "";
  /** What is known of the chosen stall, in place of how sure its state is. */
  @property() known = "";
  /** What the colours mean, in place of the states. */
  @property({ attribute: false }) legend: TemplateResult | null = null;
  @query(".ol") private holder!: HTMLElement;
  @query("canvas.crop") private crop!: HTMLCanvasElement | null;
  @state() private metres = "";
  private map: LotMap | null = null;
  private readonly store = new MapStore();

  protected override createRenderRoot(): HTMLElement {
    return this;
  }

  override connectedCallback(): void {
    super.connectedCallback();
    this.requestUpdate();
  }

  override disconnectedCallback(): void {
    this.map?.dispose();
    this.map = null;
    super.disconnectedCallback();
  }

  override render(): TemplateResult {
    const stall = this.chosenStall();
    return html`<section class="map" aria-label=${say("map")}>
      <div class="ol" tabindex="0" role="application" aria-label=${this.label}></div>
      <div class="tools">
        <div class="group">${this.tool(say("zoom-in"), "plus", () => this.map?.zoom(ZOOM))}${this.tool(say("zoom-out"), "minus", () => this.map?.zoom(1 / ZOOM))}</div>
        <div class="group">${this.tool(say("whole-lot"), "whole", () => this.map?.look("whole"))}</div>
      </div>
      <div class="mapfoot"><span class="scale"></span><span>${this.metres}</span>${this.legend ?? (["free", "taken", "unknown"] as const).map((each) => html`${swatch(each)}<span>${say(each)}</span>`)}</div>
      ${stall ? this.card(stall) : nothing}
    </section>`;
  }

  private tool(label: string, name: IconName, run: () => void): TemplateResult {
    return html`<button aria-label=${label} title=${label} @click=${run}>${icon(name)}</button>`;
  }

  private card(stall: Stall): TemplateResult {
    const sure = stall.taken === null ? "" : say("archive-chance-taken", { value: number(100 * stall.taken) });
    return html`<div class="pop stall" data-stall>
      <canvas class="crop" width=${CARD.width} height=${CARD.height} role="img" aria-label=${say("stall-picture", { stall: stall.label })}></canvas>
      <div>
        <button class="plain close" aria-label=${say("close")} @click=${() => this.choose("")}>${icon("close")}</button>
        <div class="h">${say("archive-stall-of", { label: stall.label })}</div>
        ${this.known === "" ? html`<div class="kind">${swatch(stall.state)} ${capital(likelihood(stall))}</div>
        <div class="sub">${sure}</div>` : html`<div class="sub">${this.known}</div>`}
      </div>
    </div>`;
  }

  override updated(changed: PropertyValues<this>): void {
    if (!this.isConnected) return;
    this.map ??= this.make();
    if (changed.has("theme") && changed.get("theme") !== undefined) this.map.recolour();
    if (changed.has("source")) this.showSource(this.map, changed.get("source") ?? null);
    this.map.setScene({ ...EMPTY_SCENE, selected: this.chosenStall() ?? null });
    this.placeMarks();
  }

  private make(): LotMap {
    const clicked = (_place: Point, stall: number | null): void => this.choose(stall === null ? "" : (this.source?.ids[stall] ?? ""));
    const events = { clicked, moved: () => this.placeMarks(), looking: () => undefined };
    const map = new LotMap(this.holder, GRID, events, false);
    map.showLayers(ALL_LAYERS, null);
    return map;
  }

  /** The place and the zoom stay while the surveys of one lot follow each other. */
  private showSource(map: LotMap, before: SurveyOnMap | null): void {
    const { source } = this;
    const { store } = this;
    store.stalls.clear();
    for (const stall of source?.stalls ?? []) store.stalls.set(stall.id, stall);
    if (source?.ground) {
      const { survey, ground } = source;
      map.showGround(({ row, column }) => `${API}/surveys/${survey}/ground/${row}/${column}`, ground.place, ground.tiles.map(([row, column]) => ({ row, column })));
    } else map.showGround(() => "", { north: 0, east: 0, turn: 0 }, []);
    map.apply({ reset: false, stalls: [...store.stalls.keys()], removed: (before?.stalls ?? []).map(({ id }) => id).filter((id) => !store.stalls.has(id)), tiles: [], pictures: [] }, store);
    map.showLabels(source?.rows ?? []);
    const isSame = before !== null && source !== null && before.plane.origin.Latitude === source.plane.origin.Latitude;
    if (!isSame) map.look("whole");
  }

  private chosenStall(): Stall | undefined {
    const index = this.chosen === "" ? -1 : (this.source?.ids.indexOf(this.chosen) ?? -1);
    return this.source?.stalls[index];
  }

  private choose(stall: string): void {
    this.dispatchEvent(new CustomEvent<string>("stall", { detail: stall, bubbles: true }));
  }

  /** Puts the scale's length, and the card of the stall beside its place. */
  private placeMarks(): void {
    const { map } = this;
    if (!map) return;
    const { length, pixels } = scaleBar(map.resolution, LONGEST_BAR_PX);
    this.querySelector<HTMLElement>(".scale")?.style.setProperty("width", `${Math.round(pixels)}px`);
    this.metres = format.scaleLength(length, "metres");
    const [stall, card] = [this.chosenStall(), this.querySelector<HTMLElement>("[data-stall]")];
    const pixel = stall && map.pixelOf({ North: stall.north, East: stall.east });
    if (!stall || !card || !pixel) return;
    if (this.crop) this.crop.hidden = !map.drawStall(stall, this.crop);
    const [left, top] = cardPlace(pixel, card, this.holder);
    card.style.transform = `translate(${left}px, ${top}px)`;
  }
}
