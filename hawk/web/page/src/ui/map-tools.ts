import { html, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import type { Looking } from "../map/lot-map.ts";
import { type Layer, LAYERS } from "../state/preferences.ts";
import { layerWords } from "../words/layers.ts";
import { say } from "../words/say.ts";
import { Part } from "./element.ts";
import { icon, type IconName, needle } from "./icons.ts";

/** What the map does itself. */
export type MapTool = "in" | "out" | "follow" | "whole";
export type MapToolEvent = CustomEvent<MapTool>;

/** The tools at the map's edge, and the panel in which its layers are chosen. */
@customElement("hawk-map-tools")
export class MapTools extends Part {
  @property() looking: Looking = "whole";
  /** Whether the drone's computer has a background of its own. */
  @property({ attribute: false }) background = false;
  @state() private open = false;
  @query(".layers input") private first!: HTMLInputElement;
  @query(".opens") private opener!: HTMLButtonElement;

  override render(): TemplateResult {
    const look = (label: string, name: "follow" | "whole"): TemplateResult =>
      this.tool(label, name, () => this.ask(name), this.looking === name);
    return html`<div class="tools" @keydown=${this.key}>
      <div class="group zoom">
        ${this.tool(say("zoom-in"), "plus", () => this.ask("in"))} ${this.tool(say("zoom-out"), "minus", () => this.ask("out"))}
      </div>
      <div class="group">${look(say("follow-drone"), "follow")} ${look(say("whole-lot"), "whole")}</div>
      <div class="group">${this.compass()} ${this.measureButton("roomy")} ${this.layersButton()}</div>
      ${this.open ? this.layers() : nothing}
    </div>`;
  }

  private tool(label: string, name: IconName, run: () => void, on?: boolean): TemplateResult {
    return html`<button aria-label=${label} title=${label} aria-pressed=${on ?? nothing} class="${name} ${on ? "on" : ""}" @click=${run}>
      ${icon(name)}
    </button>`;
  }

  /** Its needle points north on the map. */
  private compass(): TemplateResult {
    const { droneUp } = this.model.preferences;
    return html`<button
      aria-label=${say("turn-with-drone")}
      title=${droneUp ? say("drone-up") : say("north-up")}
      aria-pressed=${droneUp}
      class="compass ${droneUp ? "on" : ""}"
      @click=${() => this.model.prefer({ droneUp: !droneUp })}
    >
      ${needle(say("north-on-map"))}<span>${say("north-letter")}</span>
    </button>`;
  }

  /** On small pages it has no room beside the map, and is in the panel. */
  private measureButton(place: "roomy" | "wide"): TemplateResult {
    const { measure, drawing, plan } = this.model;
    const begin = (): void => {
      this.open = false;
      if (measure.open) measure.end();
      else this.model.beginMeasure();
    };
    return html`<button
      aria-label=${say("measure")}
      title=${say("measure")}
      aria-pressed=${measure.open}
      ?disabled=${drawing !== null || plan.open}
      class="${place} ${measure.open ? "on" : ""}"
      @click=${begin}
    >
      ${icon("measure")}${place === "wide" ? html`<span>${say("measure")}</span>` : nothing}
    </button>`;
  }

  private layersButton(): TemplateResult {
    const { open } = this;
    return html`<button
      aria-label=${say("layers")}
      title=${say("layers")}
      aria-expanded=${open}
      class="opens ${open ? "on" : ""}"
      @click=${() => this.show(!open)}
    >
      ${icon("layers")}
    </button>`;
  }

  private layers(): TemplateResult {
    return html`<fieldset class="layers">
      <legend>${say("shown-on-map")}</legend>
      ${LAYERS.filter((layer) => layer !== "background" || this.background).map((layer) => this.layer(layer))} ${this.measureButton("wide")}
    </fieldset>`;
  }

  private layer(layer: Layer): TemplateResult {
    const { layers } = this.model.preferences;
    const choose = (event: Event): void => {
      this.model.prefer({ layers: { ...layers, [layer]: (event.target as HTMLInputElement).checked } });
    };
    return html`<label><input type="checkbox" name=${layer} .checked=${layers[layer]} @change=${choose} />${layerWords(layer)}</label>`;
  }

  /** Opens or closes the panel; the focus goes along. */
  private show(open: boolean): void {
    this.open = open;
    void this.updateComplete.then(() => (open ? this.first : this.opener).focus());
  }

  private readonly key = (event: KeyboardEvent): void => {
    if (event.key !== "Escape" || !this.open) return;
    event.preventDefault();
    this.show(false);
  };

  private ask(tool: MapTool): void {
    this.dispatchEvent(new CustomEvent("map-tool", { detail: tool, bubbles: true }));
  }
}
