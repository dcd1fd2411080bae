// Written by packaging/page_protocol.py from the models of hawk/web/v1: change these and run this again.

/** The survey that features show. `doubt`: why it is not registered. */
export interface AboutSurvey {
  lot_name: string;
  lot_id: string;
  survey_id: string;
  survey_began_utc: string;
  survey_ended_utc: string;
  time_is_sure: boolean;
  registered: boolean;
  doubt: string;
  layout_version: number | null;
  position_uncertainty_m: number | null;
  position_pinned: boolean;
  simulated: boolean;
  software: string;
  survey_kind: "flown" | "picture";
  survey_source: string;
  survey_limits: string;
  stalls: number;
  free: number;
  taken: number;
  unknown: number;
  stalls_blurred: number | null;
}

/** Part of the list of arrivals. */
export interface ArrivalList {
  next: string | null;
  items: ListedArrival[];
}

/** Stalls of any of the ``rows``, of any of the ``zones`` and of any of the ``kinds``, or ``sections``; none named: all stalls. */
export interface Asked {
  weekdays: ("Monday" | "Tuesday" | "Wednesday" | "Thursday" | "Friday" | "Saturday" | "Sunday")[];
  hours: number[];
  rows: string[];
  zones: string[];
  kinds: string[];
  sections: string[];
}

/** Use of what is `asked`, over the surveyed hours that are asked, which count alike. */
export interface AskedUse {
  lot: string;
  name: string;
  clock: string;
  interval: number;
  asked: Asked;
  unit: "stalls" | "places" | "vehicles";
  stalls: number;
  places: number | null;
  days: number;
  hours: number;
  occupancy: Estimate;
  accumulation: Estimate;
  fullest: Cell | null;
  emptiest: Cell | null;
  cells: Cell[];
  others: RowUse[];
  surveys: SurveyShare[];
  left_out: LeftOut[];
}

/** A stall that surveys found where the layout has none. `instead`: stalls that it overlaps. */
export interface BeginProposal {
  id: number;
  north: number;
  east: number;
  angle: number;
  width: number;
  length: number;
  state: "free" | "taken" | "unknown";
  instead: string[];
  corners: [number, number][];
}

/** A stall that the plan would have besides. */
export interface BeginningShape {
  north: number;
  east: number;
  angle: number;
  width: number;
  length: number;
  label: string;
  kind: string;
}

/** A lot that a plan made; `stalls`, `sections`: how many it has. */
export interface Begun {
  seq: number;
  kind: string;
  lot: string;
  stalls: number;
  sections: number;
}

/** Ends between which a figure lies. `high`: null where nothing limits it; `low`: null where nothing is known. */
export interface Bracket {
  low: number | null;
  high: number | null;
}

/** Mean over the dates with a survey in an hour of a weekday; null where nobody flew. `is_asked`: of the question. */
export interface Cell {
  weekday: "Monday" | "Tuesday" | "Wednesday" | "Thursday" | "Friday" | "Saturday" | "Sunday";
  hour: number;
  is_asked: boolean;
  days: number;
  occupancy: Estimate;
  accumulation: Estimate;
}

/** A change that a person made in a `lot`; `surveys`: those that it moved, placed or deleted. `undone`: when it was undone. `kept`: why it cannot be undone now; null for one that can. */
export interface Change {
  seq: number;
  kind: string;
  lot: string;
  surveys: string[];
  who: string;
  made: string;
  undone: string | null;
  kept: string | null;
}

/** Part of the list of changes. */
export interface ChangeList {
  next: string | null;
  items: Change[];
}

/** Changes between two surveys. `compared`: stalls that both saw; `unknown`: those that one of them did not. `free`: by how many more of those compared are free. `came` and `left`: stalls that are taken, free now. `matched`: stalls that were drawn again, compared by their ground; `begin` and `gone` are not compared. */
export interface Changed {
  compared: number;
  unknown: number;
  free: Estimate;
  came: Estimate;
  left: Estimate;
  stalls: StateChange[];
  matched: number;
  begin: StallLabel[];
  gone: StallLabel[];
  sections: SectionChange[];
}

