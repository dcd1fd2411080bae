import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import type { ListedArrival, ListedLot } from "../api.ts";
import { API, type Part, query, read } from "../link/api.ts";
import { number, say } from "../words/say.ts";
import { droneOf } from "./all-lots.ts";
import { moment } from "./figures.ts";
import { Asked } from "./view.ts";

const FIRST = 100;
const MOST = 1000;
const OUTCOMES = ["taken", "known", "older", "waits", "refused"] as const;

/** What drones and programs have sent to this desk, the newest first: from whom, and what became of it. */
@customElement("archive-arrivals")
export class ArrivalsView extends LitElement {
  @property({ attribute: false }) lots: readonly ListedLot[] = [];
  @property({ type: Number }) revision = 0;
  /** Name of a token; "" is that of a sender who is not known, null any. */
  @state() private sender: string | null = null;
  @state() private outcome: "" | (typeof OUTCOMES)[number] = "";
  @state() private most = FIRST;
  private readonly listed = new Asked<Part<ListedArrival>>(this);

  protected override createRenderRoot(): HTMLElement {
    return this;
  }

  override willUpdate(): void {
    const { sender, outcome, most } = this;
    const asked = `${query({ limit: String(most), outcome })}${sender === null ? "" : `&sender=${encodeURIComponent(sender)}`}`;
    this.listed.ask(`${asked} ${this.revision}`, () => read(`${API}/documents${asked}`));
  }

  override render(): TemplateResult {
    const { value, problem } = this.listed;
    return html`<div class="card">
      <div class="fields">${this.senders()}${this.outcomes()}</div>
      ${problem === "" ? nothing : html`<p role="alert">${problem}</p>`}
      ${value === null ? nothing : value.items.length === 0 ? html`<p role="status">${say("arrivals-none")}</p>` : this.table(value.items)}
      ${!value?.next || this.most >= MOST ? nothing : html`<button @click=${() => (this.most += FIRST)}>${say("arrivals-more")}</button>`}
    </div>`;
  }

  private senders(): TemplateResult {
    const names = [...new Set([...this.lots.map(droneOf), ...(this.listed.value?.items ?? []).map(({ sender }) => sender), this.sender ?? ""])].filter((name) => name !== "").sort();
    const choose = (event: Event): void => {
      const [kind = "", ...name] = (event.target as HTMLSelectElement).value;
      this.sender = kind === "" ? null : name.join("");
    };
    const option = (value: string, words: string, isChosen: boolean): TemplateResult => html`<option value=${value} ?selected=${isChosen}>${words}</option>`;
    return html`<label>${say("arrivals-sender")}<select @change=${choose}>${option("", say("arrivals-all"), this.sender === null)}${names.map((name) => option(`=${name}`, name, this.sender === name))}${option("=", say("arrivals-unknown"), this.sender === "")}</select></label>`;
  }

  private outcomes(): TemplateResult {
    const choose = (event: Event): void => {
      this.outcome = OUTCOMES.find((each) => each === (event.target as HTMLSelectElement).value) ?? "";
    };
    return html`<label>${say("arrivals-outcome")}<select @change=${choose}><option value="" ?selected=${this.outcome === ""}>${say("arrivals-all")}</option>${OUTCOMES.map((each) => html`<option value=${each} ?selected=${each === this.outcome}>${say(`arrivals-${each}`)}</option>`)}</select></label>`;
  }

  private table(items: readonly ListedArrival[]): TemplateResult {
    const heads = ["archive-when", "arrivals-sender", "arrivals-what", "archive-lot", "arrivals-outcome"] as const;
    return html`<div class="wide" tabindex="0" role="region" aria-label=${say("arrivals")}><table class="cards">
      <thead><tr>${heads.map((key) => html`<th scope="col">${say(key)}</th>`)}</tr></thead>
      <tbody>${items.map((row) => this.row(row))}</tbody>
    </table></div>`;
  }

  private row({ at, sender, kind, name, lot, outcome, reason, times }: ListedArrival): TemplateResult {
    const named = kind === "survey" || kind === "lot" || kind === "recording" ? name.slice(0, 8) : name;
    const lotName = this.lots.find(({ id }) => id === lot)?.name ?? lot?.slice(0, 8) ?? "–";
    const often = times > 1 ? ` ${say("arrivals-times", { times: number(times) })}` : "";
    return html`<tr><th scope="row">${moment(at)}</th><td data-column=${say("arrivals-sender")}>${sender === "" ? say("arrivals-unknown") : sender}</td>
      <td data-column=${say("arrivals-what")}>${say(`arrivals-kind-${kind}`)} <span class="sub">${named}</span></td><td data-column=${say("archive-lot")}>${lotName}</td>
      <td data-column=${say("arrivals-outcome")}>${say(`arrivals-${outcome}`)}${often}${reason === "" ? nothing : html` <span class="sub" lang="en">${reason}</span>`}</td></tr>`;
  }
}
