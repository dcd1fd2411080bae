import { html, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import type { DoubtfulSurvey, PossiblePlaces } from "../api.ts";
import { choosePlace, fetchPlaces } from "../link/lots.ts";
import { isViewer } from "../words/actions.ts";
import * as format from "../words/format.ts";
import { say } from "../words/say.ts";
import { Part } from "./element.ts";
import { drone } from "./quoting.ts";

/** Side of a picture, CSS pixels. */
const SIDE_PX = 220;
const MARGIN_PX = 8;

/** A survey whose place is not certain: the places side by side, for a person to choose. Sends "place-chosen". */
@customElement("hawk-lot-doubt")
export class LotDoubt extends Part {
  @property({ attribute: false }) doubtful!: DoubtfulSurvey;
  @state() private found: PossiblePlaces | null = null;
  @state() private problem = "";
  private askedFor = "";

  override render(): TemplateResult {
    const { ended, why } = this.doubtful;
    return html`<div class="which" role="group" aria-label=${say("where-was-survey")}>
      <span><b>${say("where-was-survey")}</b><span class="sub">${say("survey-of", { when: format.day(ended) })}: ${drone(why)}</span></span>
      <div class="places">${this.found?.places.map((_, place) => this.place(place)) ?? nothing}</div>
      <div class="sub marks"><i class="known"></i> ${say("stalls-of-lot")} <i class="seen"></i> ${say("stalls-of-survey")}</div>
      <div role="alert" class="sub">${this.problem === "" ? nothing : drone(this.problem)}</div>
    </div>`;
  }

  protected override updated(_changed: PropertyValues): void {
    if (this.doubtful.survey !== this.askedFor) {
      this.askedFor = this.doubtful.survey;
      void this.ask();
    }
    for (const canvas of this.querySelectorAll("canvas")) this.draw(canvas, Number(canvas.dataset.place));
  }

  private async ask(): Promise<void> {
    this.found = (await fetchPlaces(this.doubtful.survey)) ?? this.found;
  }

  private place(place: number): TemplateResult {
    const name = say("place-number", { place: place + 1 });
    return html`<figure>
      <canvas data-place=${place} width=${2 * SIDE_PX} height=${2 * SIDE_PX} role="img" aria-label=${name}></canvas>
      ${isViewer(this.model.view()) ? nothing : html`<button aria-label=${say("here-place", { place: place + 1 })} @click=${() => this.choose(place)}>${say("here")}</button>`}
    </figure>`;
  }

  private async choose(place: number): Promise<void> {
    this.problem = await choosePlace(this.doubtful.survey, place);
    if (this.problem === "") this.dispatchEvent(new CustomEvent("place-chosen"));
  }

  /** North is up; all pictures of a survey have the same scale and middle. */
  private draw(canvas: HTMLCanvasElement, place: number): void {
    const context = canvas.getContext("2d");
    const { found } = this;
    const stalls = found?.places[place]?.stalls;
    if (!context || !found || !stalls) return;
    const style = getComputedStyle(this);
    const frame = frameOf([...found.known, ...found.places.flatMap((each) => each.stalls)], canvas.width);
    context.clearRect(0, 0, canvas.width, canvas.height);
    for (const [shapes, name, width] of [
      [found.known, "--edge", 5],
      [stalls, "--plan", 2.5],
    ] as const) {
      context.strokeStyle = style.getPropertyValue(name).trim();
      context.lineWidth = width;
      context.beginPath();
      for (const shape of shapes) trace(context, shape, frame);
      context.stroke();
    }
  }
}

/** North, east, angle, width, length in the lot's frame: metres, radians clockwise from north. */
type Shape = PossiblePlaces["known"][number];

interface Frame {
  north: number;
  east: number;
  /** Pixels a metre. */
  scale: number;
  half: number;
}

/** The square picture that shows all shapes. */
function frameOf(shapes: readonly Shape[], side: number): Frame {
  const norths = shapes.map(([north]) => north);
  const easts = shapes.map(([, east]) => east);
  const reach = Math.max(5, ...shapes.map((shape) => shape[4]));
  const [south, top, west, right] = [Math.min(...norths), Math.max(...norths), Math.min(...easts), Math.max(...easts)];
  const metres = Math.max(top - south, right - west) + reach;
  return { north: (south + top) / 2, east: (west + right) / 2, scale: (side - 2 * MARGIN_PX) / metres, half: side / 2 };
}

function trace(context: CanvasRenderingContext2D, [north, east, angle, width, length]: Shape, frame: Frame): void {
  const [cosine, sine] = [Math.cos(angle), Math.sin(angle)];
  const corners = [[-1, -1], [-1, 1], [1, 1], [1, -1]] as const;
  corners.forEach(([along, across], index) => {
    const up = north + (along * length * cosine - across * width * sine) / 2 - frame.north;
    const aside = east + (along * length * sine + across * width * cosine) / 2 - frame.east;
    const [x, y] = [frame.half + aside * frame.scale, frame.half - up * frame.scale];
    if (index === 0) context.moveTo(x, y);
    else context.lineTo(x, y);
  });
  context.closePath();
}
