import type { Layer } from "../state/preferences.ts";
import { say } from "./say.ts";

/** Name of a layer of the map. */
export function layerWords(layer: Layer): string {
  return say(`layer-${layer}`);
}