/** A closed edit: `seq` undoes all of it, `layout` is its version; both null where nothing is changed. */
export interface Closed {
  lot: string;
  edit: string;
  seq: number | null;
  layout: number | null;
}

/** Two days of the week by the hours that both have: by how much the second is fuller, a share. */
export interface Compared {
  first: "Monday" | "Tuesday" | "Wednesday" | "Thursday" | "Friday" | "Saturday" | "Sunday";
  second: "Monday" | "Tuesday" | "Wednesday" | "Thursday" | "Friday" | "Saturday" | "Sunday";
  hours: number;
  difference: Estimate;
}

/** Newest registered survey of a lot beside the layout; null where there is none. `found`: stalls that the layout lacks; `missed`: stalls of the layout that it did not find where it saw their ground. */
export interface Comparison {
  survey: string | null;
  found: FoundStall[];
  missed: MissedStall[];
}

/** Mean over the surveyed hours of a day of the week: `days` of them, `hours` in all. */
export interface Day {
  day: "Monday" | "Tuesday" | "Wednesday" | "Thursday" | "Friday" | "Saturday" | "Sunday";
  days: number;
  hours: number;
  occupancy: Estimate;
}

/** Rounds of the next 24 hours: proposed, and started by a person. `sentences`: those of problems and reasons. */
export interface DayPlan {
  rounds: DayRound[];
  problems: string[];
  sentences: SpokenSentence[];
}

/** A flight over some lots. `start`: null where `problem` or `hours` say why it has none. */
export interface DayRound {
  lots: RoundLotName[];
  due: string;
  start: string | null;
  end: string | null;
  seconds: number;
  batteries: number;
  distance_m: number;
  problem: string;
  hours: RoundStart[];
}

/** A recording that was deleted. */
export interface Deleted {
  name: string;
  deleted: boolean;
}

/** A change that was made; its `seq` undoes it. */
export interface Done {
  seq: number;
  kind: string;
  lot: string;
}

/** Reason why the place of a survey is not certain, with the places to choose from. */
export interface Doubt {
  why: string;
  places: PossiblePlace[];
  chosen: number | null;
}

/** A survey whose place a person may choose: the number of places. */
export interface DoubtfulSurvey {
  survey: string;
  ended: string;
  why: string;
  places: number;
}

/** Changes of a plan on a drone, of a plan that was changed here since. `areas`: names of zones and sections. */
export interface DroneProposals {
  drone: string;
  base: string;
  begin: DroneStall[];
  end: DroneStall[];
  change: DroneStall[];
  areas: string[];
}

/** A stall as a drone's plan has it. */
export interface DroneStall {
  id: string;
  label: string;
  corners: [number, number][];
}

/** Moments at which surveys of a lot are due, by the settings; one that has come and is not flown among them. */
export interface DueList {
  items: string[];
}

/** Person who edits a plan, and since when; `layout`: the version that it makes. */
export interface Edit {
  who: string;
  since: string;
  last: string;
  layout: number;
}

/** Changes by an operation. `gone`: stalls that are no part of the plan any more. Zones and sections are all there are. */
export interface Edited {
  undo: number;
  redo: number;
  zones: PlanZone[];
  named_zones: PlanZone[];
  sections: PlanSection[];
  stalls: PlanStall[];
  gone: string[];
  edit: string;
  revision: number;
}

/** A stall of the layout that surveys did not find. */
export interface EndProposal {
  id: string;
  label: string;
  is_confirmed: boolean;
  corners: [number, number][];
}

/** A stall that the plan would have no more. */
export interface EndingShape {
  north: number;
  east: number;
  angle: number;
  width: number;
  length: number;
  label: string;
  id: string;
}

/** A figure with the ends of its interval and the number of surveys behind it; null where nobody flew. */
export interface Estimate {
  value: number | null;
  low: number | null;
  high: number | null;
  surveys: number;
}

