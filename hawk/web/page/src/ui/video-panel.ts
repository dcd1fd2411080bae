import { html, nothing, type TemplateResult } from "lit";
import { customElement, query, state } from "lit/decorators.js";
import { browserTimers, openBrowserSocket, socketUrl } from "../link/socket.ts";
import { type VideoFrame, VideoLink } from "../link/video.ts";
import * as format from "../words/format.ts";
import { pictureWords, snapshotName } from "../words/picture.ts";
import { say } from "../words/say.ts";
import { OLD_S, type View } from "../words/view.ts";
import { cssVars } from "./css-vars.ts";
import { Part } from "./element.ts";
import { icon, needle } from "./icons.ts";
import { drone } from "./quoting.ts";
import { PictureWindow, pictureWindows } from "./picture-window.ts";
import { saveFile } from "./save-file.ts";

/** The live picture. Stops while nobody sees it: the page is hidden, and no small window shows it. */
@customElement("hawk-video")
export class VideoPanel extends Part {
  @query("canvas") private canvas!: HTMLCanvasElement;
  @state() private small: PictureWindow | null = null;
  open = openBrowserSocket;
  private link: VideoLink | null = null;
  private newest: VideoFrame | null = null;

  override connectedCallback(): void {
    super.connectedCallback();
    const url = socketUrl("video", document.baseURI);
    this.link = new VideoLink(url, this.open, browserTimers, (frame) => this.show(frame));
    document.addEventListener("visibilitychange", this.visibility);
    this.visibility();
  }

  override disconnectedCallback(): void {
    document.removeEventListener("visibilitychange", this.visibility);
    this.small?.close();
    this.link?.stop();
    this.model.picture.left();
    super.disconnectedCallback();
  }

  override render(): TemplateResult {
    const age = this.age();
    const frozen = age !== null && age > OLD_S;
    return html`<section class="video ${frozen ? "frozen" : ""} ${age === null ? "none" : ""}" aria-label=${say("live-video")}>
      <canvas width="16" height="9" role="img" aria-label=${say("camera-picture")}></canvas>
      ${this.tag(age, frozen)} ${this.north()} ${this.over(age, frozen)}
      <div class="buttons">
        <button aria-label=${say("swap-map-video")} @click=${() => this.openPanel("swap")}>${icon("swap")}</button>
        <button aria-label=${say("full-screen")} @click=${() => void this.fullScreen()}>${icon("full")}</button>
        <span class="more">
          <button aria-label=${say("save-picture")} ?disabled=${this.newest === null} @click=${() => this.save()}>${icon("photo")}</button>
          ${this.windowButton()}
        </span>
      </div>
    </section>`;
  }

  private windowButton(): TemplateResult | typeof nothing {
    if (pictureWindows() === null) return nothing;
    const label = this.small ? say("close-small-window") : say("small-window");
    return html`<button aria-label=${label} aria-pressed=${this.small !== null} @click=${() => void this.smallWindow()}>${icon("window")}</button>`;
  }

  private tag(age: number | null, frozen: boolean): TemplateResult | typeof nothing {
    if (age === null) return nothing;
    if (frozen) return html`<span class="tag">${this.simulated ? say("simulation-frozen") : say("frozen")}</span>`;
    return html`<span class="tag"><i></i>${pictureWords(age, this.simulated)}</span>`;
  }

  private north(): TemplateResult | typeof nothing {
    const yaw = this.model.view().heartbeat?.Yaw ?? null;
    if (yaw === null || this.model.picture.shownAt === null) return nothing;
    return html`<span class="north" ${cssVars({ "--turn": `${-yaw}rad` })}>${needle(say("north-in-picture"))}${say("north-letter")}</span>`;
  }

  private over(age: number | null, frozen: boolean): TemplateResult | typeof nothing {
    if (age === null) return overlay(say("no-picture-yet"), cameraWords(this.model.view()));
    return frozen ? overlay(say("picture-is-old", { age: format.age(age) }), say("no-new-picture")) : nothing;
  }

  private age(): number | null {
    return this.model.picture.age(this.model.seconds());
  }

  private async show(frame: VideoFrame): Promise<void> {
    const picture = await createImageBitmap(new Blob([frame.jpeg as BlobPart], { type: "image/jpeg" }));
    if (this.canvas.width !== picture.width) this.canvas.width = picture.width;
    if (this.canvas.height !== picture.height) this.canvas.height = picture.height;
    this.small?.draw(picture);
    this.canvas.getContext("bitmaprenderer")?.transferFromImageBitmap(picture);
    const first = this.newest === null;
    this.newest = frame;
    this.model.picture.shown(frame.captureTime, this.model.seconds());
    this.small?.showAge();
    if (first) this.requestUpdate();
  }

  private readonly visibility = (): void => {
    if (document.hidden && this.small === null) this.link?.stop();
    else this.link?.start();
  };

  private async fullScreen(): Promise<void> {
    if (document.fullscreenElement) await document.exitFullscreen();
    else await this.querySelector("section")?.requestFullscreen();
  }

  /** Saves the newest picture as it came from the drone. */
  private save(): void {
    if (this.newest === null) return;
    const heartbeat = this.model.view().heartbeat;
    const place = { latitude: heartbeat?.Latitude ?? null, longitude: heartbeat?.Longitude ?? null };
    const taken = Date.now() - (this.age() ?? 0) * 1000;
    saveFile(snapshotName(taken, place, this.simulated), this.newest.jpeg as BlobPart, "image/jpeg");
  }

  private async smallWindow(): Promise<void> {
    const windows = pictureWindows();
    if (this.small) this.small.close();
    else if (windows) {
      const age = (): { words: string; old: boolean } => {
        const seconds = this.age();
        return { words: pictureWords(seconds, this.simulated), old: seconds === null || seconds > OLD_S };
      };
      this.small = await PictureWindow.open(windows, age, () => {
        this.small = null;
        this.visibility();
      });
    }
  }

  private get simulated(): boolean {
    return this.model.view().welcome?.Simulation === true;
  }

  private openPanel(name: string): void {
    this.dispatchEvent(new CustomEvent("open-panel", { detail: name, bubbles: true }));
  }
}

function overlay(title: string, text: string | TemplateResult): TemplateResult {
  return html`<div class="over"><b>${title}</b><span>${text}</span></div>`;
}

function cameraWords(view: View): string | TemplateResult {
  const camera = view.heartbeat?.Health.find((item) => item.Name === "camera");
  if (camera && !camera.Healthy) return drone(camera.Reason);
  return view.heartbeat ? say("waiting-for-camera") : say("never-connected-title");
}
