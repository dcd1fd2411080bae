/** The views of lots without a map: it is not read for them. */
export * from "./shared.ts";
import "../views/arrivals-view.ts";
import "../views/ask-view.ts";
import "../views/document-view.ts";
import "../views/links-view.ts";
import "../views/lot-views.ts";
import "../views/recordings-view.ts";