/** Figures of a lot's use in a period. `interval`: share of figures whose interval is to hold the true value. `by` says what `parts` are. */
export interface Figures {
  lot: string;
  name: string;
  clock: string;
  interval: number;
  surveys: number;
  first: string | null;
  last: string | null;
  left_out: LeftOut[];
  whole: Use | null;
  by: "hour" | "row" | "zone" | "kind" | "section" | null;
  parts: Use[];
  hours: Hour[];
  days: Day[];
  compared: Compared[];
}

/** A recorded flight by time: `at` is in seconds of the film, places in metres north and east of `datum`. */
export interface Film {
  name: string;
  program: string;
  began: string | null;
  seconds: number;
  clock: ((number | null)[])[];
  problem: string;
  datum: [number, number] | null;
  phases: FilmPhase[];
  messages: FilmMessage[];
  track: ((number | null)[])[];
  battery: ((number | null)[])[];
  counts: ((number | null)[])[];
  homes: ((number | null)[])[];
  footprints: ((number | null)[])[];
  fences: FilmFence[];
  plan: FilmStall[];
  pictures: number[];
  maps: number[];
}

/** The fence from `at` on: its ring, and the zones that the drone keeps out of. */
export interface FilmFence {
  at: number;
  ring: [number, number][];
  zones: [number, number][][];
}

/** A line of the flight's messages. */
export interface FilmMessage {
  at: number;
  level: "info" | "ok" | "warning" | "error";
  text: string;
  details: string;
  sentences: SpokenSentence[];
}

/** A state of the drone, from `at` to the next one. */
export interface FilmPhase {
  at: number;
  state: string;
}

/** A stall of the plan that was flown over; `angle` in radians clockwise from north. */
export interface FilmStall {
  north: number;
  east: number;
  angle: number;
  width: number;
  length: number;
  label: string;
}

/** A stall that a survey found, in the lot's frame, with the number that the survey gave it. */
export interface FoundStall {
  id: number;
  north: number;
  east: number;
  angle: number;
  width: number;
  length: number;
  state: "free" | "taken" | "unknown";
}

/** Polygon or MultiPolygon of [longitude, latitude], degrees. */
export interface Geometry {
  type: "Polygon" | "MultiPolygon";
  coordinates: unknown[];
}

/** Mean over the days with a survey in an hour of the day. An hour that nobody flew has nothing. */
export interface Hour {
  hour: number;
  days: number;
  occupancy: Estimate;
  accumulation: Estimate;
}

/** A file that lies in the inbox. `flight`: its folder there. */
export interface InboxFile {
  name: string;
  flight: string | null;
  bytes: number;
}

/** A recording with its mark. */
export interface Kept {
  name: string;
  keep: boolean;
}

/** A version of a lot's layout. */
export interface Layout {
  version: number;
  valid_from: string;
  who: string;
  why: string;
}

/** Part of the list of layouts. */
export interface LayoutList {
  next: string | null;
  items: Layout[];
}

/** A survey of the period that no figure uses, and why. */
export interface LeftOut {
  survey: string;
  ended: string;
  why: string;
}

/** A feature of the file that is left out, or that clashes, and why. */
export interface LeftOutFeature {
  name: string;
  reason: string;
}

/** Arrival from a drone or a program. `name`: id of the lot, or of the survey, of a recording too; name of the file; method and path of another request; empty for what was erased. */
export interface ListedArrival {
  seq: number;
  at: string;
  sender: string;
  kind: "survey" | "lot" | "file" | "recording" | "other";
  name: string;
  lot: string | null;
  state: number | null;
  outcome: "taken" | "known" | "older" | "waits" | "refused";
  reason: string;
  times: number;
}

/** A link to a lot, without its token. `open`: it opens the lot now. `who`: the person of some lots who made it. */
export interface ListedLink {
  id: string;
  who: string | null;
  made: string;
  ends: string;
  open: boolean;
  taken_back: string | null;
}

/** A lot, with its newest survey. `time_zone`: that of its place, unless a person chose another one. */
export interface ListedLot {
  id: string;
  name: string;
  time_zone: string;
  stalls: number;
  sections: number;
  survey_count: number;
  last_survey: Survey | null;
  due: string | null;
}

