import { html, nothing, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import type { ListedLink, SurveysUse } from "../api.ts";
import { API, post, read } from "../link/api.ts";
import { say } from "../words/say.ts";
import { moment } from "./figures.ts";
import { asking, Asked, View, wordsOf } from "./view.ts";

const STANDARD_DAYS = 30;

/** Links by which others read this lot: made for some days, and taken back. */
@customElement("archive-links")
export class LinksView extends View {
  @state() private made: { address: string; ends: string } | null = null;
  /** The link that is to be taken back if a person says so again. */
  @state() private asked = "";
  private readonly listed = new Asked<{ shares: ListedLink[] }>(this);

  private readonly surveys = new Asked<SurveysUse>(this);

  override willUpdate(): void {
    this.surveys.ask(`${this.place.lot} ${this.revision}`, () => this.source.surveys({ from: "", to: "" }));
    this.listed.ask(`${this.place.lot} ${this.revision}`, () => read(`${API}/lots/${this.place.lot}/shares`));
  }

  override render(): TemplateResult {
    const { value, problem } = this.listed;
    if (problem !== "") return html`<p role="alert">${problem}</p>`;
    return html`<p>${say("archive-links-note")}</p>
      ${this.mayChange ? this.form() : nothing}
      <div aria-live="polite">${this.made === null ? nothing : html`<p class="card">${say("archive-link-made", { ends: this.day(this.made.ends) })}<br /><input class="address" readonly aria-label=${say("archive-link")} .value=${this.made.address} @focus=${(event: FocusEvent) => (event.target as HTMLInputElement).select()} /></p>`}</div>
      <ul>${(value?.shares ?? []).map((row) => this.row(row))}</ul>`;
  }

  /** A day of the lot's clock. */
  private day(time: string): string {
    return moment(time, this.surveys.value?.clock).slice(0, 10);
  }

  private form(): TemplateResult {
    return html`<form class="fields" @submit=${(event: SubmitEvent) => void this.make(event)}>
      <label>${say("archive-link-days")}<input type="number" name="days" min="1" max="366" step="1" required .defaultValue=${String(STANDARD_DAYS)} /></label>
      <button type="submit">${say("archive-make-link")}</button>
    </form>`;
  }

  private row(row: ListedLink): TemplateResult {
    const words = say(row.open ? "archive-link-open" : "archive-link-shut", { made: this.day(row.made), ends: this.day(row.ends) });
    return html`<li>${words}${row.who === null ? "" : ` · ${row.who}`} ${row.open && this.mayChange ? asking(row.id === this.asked, { ask: say("archive-take-back"), sure: say("archive-take-back") }, (isAsked) => (this.asked = isAsked ? row.id : ""), () => void this.takeBack(row)) : nothing}</li>`;
  }

  private async make(event: SubmitEvent): Promise<void> {
    event.preventDefault();
    const field = (event.currentTarget as HTMLFormElement).elements.namedItem("days") as HTMLInputElement;
    try {
      const { token, ends } = await post<{ token: string; ends: string }>(`lots/${this.place.lot}/shares`, { days: Number(field.value) });
      this.made = { address: new URL(`shared#${token}`, document.baseURI).href, ends };
      this.changed();
    } catch (error) {
      this.said(wordsOf(error));
    }
  }

  private async takeBack(row: ListedLink): Promise<void> {
    this.asked = "";
    try {
      await post(`shares/${row.id}/take-back`);
      this.made = null;
      this.changed();
    } catch (error) {
      this.said(wordsOf(error));
    }
  }
}
