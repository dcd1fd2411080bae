import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import type { Film } from "../api.ts";
import { cssVars } from "../ui/css-vars.ts";
import { icon } from "../ui/icons.ts";
import { ofDrone } from "../words/drone.ts";
import { number, say } from "../words/say.ts";
import { clockAt, phasesOf, roundTimes, SPEEDS, spanOf } from "./film.ts";


/** A film as a bar: its phases, its messages as marks, the time of now, and how fast it is played. */
@customElement("hawk-film-bar")
export class FilmBar extends LitElement {
  @property({ attribute: false }) film!: Film;
  @property({ type: Number }) at = 0;
  @property({ type: Boolean }) playing = false;
  @property({ type: Number }) speed = 1;
  /** Time zone of the lot. */
  @property({ attribute: false }) zone: string | undefined;
  /** Whether there is a recording before and after this one, and a week to go back to. */
  @property({ attribute: false }) has = { before: false, after: false, week: false };
  /** Redraws the bar in another language. */
  @property() spoken = "";

  protected override createRenderRoot(): HTMLElement {
    return this;
  }

  override render(): TemplateResult {
    const { film, at, has } = this;
    const word = say(this.playing ? "film-pause" : "film-play");
    return html`<section class="filmbar" aria-label=${say("film")}>
      <button class="primary play" aria-label=${word} title=${word} @click=${() => this.ask("play")}>${icon(this.playing ? "pause" : "play")}</button>
      <div class="choices">
        ${has.week ? html`<button class="small" @click=${() => this.ask("week")}>${say("film-week")}</button>` : nothing}
        <label><span class="unseen">${say("film-speed")}</span><select @change=${(event: Event) => this.ask("speed", Number((event.target as HTMLSelectElement).value))}>
          ${SPEEDS.map((each) => html`<option value=${each} ?selected=${each === this.speed}>${number(each, 2, 0)} ×</option>`)}
        </select></label>
      </div>
      <div class="line">
        ${this.phases()}
        <input type="range" min="0" max=${film.seconds} step="0.1" .value=${String(at)} aria-label=${say("film-time")} aria-valuetext=${this.words(at)} ${cssVars({ "--at": this.share(at) })}
          @input=${(event: Event) => this.ask("seek", Number((event.target as HTMLInputElement).value))} @change=${() => this.ask("stay")} />
        ${this.marks()} ${this.clocks()}
        <output class="now" ${cssVars({ "--at": this.share(at) })}>${this.words(at)}</output>
      </div>
      <div class="steps">
        <button aria-label=${say("film-before")} title=${say("film-before")} ?disabled=${!has.before} @click=${() => this.ask("before")}>${icon("left")}</button>
        <button aria-label=${say("film-after")} title=${say("film-after")} ?disabled=${!has.after} @click=${() => this.ask("after")}>${icon("next")}</button>
      </div>
    </section>`;
  }

  private phases(): TemplateResult {
    return html`<ol class="phases" aria-label=${say("film-phases")}>${phasesOf(this.film).map(
      ({ from, to, title }) => html`<li ${cssVars({ "--at": this.share(from), "--wide": this.share(to - from) })}><button class="plain" title=${title} @click=${() => this.ask("seek", from)}>${title}</button></li>`,
    )}</ol>`;
  }

  private marks(): TemplateResult {
    return html`<div class="marks" aria-hidden="true">${this.film.messages.map(
      ({ at, level, text }) => html`<i data-level=${level} title=${ofDrone(text)} ${cssVars({ "--at": this.share(at) })}></i>`,
    )}</div>`;
  }

  private clocks(): TemplateResult {
    const { film, zone } = this;
    return html`<div class="clocks" aria-hidden="true">${roundTimes(film).map((at) => html`<span ${cssVars({ "--at": this.share(at) })}>${clockAt(film, at, zone)}</span>`)}</div>`;
  }

  private words(at: number): string {
    const clock = clockAt(this.film, at, this.zone);
    return clock === spanOf(at) ? clock : say("film-now", { clock, span: spanOf(at) });
  }

  private share(seconds: number): string {
    return `${(100 * seconds) / Math.max(0.1, this.film.seconds)}%`;
  }

  private ask(what: FilmAsked["what"], value = 0): void {
    this.dispatchEvent(new CustomEvent<FilmAsked>("film", { detail: { what, value } }));
  }
}

/** What was pressed on the bar. */
export interface FilmAsked {
  what: "play" | "week" | "speed" | "seek" | "stay" | "before" | "after";
  value: number;
}