/** A section of a plan with its place on Earth and the newest look at it; null where no survey looked. */
export interface ListedSection {
  id: string;
  name: string;
  outline: [number, number][];
  kind: "parallel" | "across" | "";
  length_m: number;
  capacity: number | null;
  is_capacity_given: boolean;
  note: string;
  ground: [number, number][];
  look: SectionLook | null;
}

/** A stall with the last look at it, all null where no survey looked; `survey`: which survey looked. */
export interface ListedStall {
  id: string;
  label: string;
  north: number;
  east: number;
  angle: number;
  width: number;
  length: number;
  kind: "" | "disabled" | "charging" | "parent" | "delivery" | "private" | "motorcycle" | "staff" | "bus" | "hgv" | "taxi";
  is_confirmed: boolean;
  is_named: boolean;
  row: string | null;
  latitude: number;
  longitude: number;
  state: "free" | "taken" | "unknown" | null;
  taken_probability: number | null;
  observed: string | null;
  survey: string | null;
}

/** A lot. `datum`: origin of its frame, north up. `revision` rises with every change of its plan. */
export interface Lot {
  id: string;
  name: string;
  time_zone: string;
  stalls: number;
  sections: number;
  survey_count: number;
  last_survey: Survey | null;
  due: string | null;
  datum: [number, number];
  datum_is_pinned: boolean;
  outline: [number, number][][];
  edit: Edit | null;
  revision: number;
}

/** Part of the list of lots. */
export interface LotList {
  next: string | null;
  items: ListedLot[];
}

/** A lot on the ground of another one. `share`: of the smaller area that both have. */
export interface LotPair {
  lot: string;
  name: string;
  share: number;
}

/** All lots, the oldest first, a list for each value: a fifth of the list of lots. */
export interface LotPlaces {
  ids: string[];
  names: string[];
  latitudes: number[];
  longitudes: number[];
  time_zones: string[];
  stalls: number[];
  survey_counts: number[];
  due: (string | null)[];
  surveys: (string | null)[];
  ended: (string | null)[];
  free: (number | null)[];
  taken: (number | null)[];
  unknown: (number | null)[];
  drones: (string | null)[];
}

/** A lot that was sent as a document: `state` of the document. `keeps_plan`: the plan is another one here. */
export interface LotState {
  lot: string;
  state: number;
  keeps_plan: boolean;
}

/** A stall of the layout. */
export interface MissedStall {
  id: string;
  label: string;
}

/** A survey next to those of an answer. */
export interface NextSurvey {
  id: string;
  at: string;
}

/** Look of a survey at a stall. `picture_count`: pictures behind it. */
export interface Observation {
  survey: string;
  stall: string;
  label: string;
  state: "free" | "taken" | "unknown";
  taken_probability: number;
  observed: string;
  picture_count: number;
}

/** Part of the list of observations. */
export interface ObservationList {
  next: string | null;
  items: Observation[];
}

/** Recordings of a survey that a drone offered. */
export interface OfferState {
  survey: string;
  recordings: RecordingState[];
}

/** An open edit. `undo`, `redo`: operations that can be undone, done again. */
export interface Opened {
  undo: number;
  redo: number;
  edit: string;
  lot: string;
  who: string;
  since: string;
  layout: number;
  revision: number;
}

/** The surveyed hour of highest occupancy. `rivals`: other hours whose interval reaches its own. */
export interface Peak {
  begin: string;
  occupancy: Estimate;
  accumulation: Estimate;
  rivals: number;
}

/** Move of a lot's datum and frame, metres and degrees. `residual`: by how much two points contradict the lot, m. */
export interface Pinned {
  seq: number;
  kind: string;
  lot: string;
  north: number;
  east: number;
  turn: number;
  residual: number;
  datum: [number, number];
}

/** Stalls of a survey at one of its possible places. */
export interface PlacedShapes {
  stalls: [number, number, number, number, number][];
}

