import Feature from "ol/Feature.js";
import Polygon from "ol/geom/Polygon.js";
import VectorLayer from "ol/layer/Vector.js";
import VectorSource from "ol/source/Vector.js";
import Fill from "ol/style/Fill.js";
import Stroke from "ol/style/Stroke.js";
import Style from "ol/style/Style.js";
import Text from "ol/style/Text.js";
import type { Stall, StallState } from "../state/map-store.ts";
import { corners } from "./geometry.ts";

/** Above this number of metres a pixel, lines are thin and question marks are left out. */
const FAR = 0.19;

type Styles = Record<StallState, Style>;

/** Stalls as vector shapes. Their symbols differ in more than colour: plain, hatched, dashed with a question mark. */
export class StallsLayer {
  readonly layer: VectorLayer;
  private readonly source = new VectorSource();
  private readonly near: Styles;
  private readonly far: Styles;

  constructor(pixelRatio: number) {
    this.near = styles(pixelRatio, 1.5, true);
    this.far = styles(pixelRatio, 1, false);
    this.layer = new VectorLayer({
      source: this.source,
      style: (feature, resolution) =>
        (resolution > FAR ? this.far : this.near)[feature.get("state") as StallState],
    });
  }

  clear(): void {
    this.source.clear(true);
  }

  /** Puts or changes a stall; a shape that did not change is not drawn again. */
  put(stall: Stall): void {
    const ring = [...corners(stall)];
    const old = this.source.getFeatureById(stall.id);
    if (!old) {
      const feature = new Feature({ geometry: new Polygon([ring]), state: stall.state });
      feature.setId(stall.id);
      this.source.addFeature(feature);
      return;
    }
    const geometry = old.getGeometry();
    if (geometry instanceof Polygon && !sameRing(geometry, ring)) geometry.setCoordinates([ring]);
    if (old.get("state") !== stall.state) old.set("state", stall.state);
  }

  remove(id: number): void {
    const feature = this.source.getFeatureById(id);
    if (feature) this.source.removeFeature(feature);
  }
}

function sameRing(geometry: Polygon, ring: number[][]): boolean {
  const flat = geometry.getFlatCoordinates();
  return ring.every((corner, index) => flat[index * 2] === corner[0] && flat[index * 2 + 1] === corner[1]);
}

function styles(pixelRatio: number, line: number, marks: boolean): Styles {
  const question = new Text({
    text: "?",
    font: "700 14px system-ui, sans-serif",
    fill: new Fill({ color: "#fff" }),
    stroke: new Stroke({ color: "rgba(16,22,28,.8)", width: 2 }),
    overflow: true,
  });
  const dashes = new Stroke({ color: "#fff", width: line, lineDash: [4, 3] });
  return {
    free: new Style({
      fill: new Fill({ color: "rgba(47,143,255,.46)" }),
      stroke: new Stroke({ color: "#e3f1ff", width: line }),
      zIndex: 1,
    }),
    taken: new Style({
      fill: new Fill({ color: hatch(pixelRatio) }),
      stroke: new Stroke({ color: "#e05a00", width: line }),
      zIndex: 2,
    }),
    unknown: new Style({
      fill: new Fill({ color: "rgba(16,22,28,.45)" }),
      stroke: dashes,
      zIndex: 3,
      ...(marks ? { text: question } : {}),
    }),
  };
}

/** Orange stripes at 45°, on a dark ground that makes them readable over any car. */
function hatch(pixelRatio: number): CanvasPattern | string {
  const size = Math.round(6 * pixelRatio);
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = size;
  const context = canvas.getContext("2d");
  if (!context) return "rgba(255,122,26,.5)";
  context.fillStyle = "rgba(16,22,28,.12)";
  context.fillRect(0, 0, size, size);
  context.strokeStyle = "#ff7a1a";
  context.lineWidth = 1.6 * pixelRatio;
  context.beginPath();
  for (const shift of [-size, 0, size]) {
    context.moveTo(shift - 1, size + 1);
    context.lineTo(shift + size + 1, -1);
  }
  context.stroke();
  return context.createPattern(canvas, "repeat") ?? "rgba(255,122,26,.5)";
}
