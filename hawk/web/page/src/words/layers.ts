import type { Layer } from "../state/preferences.ts";

/** What each layer of the map is called. */
export const LAYER_WORDS: Record<Layer, string> = {
  stalls: "Stalls",
  picture: "Picture of the ground",
  fence: "Fence and zones",
  outline: "Area to explore",
  trail: "Where it flew",
  background: "Background",
};