/** A stall of a layout, with its row and its place on Earth. */
export interface PlacedStall {
  id: string;
  label: string;
  north: number;
  east: number;
  angle: number;
  width: number;
  length: number;
  kind: "" | "disabled" | "charging" | "parent" | "delivery" | "private" | "motorcycle" | "staff" | "bus" | "hgv" | "taxi";
  is_confirmed: boolean;
  is_named: boolean;
  row: string | null;
  latitude: number;
  longitude: number;
}

/** Part of the list of a layout's stalls. */
export interface PlacedStallList {
  next: string | null;
  items: PlacedStall[];
}

/** A lot's plan: all of it where `whole`, else the stalls that changed after a revision, and the ids of those that are `gone`. `layout`: the version that was asked for, which has neither a `revision` nor an `edit`; null for the present plan. `datum`: origin of the lot's frame, north up. A file with all of it is imported as an owner's plan. */
export interface Plan {
  zones: PlanZone[];
  named_zones: PlanZone[];
  sections: PlanSection[];
  stalls: PlanStall[];
  gone: string[];
  lot: string;
  datum: [number, number];
  layout: number | null;
  revision: number | null;
  edit: Edit | null;
  whole: boolean;
}

/** A layer of a drawing. */
export interface PlanLayer {
  name: string;
  outlines: number;
}

/** Place of a file's plan on the lot: by what it was found, on what; a shift, metres, a turn, degrees. */
export interface PlanPlace {
  by: string;
  on: string;
  is_certain: boolean;
  doubt: string;
  north: number;
  east: number;
  turn: number;
  residual: number;
  accuracy: number | null;
}

/** Effect of an import, which its `token` takes within minutes; nothing is written before. `same` and `same_sections`: stalls and sections that the plan has as the file does. */
export interface PlanPreview {
  token: string;
  lot: string | null;
  file: string;
  format: string;
  crs: string;
  datum: [number, number];
  placed: PlanPlace;
  begin: BeginningShape[];
  stay: StayingShape[];
  same: number;
  end: EndingShape[];
  sections: SectionShape[];
  same_sections: number;
  left_out: LeftOutFeature[];
  left_out_count: number;
  notes: string[];
  clashes: LeftOutFeature[];
  clash_count: number;
  renamed: Renamed[];
  layers: PlanLayer[];
}

/** A section of a plan: a strip along a kerb, or an area, whose parked vehicles are counted against a capacity. */
export interface PlanSection {
  id: string;
  name: string;
  outline: [number, number][];
  kind: "parallel" | "across" | "";
  length_m: number;
  capacity: number | null;
  is_capacity_given: boolean;
  note: string;
}

/** A stall of a plan: its middle, and the direction of its length, radians clockwise from north. */
export interface PlanStall {
  id: string;
  label: string;
  north: number;
  east: number;
  angle: number;
  width: number;
  length: number;
  kind: "" | "disabled" | "charging" | "parent" | "delivery" | "private" | "motorcycle" | "staff" | "bus" | "hgv" | "taxi";
  is_confirmed: boolean;
  is_named: boolean;
}

/** An area of a plan: a zone whose stalls statistics count together, or one without stalls. */
export interface PlanZone {
  id: string;
  name: string;
  outline: [number, number][];
  kind: "" | "disabled" | "charging" | "parent" | "delivery" | "private" | "motorcycle" | "staff" | "bus" | "hgv" | "taxi" | "no_stalls" | "private_ground";
}

/** A place where a survey may lie on its lot: a shift, metres, a turn, radians clockwise, and how well it fits. */
export interface PossiblePlace {
  north: number;
  east: number;
  turn: number;
  score: number;
}

/** Places of a survey's doubt, in their order, with its stalls at each; `known`: stalls of its lot. */
export interface PossiblePlaces {
  survey: string;
  lot: string;
  known: [number, number, number, number, number][];
  places: PlacedShapes[];
}

/** Refusal of a request (RFC 9457): `detail` says what is wrong and the remedy, `field` names the value. */
export interface Problem {
  type: string;
  title: string;
  status: number;
  detail: string;
  field: string;
  who: string;
  since: string | null;
  sentences: SpokenSentence[];
}

