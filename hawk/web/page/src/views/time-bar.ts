import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import type { SurveyUse } from "../api.ts";
import { cssVars } from "../ui/css-vars.ts";
import { icon } from "../ui/icons.ts";
import { language, number, say } from "../words/say.ts";
import { share } from "./figures.ts";
import { type Day, daysOf, type Tick, weekOf } from "./time-bar-days.ts";

/** The surveys of a lot as ticks by day and hour, a week at a time: each is filled by the share that was taken. */
@customElement("hawk-time-bar")
export class TimeBar extends LitElement {
  @property({ attribute: false }) surveys: readonly SurveyUse[] = [];
  /** Ids of the surveys that are shown: one, or two that are compared. */
  @property({ attribute: false }) chosen: readonly string[] = [];
  /** Time zone of the lot. */
  @property() zone = "UTC";
  /** Weeks before the one of what is chosen. */
  @property({ attribute: false }) private back = 0;

  protected override createRenderRoot(): HTMLElement {
    return this;
  }

  override willUpdate(changed: Map<string, unknown>): void {
    if (changed.has("chosen") && JSON.stringify(changed.get("chosen")) !== JSON.stringify(this.chosen)) this.back = 0;
  }

  override render(): TemplateResult | typeof nothing {
    const about = this.surveys.find(({ id }) => id === this.chosen.at(-1)) ?? this.surveys[0];
    if (!about) return nothing;
    const days = daysOf(this.surveys, weekOf(about.ended, this.zone, this.back), this.zone);
    return html`<section class="timebar" aria-label=${say("time-bar")}>
      <div class="steps">
        <button aria-label=${say("time-bar-before")} @click=${() => (this.back += 1)}>${icon("left")}</button>
        <button aria-label=${say("time-bar-after")} @click=${() => (this.back -= 1)}>${icon("next")}</button>
      </div>
      <ol class="days" @keydown=${(event: KeyboardEvent) => this.key(event)}>${days.map((day) => this.day(day))}</ol>
    </section>`;
  }

  private day(day: Day): TemplateResult {
    const name = day.date.toLocaleDateString(language(), { weekday: "short", day: "numeric", month: "short", timeZone: "UTC" });
    return html`<li class=${day.ticks.length === 0 ? "none" : ""}><b>${name}</b>
      <div class="hours">${day.ticks.map((tick) => this.tick(tick))}</div></li>`;
  }

  private tick({ survey, at, clock, ids }: Tick): TemplateResult {
    const on = this.chosen.some((id) => ids.includes(id));
    const count = ids.length;
    const { value } = survey.occupancy;
    const label = [clock, survey.left_out_code === "" ? `${say("archive-occupancy")} ${share(survey.occupancy)}` : say("time-bar-not-counted"), count > 1 ? say("time-bar-more", { count: count - 1 }) : ""].filter((each) => each !== "").join(", ");
    return html`<button class="tick ${on ? "on" : ""}" aria-pressed=${on} title=${label} aria-label=${label}
      ${cssVars({ "--at": `${100 * at}%`, "--full": `${100 * (value ?? 0)}%` })} @click=${() => this.pick(survey.id)}>
      <i class=${value === null ? "unknown" : ""}></i><span class="clock">${on ? clock : ""}</span>${count > 1 ? html`<span class="count" aria-hidden="true">${number(count)}</span>` : nothing}</button>`;
  }

  /** Arrows go from survey to survey, whatever week they lie in. */
  private key(event: KeyboardEvent): void {
    const step = event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0;
    if (step === 0) return;
    event.preventDefault();
    const all = this.surveys.toSorted((one, other) => Date.parse(one.ended) - Date.parse(other.ended));
    const next = all[all.findIndex(({ id }) => id === this.chosen.at(-1)) + step];
    if (next) this.pick(next.id);
    void this.updateComplete.then(() => this.querySelector<HTMLElement>(".tick.on")?.focus());
  }

  private pick(survey: string): void {
    this.dispatchEvent(new CustomEvent<string>("survey", { detail: survey, bubbles: true }));
  }
}
