/** The views of lots that have a map: surveys, and recordings that are played. */
export * from "./map.ts";
import "../replay/film-view.ts";
import "../views/all-lots-view.ts";
import "../views/compare-view.ts";
import "../views/lot-views.ts";
import "../views/recordings-view.ts";
import "../views/stalls-view.ts";
import "../views/surveys-view.ts";