/** Changes of a lot's layout that its newest surveys propose, and those that were made on drones. */
export interface Proposals {
  lot: string;
  datum: [number, number];
  surveys: SurveyProposals[];
  drones: DroneProposals[];
  same: LotPair[];
  doubtful: DoubtfulSurvey[];
}

/** Lot of a recorded flight, and the survey of it that the flight made. */
export interface RecordedLot {
  id: string;
  name: string;
  time_zone: string;
  survey: string;
}

/** A recording on this disk. `began` by the clock of the surveys; `drone`: name of the one that sent it here; `keep`: it is never removed for room, nor for its age at `keep_end`. */
export interface Recording {
  name: string;
  bytes: number;
  began: string | null;
  seconds: number | null;
  survey: string | null;
  lot: RecordedLot | null;
  drone: string | null;
  keep: boolean;
  keep_end: string | null;
  under_way: boolean;
}

/** Part of the list of recordings. */
export interface RecordingList {
  items: Recording[];
  next: string | null;
}

/** A recording of which `stored` of `bytes` are here: the next part begins there. */
export interface RecordingState {
  name: string;
  stored: number;
  bytes: number;
}

/** Recordings of a survey that a drone sent. `drone`: its name; null: no drone has flown it and sent it here. `stored` of `bytes` are here; `problem`: why no more comes now. */
export interface RecordingsOfSurvey {
  survey: string;
  drone: string | null;
  state: "none" | "asked" | "coming" | "here" | "never" | "gone";
  stored: number;
  bytes: number | null;
  problem: string;
}

/** A label of the file that another stall keeps, or a name that another section keeps, and the one in its place. */
export interface Renamed {
  label: string;
  to: string;
}

/** A lot of a round. */
export interface RoundLotName {
  id: string;
  name: string;
}

/** A time at which a round could start, and the reasons against it; none where it fits. */
export interface RoundStart {
  at: string;
  reasons: string[];
}

/** Another row, with its stalls of the zones and kinds that are asked, at the same hours. */
export interface RowUse {
  row: string;
  stalls: number;
  occupancy: Estimate;
}

/** A section at two surveys. `is_changed`: the intervals do not meet, so that the numbers of vehicles differ. What a survey did not look at is null. */
export interface SectionChange {
  id: string;
  name: string;
  capacity: number | null;
  before: SectionCounts | null;
  after: SectionCounts | null;
  is_changed: boolean | null;
}

/** Vehicles that a survey counted in a section: `parked`, `least` to `most`. */
export interface SectionCounts {
  parked: number;
  least: number;
  most: number;
}

/** Part of the list of sections. */
export interface SectionList {
  next: string | null;
  items: ListedSection[];
}

/** Look of a survey at a section. `least` to `most` holds the true number of parked vehicles in 90 % of looks. */
export interface SectionLook {
  survey: string;
  section: string;
  name: string;
  observed: string;
  source: "vehicles" | "stalls";
  parked: number;
  least: number;
  most: number;
  capacity: number | null;
  occupancy: number | null;
  room: number | null;
  hidden_share: number;
  seen_share: number;
}

/** Part of the list of a survey's looks at sections. */
export interface SectionLookList {
  next: string | null;
  items: SectionLook[];
}

/** A section that the plan would have besides, otherwise (`stay`), or no more: metres in the frame of the lot. */
export interface SectionShape {
  change: "begin" | "stay" | "end";
  name: string;
  former: string;
  outline: [number, number][];
  kind: "parallel" | "across" | "";
  length_m: number;
  capacity: number | null;
  is_capacity_given: boolean;
  note: string;
}

/** Sections of a lot's plan by their names, with what one survey saw of each; null where it did not look. */
export interface SeenSections {
  survey: string;
  sections: ListedSection[];
}

/** A link to a lot: the page is `/shared#TOKEN`. No later answer holds the `token`. */
export interface SharedLink {
  id: string;
  token: string;
  ends: string;
}

