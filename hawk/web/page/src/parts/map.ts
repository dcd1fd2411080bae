/** The map with the editor of plans, as Fly, the views of lots and the editor of fences share it: one file. */
export * from "./shared.ts";
export * as lotMap from "../map/lot-map.ts";
export * as planOnMap from "../map/plan-on-map.ts";
export * as sectionsLayer from "../map/sections-layer.ts";
export * as planPanel from "../ui/plan-panel.ts";
export * as planTools from "../ui/plan-tools.ts";
export * as sectionsTable from "../ui/sections-table.ts";
