import { html, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import type { Recording } from "../api.ts";
import { API, post, readAll } from "../link/api.ts";
import { bytes, longDuration } from "../words/format.ts";
import { say } from "../words/say.ts";
import { moment } from "./figures.ts";
import type { LotSource } from "./link.ts";
import { asking, Asked, View, wordsOf } from "./view.ts";

/** The recordings on the drone's disk: size, lot, length, mark, download, delete. */
@customElement("archive-recordings")
export class RecordingsView extends View {
  @property({ attribute: false }) sourceOf!: (lot: string) => LotSource;
  /** The clock that the bar names: that of a recording over no lot, too. */
  @property() zone: string | undefined;
  private readonly listed = new Asked<Recording[]>(this);
  private asked = "";

  override willUpdate(): void {
    this.listed.ask(`${this.revision} ${this.place.recording}`, () => readAll("recordings"));
  }

  override render(): TemplateResult {
    const { value, problem } = this.listed;
    if (this.place.recording !== "" && (value !== null || problem !== "")) return html`<archive-film .place=${this.place} .revision=${this.revision} .recordings=${value ?? []} .zone=${this.zone} .sourceOf=${this.sourceOf}></archive-film>`;
    if (problem !== "") return html`<p role="alert">${problem}</p>`;
    if (value === null) return html`<p data-asking>${say("archive-asking")}</p>`;
    if (value.length === 0) return html`<p>${say("archive-no-recording")}</p>`;
    return html`<p>${say("archive-recordings-size", { count: value.length, size: bytes(value.reduce((sum, row) => sum + row.bytes, 0)) })}</p>
      <div class="wide" tabindex="0" role="region" aria-label=${say("view-recordings")}><table class="cards">
        <thead><tr>${(["archive-when", "archive-lot", "archive-length", "archive-size", "archive-keep", "archive-file"] as const).map((key) => html`<th scope="col">${say(key)}</th>`)}</tr></thead>
        <tbody>${value.toReversed().map((row) => this.row(row))}</tbody>
      </table></div>`;
  }

  private row(row: Recording): TemplateResult {
    const when = row.began === null ? row.name : moment(row.began, row.lot?.time_zone ?? this.zone);
    return html`<tr><th scope="row">${row.under_way ? when : html`<button class="plain link" aria-label=${say("film-watch", { when })} @click=${() => this.go({ recording: row.name, t: "" })}>${when}</button>`}</th><td>${row.lot?.name ?? "–"}${row.drone === null ? nothing : html` <span class="sub">${row.drone}</span>`}</td>
      <td>${row.seconds === null ? "–" : longDuration(row.seconds)}</td><td>${bytes(row.bytes)}</td>
      <td data-column=${say("archive-keep")}><input type="checkbox" .checked=${row.keep} ?disabled=${!this.mayChange} aria-label=${say("archive-keep-of", { when })} @change=${(event: Event) => void this.keep(row, (event.target as HTMLInputElement).checked)} /></td>
      <td>${row.under_way ? say("archive-under-way") : this.mayChange ? this.actions(row, when) : "–"}</td></tr>`;
  }

  /** A recording that is gone does not come back. */
  private actions(row: Recording, when: string): TemplateResult {
    const words = { ask: say("archive-delete"), sure: say("archive-delete-surely"), label: say("archive-delete-of", { when }), sureLabel: say("archive-delete-surely-of", { when }) };
    return html`<a href="${API}/recordings/${row.name}" download aria-label=${say("archive-download-of", { when })}>${say("archive-download")}</a>
      ${asking(this.asked === row.name, words, (isAsked) => this.ask(isAsked ? row.name : ""), () => void this.delete(row))}`;
  }

  private async keep(row: Recording, wanted: boolean): Promise<void> {
    await this.change(post(`recordings/${row.name}/keep`, { keep: wanted }));
  }

  private ask(name: string): void {
    this.asked = name;
    this.requestUpdate();
  }

  private async delete(row: Recording): Promise<void> {
    this.asked = "";
    await this.change(post(`recordings/${row.name}/delete`));
  }

  private async change(asked: Promise<unknown>): Promise<void> {
    try {
      await asked;
    } catch (error) {
      this.said(wordsOf(error));
    }
    this.changed();
  }
}