/** All links to a lot, the newest first. */
export interface SharedLinks {
  shares: ListedLink[];
}

/** A sentence of the program: a page that has words of its own for the code shows those. */
export interface SpokenSentence {
  text: string;
  code: string;
  values: Record<string, string | number>;
}

/** A stall of a lot: `begins` is the first version of the layout that has it, `ends` the first that has not. */
export interface Stall {
  id: string;
  label: string;
  north: number;
  east: number;
  angle: number;
  width: number;
  length: number;
  kind: "" | "disabled" | "charging" | "parent" | "delivery" | "private" | "motorcycle" | "staff" | "bus" | "hgv" | "taxi";
  is_confirmed: boolean;
  is_named: boolean;
  row: string | null;
  latitude: number;
  longitude: number;
  state: "free" | "taken" | "unknown" | null;
  taken_probability: number | null;
  observed: string | null;
  survey: string | null;
  lot: string;
  begins: number;
  ends: number | null;
}

/** A stall that the layout of one of two surveys alone has. */
export interface StallLabel {
  id: string;
  label: string;
}

/** Part of the list of stalls. */
export interface StallList {
  next: string | null;
  items: ListedStall[];
}

/** Stalls of a lot in columns: `share` of the `surveys` that saw each in which it was taken, `low` to `high`. */
export interface StallsUse {
  lot: string;
  interval: number;
  surveys_in_period: number;
  ids: string[];
  labels: string[];
  surveys: number[];
  share: (number | null)[];
  low: (number | null)[];
  high: (number | null)[];
}

/** A stall whose state changed. `chance`: probability that both states are right; null where one is unclear. `former`: the stall of the survey before, another one where the plan's was drawn again. */
export interface StateChange {
  id: string;
  label: string;
  former: string;
  before: "free" | "taken" | "unknown";
  after: "free" | "taken" | "unknown";
  chance: number | null;
}

/** A stall of the plan as the file has it; `former`: its label. */
export interface StayingShape {
  north: number;
  east: number;
  angle: number;
  width: number;
  length: number;
  label: string;
  kind: string;
  id: string;
  former: string;
}

/** Number of stalls that every survey saw in one state, and their labels. */
export interface Steady {
  value: number | null;
  low: number | null;
  high: number | null;
  surveys: number;
  stalls: string[];
}

/** Changes by an undo or a redo; `operation` names what was undone or done again. */
export interface Stepped {
  undo: number;
  redo: number;
  zones: PlanZone[];
  named_zones: PlanZone[];
  sections: PlanSection[];
  stalls: PlanStall[];
  gone: string[];
  edit: string;
  revision: number;
  operation: string;
}

/** A survey. `candidates`: the lots that it may be of, while a person has to say it. */
export interface Survey {
  kind: "flown" | "picture";
  source: "" | "photographs" | "orthophoto" | "film";
  source_name: string;
  limits: ("by_gps" | "stretched" | "coarse" | "partly")[];
  id: string;
  layout: number | null;
  placed: "first" | "registered" | "unregistered" | "undecided" | "nothing" | "deleted";
  free: number;
  taken: number;
  unknown: number;
  found: number;
  blurred: number | null;
  simulated: boolean;
  program: string;
  began: string;
  ended: string;
  seq: number;
  lot: string | null;
  drone: string | null;
  datum: [number, number];
  place: SurveyPlace | null;
  doubt: Doubt | null;
  time_is_sure: boolean;
  candidates: string[];
}

/** A lot or a stall; a stall that is not registered has the number that its survey gave it for an id. */
export interface SurveyFeature {
  type: "Feature";
  id: string;
  geometry: Geometry;
  properties: Record<string, unknown>;
}

/** Picture of the ground that a survey mapped, as square tiles of JPEG in the survey's own frame. */
export interface SurveyGround {
  datum: [number, number];
  place: SurveyPlace;
  cells: number;
  cell_m: number;
  tiles: [number, number][];
}

/** Part of the list of surveys. */
export interface SurveyList {
  next: string | null;
  items: Survey[];
}

