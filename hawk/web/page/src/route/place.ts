export const VIEWS = ["fly", "lots", "compare", "report", "recordings"] as const;
export type ViewName = (typeof VIEWS)[number];
export const BY = ["swipe", "fade", "side"] as const;
export const SHOWN = ["stalls", "document", "links", "all", "arrivals"] as const;
/** Orders of all lots: by name, the fullest first, the one that was seen longest ago first, the one that is due first, by drone. */
export const LOT_ORDERS = ["name", "free", "seen", "due", "drone"] as const;
export type LotOrder = (typeof LOT_ORDERS)[number];
const LONGEST_SEARCH = 100;

/** What the page shows, as it stands behind the address's "#": a link leads there, and "back" goes back. */
export interface Place {
  view: ViewName;
  lot: string;
  survey: string;
  before: string;
  after: string;
  stall: string;
  section: string;
  /** File name of a recording, and seconds of its film. */
  recording: string;
  t: string;
  /** Days, as 2026-05-04; "" without that end. */
  from: string;
  to: string;
  /** Parts of the lot that are asked about, as "row.B": of the rows any, of the zones any, of the kinds any; none: the lot. */
  parts: readonly string[];
  /** Days of the week and hours of the day that are asked about, as "mon-fri" and "7-11"; "" for all. */
  days: string;
  hours: string;
  /** How two surveys are compared, and how much of the later one is shown, 0 to 1; "" as the view begins. */
  by: "" | (typeof BY)[number];
  at: string;
  /** A part of the view beside what it shows first. */
  show: "" | (typeof SHOWN)[number];
  /** Lots of a document of **Lots**; none: all. */
  lots: readonly string[];
  /** Words that all lots are searched for, and their order; "" as the list begins. */
  search: string;
  order: "" | LotOrder;
}

const NOWHERE: Place = { view: "fly", lot: "", survey: "", before: "", after: "", stall: "", section: "", recording: "", t: "", from: "", to: "", parts: [], days: "", hours: "", by: "", at: "", show: "", lots: [], search: "", order: "" };
/** Names behind the view, one after the other: "#/compare/LOT/BEFORE/AFTER". */
const PATHS: Readonly<Record<ViewName, readonly ("lot" | "survey" | "before" | "after" | "recording")[]>> = {
  fly: ["lot"],
  lots: ["lot", "survey"],
  compare: ["lot", "before", "after"],
  report: ["lot"],
  recordings: ["lot", "recording"],
};
const RECORDING = /^[0-9TZ-]{16,24}\.mcap$/;
const SECONDS = /^\d{1,6}(\.\d)?$/;
const PART = /^(row|zone|kind|section)\../;
const DAYS = /^(mon|tue|wed|thu|fri|sat|sun)([,-](mon|tue|wed|thu|fri|sat|sun))*$/;
const SHARE = /^(0|1|\.\d{1,3})$/;
const ID = /^[0-9a-f-]{36}$/;

/** The place that an address names; what cannot be read is left out. */
export function placeOf(hash: string): Place {
  const [path = "", search = ""] = hash.replace(/^#/, "").split("?");
  const [, view, ...ids] = path.split("/");
  const name = VIEWS.find((each) => each === view) ?? NOWHERE.view;
  const place: Place = { ...NOWHERE, view: name };
  for (const [k, key] of PATHS[name].entries()) place[key] = read(ids[k], key === "recording" ? RECORDING : ID);
  const given = new URLSearchParams(search);
  place.stall = read(given.get("stall"), ID);
  place.section = read(given.get("section"), ID);
  place.t = read(given.get("t"), SECONDS);
  place.from = read(given.get("from"), { test: isDay });
  place.to = read(given.get("to"), { test: (to) => isDay(to) && to >= place.from });
  place.parts = given.getAll("part").filter((part) => PART.test(part));
  place.days = read(given.get("days"), { test: (days) => DAYS.test(days) && days.split(",").every((run) => run.length <= 7) });
  place.hours = read(given.get("hours"), { test: isHours });
  place.by = BY.find((each) => each === given.get("by")) ?? "";
  place.at = read(given.get("at"), SHARE);
  place.show = SHOWN.find((each) => each === given.get("show")) ?? "";
  if (isOfLots(place)) {
    const lots = given.getAll("lots");
    place.lots = lots.filter((lot) => ID.test(lot));
    if (place.lots.length < lots.length) place.show = "all"; // no report over other lots than were meant
  }
  if (isOfAll(place)) {
    place.search = (given.get("search") ?? "").slice(0, LONGEST_SEARCH);
    place.order = LOT_ORDERS.find((each) => each === given.get("order")) ?? "";
  }
  return place;
}

/** What an address names that is no place: a day that is none, say. The page says that it is left out. */
export function unreadOf(hash: string): string[] {
  const place = placeOf(hash);
  const [path = "", search = ""] = hash.replace(/^#/, "").split("?");
  const [, view = "", ...ids] = path.split("/");
  const names = PATHS[place.view];
  const lost = ids.filter((id, k) => id !== "" && (names[k] === undefined || place[names[k]] !== id));
  const given = [...new URLSearchParams(search)].filter(([name, value]) => {
    if (name === "part" || name === "lots") return !place[name === "part" ? "parts" : "lots"].includes(value);
    return value !== "" && Object.hasOwn(NOWHERE, name) && place[name as keyof Place] !== value;
  });
  return [...(view === "" || view === place.view ? [] : [view]), ...lost, ...given.map(([name, value]) => `${name}=${value}`)];
}

/** The report over several lots, where another document is of one. */
export function isOfLots({ view, show }: Place): boolean {
  return view === "lots" && show === "document";
}

function isOfAll({ view, show }: Place): boolean {
  return view === "lots" && show === "all";
}

function isDay(text: string): boolean {
  const time = Date.parse(`${text}T00:00Z`);
  return /^\d{4}-\d{2}-\d{2}$/.test(text) && !Number.isNaN(time) && new Date(time).toISOString().startsWith(text);
}

/** Hours as "7-11,16": the end of a run is after its begin. */
function isHours(text: string): boolean {
  return text.split(",").every((run) => {
    const [first = -1, last = first + 1] = run.split("-").map(Number);
    return /^\d{1,2}(-\d{1,2})?$/.test(run) && first < last && last <= 24;
  });
}

function read(value: string | null | undefined, pattern: { test: (value: string) => boolean }): string {
  return value && pattern.test(value) ? value : "";
}

/** The address of a place, with what differs from none. */
export function hashOf(place: Place): string {
  const { stall, section, t, parts, days, hours, from, to, by, at, show } = place;
  const path = [place.view, ...PATHS[place.view].map((key) => place[key])].join("/").replace(/\/+$/, "");
  const { search: words, order } = isOfAll(place) ? place : NOWHERE;
  const given = Object.entries({ stall, section, t, days, hours, from, to, by, at, show, search: words, order }).filter(([, value]) => value !== "");
  const lots = isOfLots(place) ? place.lots : [];
  const search = new URLSearchParams([...parts.map((part) => ["part", part]), ...given, ...lots.map((lot) => ["lots", lot])]).toString();
  return `#/${path}${search && `?${search}`}`;
}
