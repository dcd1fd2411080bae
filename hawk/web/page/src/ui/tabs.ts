import { html, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { isFlying } from "../state/flight.ts";
import { say } from "../words/say.ts";
import { Part } from "./element.ts";
import "./checks-tab.ts";
import "./flight-tab.ts";
import "./messages-tab.ts";
import "./settings-tab.ts";
import "./stalls-tab.ts";

export type TabName = "Checks" | "Messages" | "Flight" | "Stalls" | "Settings";

const LABELS = { Checks: "checks", Messages: "messages", Flight: "flight", Stalls: "stalls", Settings: "settings" } as const;

/** Checks (on the ground), messages, flight and settings. */
@customElement("hawk-tabs")
export class Tabs extends Part {
  @property() chosen: TabName | "" = "";
  @state() private grounded = true;

  override willUpdate(): void {
    const grounded = !isFlying(this.model.flight.heartbeat) && (this.model.flight.heartbeat?.Checks.length ?? 0) > 0;
    if (grounded === this.grounded) return;
    this.grounded = grounded;
    if (this.chosen === "Checks" || this.chosen === "Messages") this.chosen = "";
  }

  override render(): TemplateResult {
    const names: TabName[] = [...(this.grounded ? (["Checks"] as const) : []), "Messages", "Flight", "Stalls", "Settings"];
    const chosen = names.find((name) => name === this.chosen) ?? names[0];
    return html`<section class="card tabs">
      <div class="tablist" role="tablist" aria-label=${say("about-flight")} @keydown=${(event: KeyboardEvent) => this.step(event, names, chosen)}>
        ${repeat(
          names,
          (name) => name, // a tab stays the same one when others come and go: pressed and focused as such
          (name) => html`<button
            role="tab"
            aria-selected=${name === chosen}
            tabindex=${name === chosen ? 0 : -1}
            class=${name === chosen ? "on" : ""}
            @click=${() => (this.chosen = name)}
          >
            ${say(LABELS[name])}
          </button>`,
        )}
      </div>
      <div class="tabpanel" role="tabpanel" aria-label=${chosen ? say(LABELS[chosen]) : nothing}>${this.panel(chosen)}</div>
    </section>`;
  }

  /** The arrow keys go from tab to tab, as the role demands. */
  private step(event: KeyboardEvent, names: TabName[], chosen: TabName | undefined): void {
    const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (by === undefined || chosen === undefined) return;
    this.chosen = names[(names.indexOf(chosen) + by + names.length) % names.length] ?? "";
    event.preventDefault();
    void this.updateComplete.then(() => this.querySelector<HTMLElement>(".tablist .on")?.focus());
  }

  private panel(name: TabName | undefined): TemplateResult | typeof nothing {
    switch (name) {
      case "Checks":
        return html`<hawk-checks .model=${this.model}></hawk-checks>`;
      case "Messages":
        return html`<hawk-messages .model=${this.model}></hawk-messages>`;
      case "Flight":
        return html`<hawk-flight .model=${this.model}></hawk-flight>`;
      case "Stalls":
        return html`<hawk-stalls .model=${this.model}></hawk-stalls>`;
      case "Settings":
        return html`<hawk-settings .model=${this.model}></hawk-settings>`;
      default:
        return nothing;
    }
  }
}
