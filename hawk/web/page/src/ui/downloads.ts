import { html, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import { type Download, fetchDownloads } from "../link/downloads.ts";
import * as format from "../words/format.ts";
import { say } from "../words/say.ts";
import { Part } from "./element.ts";
import { icon } from "./icons.ts";
import { drone } from "./quoting.ts";

const FILES = [
  ["stalls.csv", "file-table", "CSV"],
  ["stalls.geojson", "file-stalls", "GeoJSON"],
  ["lot.jpg", "file-picture", "JPEG"],
  ["recording.mcap", "file-recording", "MCAP"],
] as const;

/** The survey's result as files, with their sizes. */
@customElement("hawk-downloads")
export class Downloads extends Part {
  @state() private files: Map<string, Download> | null = null;
  private askedFor = "";

  override render(): TemplateResult {
    return html`<section class="downloads" aria-label=${say("downloads")}>${FILES.map(([name, title, kind]) => this.file(name, say(title), kind))}</section>`;
  }

  /** Asks again when another flight has ended or the map has changed; in flight it changes all the time. */
  protected override updated(): void {
    const { heartbeat, landedAt } = this.model.view();
    const wanted = heartbeat?.Armed === true ? "flying" : JSON.stringify([landedAt, heartbeat?.Free, heartbeat?.Taken, heartbeat?.Unknown]);
    if (wanted === this.askedFor) return;
    this.askedFor = wanted;
    void fetchDownloads().then((files) => {
      if (wanted === this.askedFor) this.files = files;
    });
  }

  private file(name: string, title: string, kind: string): TemplateResult {
    const known = this.files?.get(name);
    if (known?.bytes === null) {
      return html`<div class="button off">${icon("download")}<span><b>${title}</b><span class="sub">${drone(known.reason)}</span></span></div>`;
    }
    const size = known === undefined ? kind : say("file-kind-size", { kind, size: format.bytes(known.bytes) });
    return html`<a class="button" href="api/${name}" download>${icon("download")}<span><b>${title}</b><span class="sub">${size}</span></span></a>`;
  }
}
