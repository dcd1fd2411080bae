/**
 * What several parts of the page need. Each of them exports it, so that all reach the same modules, and those become one
 * file: else every set of parts would share a small file of its own, and a browser would ask for a dozen of them.
 */
export * as commandTable from "../command-table.ts";
export * as geojson from "../fence/geojson.ts";
export * as plane from "../fence/plane.ts";
export * as reconnect from "../link/reconnect.ts";
export * as labels from "../map/draw-labels.ts";
export * as geometry from "../map/geometry.ts";
export * as values from "../plan/values.ts";
export * as route from "../route/route.ts";
export * as topBar from "../shell/top-bar.ts";
export * as views from "../shell/views.ts";
export * as flight from "../state/flight.ts";
export * as mapStore from "../state/map-store.ts";
export * as measure from "../state/measure.ts";
export * as pageLanguage from "../state/page-language.ts";
export * as preferences from "../state/preferences.ts";
export * as cssVars from "../ui/css-vars.ts";
export * as pictureWindow from "../ui/picture-window.ts";
export * as saveFile from "../ui/save-file.ts";
export * as startAction from "../ui/start-action.ts";
export * as swatch from "../ui/swatch.ts";
export * as touch from "../ui/touch.ts";
export * as actions from "../words/actions.ts";
export * as control from "../words/control.ts";
export * as drone from "../words/drone.ts";
export * as format from "../words/format.ts";
export * as glance from "../words/glance.ts";
export * as keys from "../words/keys.ts";
export * as plan from "../words/plan.ts";
export * as stall from "../words/stall.ts";
export * as units from "../words/units.ts";
