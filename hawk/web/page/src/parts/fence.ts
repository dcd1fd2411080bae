/** The editor of fences and outlines, most of the map's code: read after the flight is shown. */
export * from "./map.ts";
export { FenceEditor } from "../map/fence-editor.ts";