/** Stalls of a survey as the page draws them, a list for each value: a fifth of the GeoJSON. */
export interface SurveyMap {
  origin: [number, number];
  ids: string[];
  labels: string[];
  states: ("free" | "taken" | "unknown")[];
  taken: (number | null)[];
  corners: number[];
}

/** Move that brings a survey's frame onto its lot's: a shift, metres, and a turn, radians clockwise. */
export interface SurveyPlace {
  north: number;
  east: number;
  turn: number;
}

/** Changes of the layout that a survey proposes. */
export interface SurveyProposals {
  survey: string;
  ended: string;
  begin: BeginProposal[];
  end: EndProposal[];
}

/** A survey behind an answer, with the share that was taken at its moment of what is asked. */
export interface SurveyShare {
  survey: string;
  at: string;
  occupancy: Estimate;
  accumulation: Estimate;
}

/** A survey with its stalls, as its GeoJSON file has them. */
export interface SurveyStalls {
  type: "FeatureCollection";
  hawk: AboutSurvey;
  features: SurveyFeature[];
}

/** A survey that was sent as a document: its newest state here, and its lot. */
export interface SurveyState {
  survey: string;
  state: number;
  lot: string | null;
}

/** A survey with its share of taken stalls. `left_out`: why no figure uses it; empty where figures do. */
export interface SurveyUse {
  kind: "flown" | "picture";
  source: "" | "photographs" | "orthophoto" | "film";
  source_name: string;
  limits: ("by_gps" | "stretched" | "coarse" | "partly")[];
  id: string;
  layout: number | null;
  placed: "first" | "registered" | "unregistered" | "undecided" | "nothing" | "deleted";
  free: number;
  taken: number;
  unknown: number;
  found: number;
  blurred: number | null;
  simulated: boolean;
  program: string;
  began: string;
  ended: string;
  at: string;
  accuracy: number | null;
  occupancy: Estimate;
  left_out: string;
  left_out_code: "" | "unregistered" | "no_time" | "no_looks";
}

/** Surveys of a lot in a period, the newest first. `before`, `after`: the surveys next to these. */
export interface SurveysUse {
  lot: string;
  name: string;
  clock: string;
  interval: number;
  surveys: SurveyUse[];
  before: NextSurvey | null;
  after: NextSurvey | null;
}

/** A link that opens nothing from now on. */
export interface TakenBack {
  id: string;
  taken_back: boolean;
}

/** Cars that came to a group of stalls in the `hours` between surveys, and how long they stayed. */
export interface Turnover {
  hours: number;
  pairs: number;
  open_pairs: number;
  arrivals: Bracket;
  per_stall_hour: Bracket;
  stay_hours: Bracket;
}

/** A change that was undone. */
export interface Undone {
  seq: number;
  kind: string;
}

/** Use of a part of the lot, or of all of it, over the surveyed hours of a period. */
export interface Use {
  name: string;
  capacity: number | null;
  surveys: number;
  hours: number;
  occupancy: Estimate;
  accumulation: Estimate;
  load_space_hours: Estimate;
  peak: Peak | null;
  above: Record<string, Estimate>;
  never_taken: Steady;
  always_taken: Steady;
  turnover: Turnover;
  unit: "stalls" | "places" | "vehicles";
}

/** Vehicles of a survey by the ground that they stand on, each counted once; null where that is not known. */
export interface VehicleCounts {
  survey: string;
  vehicles: number | null;
  on_stalls: number | null;
  in_sections: number | null;
  beside: number | null;
  elsewhere: number | null;
}

/** An area of a plan: one without stalls, or one that statistics count by itself, for a kind of stalls. */
export interface Zone {
  id: string;
  name: string;
  kind: "" | "disabled" | "charging" | "parent" | "delivery" | "private" | "motorcycle" | "staff" | "bus" | "hgv" | "taxi";
  has_stalls: boolean;
  is_private: boolean;
  outline: [number, number][];
  ground: [number, number][];
}

/** Part of the list of zones. */
export interface ZoneList {
  next: string | null;
  items: Zone[];
}
