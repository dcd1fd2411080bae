import { html, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { FenceOnMap } from "../map/fence-on-map.ts";
import { dronePlace, shownChanges, shownFence, shownOutline } from "../map/fence-shown.ts";
import { EMPTY_SCENE, type Scene, withLayers } from "../map/flight-scene.ts";
import { cardPlace, extentOf, showScale, toCoordinate } from "../map/geometry.ts";
import { LotMap, type Looking } from "../map/lot-map.ts";
import { PlanOnMap } from "../map/plan-on-map.ts";
import { SectionsLayer } from "../map/sections-layer.ts";
import type { LotFrame } from "../plan/frame.ts";
import type { Point, Welcome } from "../protocol.ts";
import { isFlying } from "../state/flight.ts";
import { NO_SECTIONS } from "../state/flown-sections.ts";
import type { MapChange, Stall } from "../state/map-store.ts";
import type { ShownChanges } from "../state/operator.ts";
import * as format from "../words/format.ts";
import { planMove } from "../words/move.ts";
import { language, number, say } from "../words/say.ts";
import { fullness, parkedWords } from "../words/section.ts";
import { SCALES } from "../words/units.ts";
import { userError } from "../words/user-error.ts";
import { linkOf, stallCount, type View } from "../words/view.ts";
import { Part } from "./element.ts";
import type { FenceToolEvent } from "./fence-tools.ts";
import { icon } from "./icons.ts";
import { checkWords, drone, quoting } from "./quoting.ts";
import type { MapTool, MapToolEvent } from "./map-tools.ts";
import { swatch } from "./swatch.ts";
import "./fence-tools.ts";
import "./map-tools.ts";
import "./measure-bar.ts";
import "./move-fields.ts";
import "./plan-tools.ts";
import "./stall-card.ts";

const STANDARD_GRID = { cells: 256, cellSize: 0.1 };
/** The flight is drawn before the editor of fences is read. */
const READ_EDITOR_MS = 2000;
/** One press of a zoom button. */
const ZOOM = 1.6;
/** So near the first place a measured ring is closed. */
const CLOSING_PX = 16;

/** The map with its tools, scale, legend, and what is said about places on it. */
@customElement("hawk-map")
export class MapPanel extends Part {
  /** Another view is shown: it may have a map of its own. */
  @property({ attribute: false }) isAway = false;
  @query(".ol") private holder!: HTMLDivElement;
  @state() private looking: Looking = "whole";
  @state() private selected: number | null = null;
  private lot: LotMap | null = null;
  private fence: FenceOnMap | null = null;
  private plan: PlanOnMap | null = null;
  private readonly sections = new SectionsLayer();
  private drawnSections = NO_SECTIONS;
  private spoken = "";
  private wasFlying = false;
  private measuring = false;
  private changes: ShownChanges | null = null;
  private theme = "";

  override firstUpdated(): void {
    const welcome: Welcome | null = this.model.flight.welcome;
    const grid = welcome ? { cells: welcome["Tile Cells"], cellSize: welcome["Cell Size"] } : STANDARD_GRID;
    this.lot = new LotMap(this.holder, grid, {
      clicked: (place, stall) => this.clicked(place, stall),
      moved: () => this.placeMarks(),
      looking: (looking) => (this.looking = looking),
    });
    this.lot.addLayer(this.sections);
    this.fence = new FenceOnMap(this.lot, this.model);
    this.plan = new PlanOnMap(this.lot, this.model, () => this.model.flight.plane, true);
    this.lot.apply(this.model.map.whole(), this.model.map);
    setTimeout(() => this.fence?.read(), READ_EDITOR_MS);
    this.model.addEventListener("map", this.mapChanged);
    this.model.addEventListener("stall", this.stallWanted);
    new ResizeObserver(() => this.requestUpdate()).observe(this.holder);
    this.requestUpdate();
  }

  override disconnectedCallback(): void {
    this.model.removeEventListener("map", this.mapChanged);
    this.model.removeEventListener("stall", this.stallWanted);
    this.lot?.dispose();
    super.disconnectedCallback();
  }

  /** Class of the ground at a place, for what is to be confirmed. */
  readonly classAt = (place: Point): number => this.lot?.classAt(place) ?? 0;

  /** By what the plan that is corrected lies on the map. */
  get planPlaced(): LotFrame["by"] {
    return this.plan?.frame.by ?? "own";
  }

  override render(): TemplateResult {
    const view = this.model.view();
    const fencing = this.model.drawing !== null;
    const measuring = this.model.measure.open;
    const planning = this.model.plan.open && !this.isAway;
    return html`<section class="map ${this.model.picking ? "picking" : ""} ${measuring ? "picking measuring" : ""} ${fencing ? "picking fencing" : ""} ${planning ? this.planClass() : ""}" aria-label=${say("map")} @keydown=${this.planKey}>
      <div class="ol" tabindex="0" role="application" aria-label=${say("map-of-lot")} @keydown=${this.key}></div>
      ${planning ? html`<hawk-plan-tools .model=${this.model}></hawk-plan-tools>` : nothing} ${fencing ? this.fenceTools() : nothing} ${this.tools()} ${this.foot()} ${this.legend(view)} ${this.pill(view)} ${this.stallCard()} ${this.lastSeen(view)}
      ${this.notice(view)} <hawk-measure .model=${this.model}></hawk-measure> <hawk-move-fields .model=${this.model}></hawk-move-fields>
    </section>`;
  }

  override updated(_changed: PropertyValues): void {
    const theme = document.documentElement.dataset.theme ?? "";
    if (theme !== this.theme) {
      this.theme = theme;
      this.lot?.recolour();
    }
    const view = this.model.view();
    this.fence?.update();
    this.plan?.update(!this.isAway);
    const { layers } = this.model.preferences;
    this.lot?.showLayers(layers, this.model.flight.plane);
    this.showSections(layers.stalls && !this.model.plan.open);
    const { measure, preferences } = this.model;
    if (measure.open && !this.measuring) this.lot?.stay();
    this.measuring = measure.open;
    this.lot?.turnWith(preferences.droneUp ? "drone" : "north", this.choosing() || measure.open);
    this.lot?.setScene(withLayers(this.scene(view), layers, this.choosing()));
    this.lookAtFlight(view);
    this.lookAtChanges();
    this.placeMarks();
  }

  /** Sections with their counts: while a plan is open the plan's are there. */
  private showSections(isShown: boolean): void {
    const { sections } = this.model.flight;
    this.sections.setVisible(isShown);
    if (!this.lot || (sections === this.drawnSections && language() === this.spoken)) return;
    Object.assign(this, { drawnSections: sections, spoken: language() });
    this.lot.sectionGround = extentOf(sections.flatMap(({ ring }) => ring));
    this.sections.show(sections.map((each) => ({ ...each, words: parkedWords(each.look), look: fullness(each.look) })), "");
  }

  private readonly mapChanged = (event: Event): void => {
    this.lot?.apply((event as CustomEvent<MapChange>).detail, this.model.map);
  };

  private readonly stallWanted = (event: Event): void => {
    const stall = this.model.map.stalls.get((event as CustomEvent<number>).detail);
    if (!stall) return;
    if (!this.model.preferences.layers.stalls) this.model.prefer({ layers: { ...this.model.preferences.layers, stalls: true } });
    this.selected = stall.id;
    this.lot?.lookAt({ North: stall.north, East: stall.east });
  };

  /** After take-off the map follows the drone, after landing it shows the whole lot; what the operator chose stays. */
  private lookAtFlight(view: View): void {
    const flying = isFlying(view.heartbeat);
    if (flying === this.wasFlying || linkOf(view) !== "live") return;
    this.wasFlying = flying;
    if (this.looking !== "free") this.lot?.look(flying ? "follow" : "whole");
  }

  private lookAtChanges(): void {
    const { lotChanges, flight } = this.model;
    if (lotChanges === this.changes) return;
    this.changes = lotChanges;
    const shown = shownChanges(lotChanges, flight.plane);
    const places = shown ? [...shown.begin, ...shown.end].flat().map(toCoordinate) : [];
    if (places.length > 0) this.lot?.bringInView(places);
  }

  private scene(view: View): Scene {
    const heartbeat = view.heartbeat;
    if (!heartbeat) return EMPTY_SCENE;
    const plane = this.model.flight.plane;
    const place = dronePlace(heartbeat, plane);
    const drone = place && { north: place.North, east: place.East, yaw: heartbeat.Yaw ?? 0 };
    const fence = this.fence?.shown() ?? shownFence(heartbeat, this.model.flight.fenceSetup, plane);
    const lost = linkOf(view) === "lost" && isFlying(heartbeat);
    const stall = this.selected === null ? undefined : this.model.map.stalls.get(this.selected);
    const question = this.model.question;
    return {
      ...EMPTY_SCENE,
      fence: fence.inner,
      limit: fence.limit,
      zones: fence.zones,
      zoneLimits: fence.zoneLimits,
      outline: this.model.outline.open ? [] : shownOutline(this.model.outline.setup, plane),
      trail: this.model.plan.open ? [] : this.model.flight.trail,
      route: lost ? [] : heartbeat.Route,
      target: lost ? null : heartbeat.Target,
      home: heartbeat.Home,
      footprint: heartbeat.Footprint,
      drone,
      planned: question?.about === "move" ? question.target : null,
      plannedRoute: this.plannedRoute(view),
      lost: lost ? { reach: reach(view) } : null,
      marked: [],
      selected: stall ?? null,
      changes: shownChanges(this.model.lotChanges, plane),
      measured: this.model.measure.open ? { ...this.model.measure.drawn, units: this.model.preferences.units } : null,
    };
  }

  /** Whether a place to fly to, or a fence, is being chosen on the map. */
  private choosing(): boolean {
    return this.model.picking || this.model.question?.about === "move" || this.model.drawing !== null;
  }

  /** The route over the lot belongs to the Autonomous Move; any other goes straight. */
  private plannedRoute(view: View): readonly Point[] {
    const { question, routePlan } = this.model;
    if (question?.about !== "move") return [];
    const kind = question.kind ?? planMove(view, question.target, this.classAt(question.target), routePlan)?.suggested;
    return kind === "Autonomous Move" ? routePlan.points : [];
  }

  private clicked(place: Point, stall: number | null): void {
    if (this.model.measure.open) {
      this.model.measure.add(place, CLOSING_PX * (this.lot?.resolution ?? 0));
      return;
    }
    const taken = this.model.pointAt(place, stall !== null);
    this.selected = taken || stall === this.selected ? null : stall;
  }

  /** By keyboard the middle of the map is chosen: arrows move the map, plus and minus zoom. */
  private readonly key = (event: KeyboardEvent): void => {
    if (this.model.drawing !== null) this.fence?.key(event);
    const { picking, measure } = this.model;
    if (event.key === "Enter" && (picking || measure.open) && this.lot) this.clicked(this.lot.centre, null);
    if (event.key === "Backspace" && measure.open) measure.back();
  };

  /** Places are pointed at for what is drawn, stalls with a plain hand. */
  private planClass(): string {
    const { tool } = this.model.plan.drawing;
    return tool === "choose" ? "planning" : "planning picking";
  }

  /** The editor's own keys go neither to the map nor to the flight. */
  private readonly planKey = {
    capture: true,
    handleEvent: (event: KeyboardEvent): void => {
      const isMap = event.target === this.holder || this.holder.contains(event.target as Node);
      if (!this.model.plan.open || !isMap || this.isPointing() || this.plan?.key(event) !== true) return;
      event.preventDefault();
      event.stopPropagation();
    },
  };

  /** Whether a click on the map is for the flight. */
  private isPointing(): boolean {
    return this.model.picking || this.model.question?.about === "move";
  }

  private fenceTools(): TemplateResult {
    return html`<hawk-fence-tools
      .model=${this.model}
      @fence-tool=${(event: FenceToolEvent) => this.fence?.use(event.detail)}
      @fence-imported=${() => this.fence?.bringInView()}
    ></hawk-fence-tools>`;
  }

  private tools(): TemplateResult {
    const use = (event: MapToolEvent): void => this.useTool(event.detail);
    return html`<hawk-map-tools .model=${this.model} .looking=${this.looking} .background=${this.lot?.hasBackground ?? false} @map-tool=${use}></hawk-map-tools>`;
  }

  private useTool(tool: MapTool): void {
    if (tool === "in") this.lot?.zoom(ZOOM);
    else if (tool === "out") this.lot?.zoom(1 / ZOOM);
    else this.lot?.look(tool);
  }

  private foot(): TemplateResult {
    return html`<div class="mapfoot"><span class="scale"></span><span class="metres"></span></div>`;
  }

  private legend(view: View): TemplateResult | typeof nothing {
    const heartbeat = view.heartbeat;
    if (!heartbeat || stallCount(view) === 0) return nothing;
    return html`<div class="legend">
      ${swatch("free")}<span>${number(heartbeat.Free)}</span>${swatch("taken")}<span>${number(heartbeat.Taken)}</span>
      ${swatch("unknown")}<span>${number(heartbeat.Unknown)}</span>
    </div>`;
  }

  private pill(view: View): TemplateResult | typeof nothing {
    const question = this.model.question;
    if (question?.about !== "move") return nothing;
    const plan = planMove(view, question.target, this.classAt(question.target));
    if (!plan) return nothing;
    return html`<div class="pill" data-mark="target">${plan.insideFence ? plan.pill : plan.outside}</div>`;
  }

  private stallCard(): TemplateResult {
    const draw = (stall: Stall, canvas: HTMLCanvasElement): boolean => this.lot?.drawStall(stall, canvas) ?? false;
    const chosen = this.model.preferences.layers.stalls ? this.selected : null;
    return html`<hawk-stall .model=${this.model} .chosen=${chosen} .draw=${draw} @stall-closed=${() => (this.selected = null)}></hawk-stall>`;
  }

  private lastSeen(view: View): TemplateResult | typeof nothing {
    if (linkOf(view) !== "lost" || !isFlying(view.heartbeat)) return nothing;
    return html`<div class="pop seen" data-mark="drone">
      <div class="h">${say("last-seen-here", { age: format.age(view.silence ?? 0) })}</div>
      <div class="sub">${say("ring-of-reach")}</div>
    </div>`;
  }

  private notice(view: View): TemplateResult | typeof nothing {
    const toast = this.model.toasts.shown;
    const heartbeat = view.heartbeat;
    if (toast) {
      return html`<div class="toast ${toast.level}" role="alert">
        ${icon(toast.level === "info" ? "check" : "warn")}<span>${quoting(toast.text, [toast.quoted ?? ""])}</span>
        <button class="plain" aria-label=${say("close")} @click=${() => this.model.toasts.dismiss()}>${icon("close")}</button>
      </div>`;
    }
    if (this.model.drawing !== null) return nothing;
    const error = userError(heartbeat);
    if (error !== null) return html`<div class="toast warning" role="alert">${icon("warn")}<span>${drone(error)}</span></div>`;
    const failed = heartbeat?.Checks.filter((check) => !check.Passed) ?? [];
    if (failed[0] && !this.sideShown()) {
      const text = failed.length === 1 ? checkWords(failed[0]) : say("checks-failed", { checks: failed.length });
      return html`<div class="toast warning">
        ${icon("warn")}<span>${text}</span><button @click=${() => this.openChecks()}>${say("show-checks")}</button>
      </div>`;
    }
    if (!heartbeat || stallCount(view) > 0 || isFlying(heartbeat) || view.welcome?.Desk || this.model.plan.open) return nothing;
    return html`<div class="toast quiet">
      <span><b>${say("no-map-yet")}</b><span class="sub">${say(this.model.flight.fenceSetup === null ? "map-begins" : "map-fills")}</span></span>
    </div>`;
  }

  /** Whether there is a side column: a phone has none. */
  private sideShown(): boolean {
    return document.querySelector<HTMLElement>("aside.side")?.offsetParent != null;
  }

  private openChecks(): void {
    this.dispatchEvent(new CustomEvent("open-panel", { detail: "checks", bubbles: true }));
  }

  /** Puts what belongs to a place where that place is on the screen. */
  private placeMarks(): void {
    if (!this.lot) return;
    const { units } = this.model.preferences;
    const length = showScale(this, this.lot.resolution / SCALES[units].metres);
    const words = this.querySelector<HTMLElement>(".metres");
    if (words) words.textContent = format.scaleLength(length, units);
    this.querySelector<HTMLElement>(".compass")?.style.setProperty("--turn", `${this.lot.rotation}rad`);
    for (const mark of this.querySelectorAll<HTMLElement>("[data-mark]")) this.placeMark(mark);
  }

  private placeMark(mark: HTMLElement): void {
    const place = this.markPlace(mark.dataset.mark ?? "");
    const pixel = place ? this.lot?.pixelOf(place) : null;
    if (!pixel) return;
    const [left, top] = cardPlace(pixel, mark, this.holder, mark.dataset.mark === "target");
    mark.style.transform = `translate(${left}px, ${top}px)`;
  }

  private markPlace(name: string): Point | null {
    const question = this.model.question;
    if (name === "target") return question?.about === "move" ? question.target : null;
    if (name === "stall") {
      const stall = this.selected === null ? undefined : this.model.map.stalls.get(this.selected);
      return stall ? { North: stall.north, East: stall.east } : null;
    }
    const heartbeat = this.model.flight.heartbeat;
    return heartbeat && dronePlace(heartbeat, this.model.flight.plane);
  }
}

/** How far it can have flown since it was last heard, metres. */
function reach(view: View): number {
  return (view.silence ?? 0) * Math.max(view.welcome?.["Travel Speed"] ?? 0, view.heartbeat?.Speed ?? 0) * (view.welcome?.Speed ?? 1);
}

