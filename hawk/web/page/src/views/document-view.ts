import { html, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, query, state } from "lit/decorators.js";
import { API, query as queryOf, readFile } from "../link/api.ts";
import { isOfLots } from "../route/place.ts";
import { icon } from "../ui/icons.ts";
import { saveFile } from "../ui/save-file.ts";
import { bytes } from "../words/format.ts";
import { language, say } from "../words/say.ts";
import { askedOf } from "./question.ts";
import { View, wordsOf } from "./view.ts";

const PAPERS = { a4: "A4", letter: "Letter" } as const;
type Paper = keyof typeof PAPERS;
const FILES = ["pdf", "xlsx"] as const;
type Kind = (typeof FILES)[number];

/** The report of what is asked, or over several lots, as the drone writes it: to read, print and download. Nothing in it runs. */
@customElement("archive-document")
export class DocumentView extends View {
  /** As papers are where the browser's person lives. */
  @state() private paper: Paper = /-(US|CA|MX|PH)\b/.test(navigator.language) ? "letter" : "a4";
  /** What became of each file. */
  @state() private news: Partial<Record<Kind, string>> = {};
  /** Why there is no document. */
  @state() private problem = "";
  @query("iframe") private frame!: HTMLIFrameElement;

  override willUpdate(changed: PropertyValues<this>): void {
    if (changed.has("place")) this.news = {};
  }

  override render(): TemplateResult {
    return html`<div class="fields">
        <button @click=${() => this.go({ show: this.isOfLots ? "all" : "" })}>${icon("left")}${say(this.isOfLots ? "all-lots" : "ask-question-part")}</button>
        <button class="primary" @click=${() => this.frame.contentWindow?.print()}>${say("archive-print")}</button>
        ${FILES.map((kind) => html`<button @click=${() => void this.download(kind)}>${icon("download")}${say(`document-${kind}`)}</button>`)}
        <label>${say("document-paper")}<select @change=${(event: Event) => (this.paper = (event.target as HTMLSelectElement).value as Paper)}>${Object.entries(PAPERS).map(([name, words]) => html`<option value=${name} ?selected=${name === this.paper}>${words}</option>`)}</select></label>
      </div>
      <div role="status">${FILES.map((kind) => (this.news[kind] === undefined ? nothing : html`<p>${this.news[kind]}</p>`))}</div>
      ${this.problem === "" ? nothing : html`<p role="alert">${this.problem}</p>`}
      <iframe class="paper" ?hidden=${this.problem !== ""} @load=${() => void this.loaded()} title=${say("document-title")} sandbox="allow-same-origin allow-modals" src=${this.address("html")}></iframe>`;
  }

  private get isOfLots(): boolean {
    return isOfLots(this.place) && !this.source.isShared;
  }

  private address(kind: Kind | "html"): string {
    const form = { language: language(), paper: this.paper };
    const { from, to, days, hours, lots } = this.place;
    if (this.isOfLots) return `${API}/report.${kind}${queryOf({ lot: lots, weekday: days, hour: hours, from, to, ...form })}`;
    return `${this.source.base}/report.${kind}${queryOf({ ...askedOf(this.place), ...form })}`;
  }

  /** A refusal is shown in no frame: it is asked for again, and said. */
  private async loaded(): Promise<void> {
    this.problem = "";
    if (this.frame.contentDocument !== null) return;
    try {
      await readFile(this.address("html"), "");
    } catch (error) {
      this.problem = wordsOf(error);
    }
  }

  private async download(kind: Kind): Promise<void> {
    const words = say(`document-${kind}`);
    this.news = { ...this.news, [kind]: say("document-writing", { kind: words }) };
    let news: string;
    try {
      const { name, content } = await readFile(this.address(kind), `report.${kind}`);
      saveFile(name, content, content.type);
      news = say("document-saved", { name, size: bytes(content.size) });
    } catch (error) {
      news = `${say("document-refused", { kind: words, why: wordsOf(error) })} ${kind === "pdf" ? say("document-print-instead") : ""}`;
    }
    this.news = { ...this.news, [kind]: news };
  }
}
