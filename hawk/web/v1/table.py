"""Every address of the API, in the order of its documentation."""

from __future__ import annotations

from http import HTTPStatus
from typing import TYPE_CHECKING, Any, Final

from hawk.exports.formats import CONTENT_TYPES
from hawk.exports.formats import FEEDS as ALL_FEEDS
from hawk.lots import answers as lots
from hawk.lots.documents.arrival import ArrivalList
from hawk.lots.documents.lot_document import LotDocument
from hawk.lots.documents.survey_document import SurveyDocument
from hawk.lots.plan import answers as plans
from hawk.lots.plan_import.answers import PlanPreview
from hawk.replay.film import Film
from hawk.report.options import CONTENT_TYPES as REPORT_TYPES
from hawk.report.options import Kind
from hawk.runtime.late import late_functions
from hawk.stats import answers as figures
from hawk.stats.changes import Changed
from hawk.stats.figures import Figures
from hawk.stats.hour_use import AskedUse
from hawk.store.recording_request import ASKED
from hawk.web.v1 import bodies, day_plan, exports, links, parameters, plan_files, reports
from hawk.web.v1.answers import GEOJSON, JSON, Prepare, Read, keep_missing_looks, reader
from hawk.web.v1.bodies import Given
from hawk.web.v1.changes import FOR_OPERATORS, Change, Work, changer, poster
from hawk.web.v1.desk import arrivals, documents, inbox
from hawk.web.v1.features import answers as shapes
from hawk.web.v1.features import parameters as forms
from hawk.web.v1.features.parameters import ROOT as FEATURES_ROOT
from hawk.web.v1.operations import Bound, Operation
from hawk.web.v1.parameters import Query
from hawk.web.v1.recordings import files as recordings
from hawk.web.v1.recordings import films
from hawk.web.v1.recordings import requests as recording_requests

if TYPE_CHECKING:
    from hawk.web.v1 import commands, reads
    from hawk.web.v1.features import reads as features
else:
    commands, features, reads = (
        late_functions(f"hawk.web.v1.{name}") for name in ("commands", "features.reads", "reads")
    )

LOTS: Final = "Lots"
SURVEYS: Final = "Surveys"
STATISTICS: Final = "Statistics"
CHANGES: Final = "Changes"
PLANS: Final = "Plans"
RECORDINGS: Final = "Recordings"
LINKS: Final = "Links"
SHARED: Final = "Read by a link"
FEATURES: Final = "OGC API Features"
FEEDS: Final = "Feeds and files"
_ANY_FILE: Final = "application/octet-stream"
_FILES: Final = tuple(each.partition(";")[0] for each in CONTENT_TYPES.values())
"""Types of a survey's files."""
_FEED_TYPES: Final = tuple(each.content_type for each in ALL_FEEDS.values())
_NAMED: Final = "; ".join(f"`{name}`, {feed.title}" for name, feed in ALL_FEEDS.items())


_REPORTS: Final[dict[Kind, str]] = {"html": "a document", "pdf": "PDF", "xlsx": "a workbook"}
_REPORT_LIMITS: Final[dict[Kind, str]] = {"html": "", "pdf": "; 409 in flight", "xlsx": "; 409 in flight"}


def _read(
    path: str, name: str, text: str, tag: str, read: Read, answer: type[Any], query: type[Query] = Query,
    prepare: Prepare | None = None, *, is_timed: bool = False, bound: Bound | None = None,
) -> Operation:  # fmt: skip
    handler = reader(query, read, prepare, is_timed=is_timed)
    return Operation("GET", path, name, text, tag, handler, answer, query, bound=bound)


def _change(
    path: str, name: str, text: str, tag: str, change: Change, body: type[Given], answer: type[Any],
    bound: Bound | None = None,
) -> Operation:  # fmt: skip
    return Operation("POST", path, name, text, tag, changer(body, change), answer, body=body, bound=bound)


def _post(
    path: str, name: str, text: str, tag: str, work: Work, body: type[Given], answer: type[Any],
    for_operators: str = FOR_OPERATORS, bound: Bound | None = None,
) -> Operation:  # fmt: skip
    return Operation("POST", path, name, text, tag, poster(body, work, for_operators), answer, body=body, bound=bound)


def _file(path: str, name: str, text: str, bound: Bound | None = None) -> Operation:
    return Operation("POST", path, name, text, PLANS, plan_files.preview, PlanPreview, plan_files.ImportChoices,
                     takes_file=True, bound=bound)  # fmt: skip


def _features(
    path: str, name: str, text: str, read: Read, answer: type[Any], query: type[Query] = Query,
    content_type: str = JSON, *, bound: Bound,
) -> Operation:  # fmt: skip
    handler = reader(query, read, bad_parameter=HTTPStatus.BAD_REQUEST)
    return Operation("GET", f"{FEATURES_ROOT}{path}", name, text, FEATURES, handler, answer, query,
                     content_types=(content_type,), bound=bound)  # fmt: skip


def _of_lot(by_link: bool) -> tuple[Operation, ...]:
    """Return the reads of one lot over its surveys: by its id, or by the token of a link."""
    bound = Bound.LINK if by_link else Bound.LOT

    def one(
        path: str, name: str, text: str, tag: str, read: Read, answer: type[Any], query: type[Query] = Query,
        prepare: Prepare | None = None, content_type: str = JSON,
    ) -> Operation:  # fmt: skip
        handler = reader(query, read, prepare, lot_of=links.lot_of if by_link else None)
        whole, called = ("/shared/{token}", f"shared_{name}") if by_link else ("/lots/{id}", name)
        return Operation("GET", f"{whole}{path}", called, text, SHARED if by_link else tag, handler, answer, query,
                         content_types=(content_type,), is_open=by_link, bound=bound)  # fmt: skip

    def file(kind: Kind, called: str) -> Operation:
        whole = "/shared/{token}" if by_link else "/lots/{id}"
        return Operation(
            "GET", f"{whole}/report.{kind}", f"{'shared_' if by_link else ''}report_{kind}",
            f"Report of a lot's use as {called}{_REPORT_LIMITS[kind]}",
            SHARED if by_link else STATISTICS, reports.handler(kind, links.lot_of if by_link else None), None,
            parameters.ReportQuery, content_types=(REPORT_TYPES[kind].partition(";")[0],), is_open=by_link,
            bound=bound,
        )  # fmt: skip

    return (
        one("/observations", "observations", "Looks of all surveys at the stalls of a lot", SURVEYS,
            reads.observations, lots.ObservationList, parameters.Observations),
        one("/surveys/{survey}/stalls", "survey_stalls", "A survey of a lot with its stalls, as its GeoJSON file",
            SURVEYS, reads.survey_stalls, shapes.SurveyStalls, content_type=GEOJSON),
        one("/surveys/{survey}/sections", "sections_seen", "Sections of a lot with what one survey saw of each",
            SURVEYS, reads.sections_seen, lots.SeenSections),
        one("/surveys/{survey}/map", "survey_map", "Stalls of a survey of a lot as the page draws them", SURVEYS,
            reads.survey_on_map, shapes.SurveyMap),
        one("/statistics", "statistics", "Figures of a lot's use, as `hawk-drone stats --json` prints them",
            STATISTICS, reads.statistics, Figures, parameters.Statistics, keep_missing_looks),
        one("/statistics/ask", "ask", "Use of parts of a lot at some hours of the week; `hawk-drone stats` prints it",
            STATISTICS, reads.ask, AskedUse, parameters.UseQuery, keep_missing_looks),
        one("/statistics/surveys", "surveys_use", "Surveys of a lot, each with its share of taken stalls", STATISTICS,
            reads.surveys_use, figures.SurveysUse, parameters.SurveysOf, keep_missing_looks),
        one("/statistics/stalls", "stalls_use", "Stalls of a lot by the share of surveys that found them taken",
            STATISTICS, reads.stalls_use, figures.StallsUse, parameters.Period, keep_missing_looks),
        one("/statistics/between", "between", "Changes of a lot's stalls from one survey to another one", STATISTICS,
            reads.between, Changed, parameters.Between, keep_missing_looks),
        *(file(kind, called) for kind, called in _REPORTS.items()),
    )  # fmt: skip


_READS: Final = (
    _read("/lots", "lots", "Lots, the oldest first", LOTS, reads.lots, lots.LotList, parameters.Listed,
          is_timed=True, bound=Bound.LISTED),
    _read("/lots/places", "lot_places", "All lots with their places, as the page shows them", LOTS,
          reads.places_of_lots, shapes.LotPlaces, is_timed=True, bound=Bound.LISTED),
    _read("/lots/{id}", "lot", "A lot", LOTS, reads.lot, lots.Lot, is_timed=True, bound=Bound.LOT),
    _read("/lots/{id}/layouts", "layouts", "Versions of a lot's layout, the first one first", LOTS, reads.layouts,
          lots.LayoutList, parameters.Listed, bound=Bound.LOT),
    _read("/lots/{id}/layouts/{version}/stalls", "layout_stalls", "Stalls of a version of a lot's layout, as they were",
          LOTS, reads.stalls_of_layout, lots.PlacedStallList, parameters.Listed, bound=Bound.LOT),
    _read("/lots/{id}/stalls", "stalls", "Stalls of a lot's plan with the last look at each", LOTS, reads.stalls,
          lots.StallList, parameters.Stalls, bound=Bound.LOT),
    _read("/stalls/{id}", "stall", "A stall of any layout", LOTS, reads.stall, lots.Stall, bound=Bound.STALL),
    _read("/lots/{id}/zones", "zones", "Zones of a lot's plan, and areas without stalls", LOTS, reads.zones,
          lots.ZoneList, parameters.Listed, bound=Bound.LOT),
    _read("/lots/{id}/sections", "sections", "Sections of a lot's plan with the newest look at each", LOTS,
          reads.sections, lots.SectionList, parameters.Listed, bound=Bound.LOT),
    _read("/surveys", "surveys", "Surveys of all lots, and of none", SURVEYS, reads.surveys, lots.SurveyList,
          parameters.Surveys, bound=Bound.LISTED),
    _read("/lots/{id}/surveys", "lot_surveys", "Surveys of a lot", SURVEYS, reads.surveys, lots.SurveyList,
          parameters.Surveys, bound=Bound.LOT),
    _read("/surveys/{id}", "survey", "A survey", SURVEYS, reads.survey, lots.Survey, bound=Bound.SURVEY),
    _read("/lots/{id}/comparison", "comparison", "Newest registered survey of a lot beside its layout", SURVEYS,
          reads.comparison, lots.Comparison, bound=Bound.LOT),
    _read("/surveys/{id}/places", "survey_places", "Places where a survey in doubt may lie, with its stalls at each",
          SURVEYS, reads.places, lots.PossiblePlaces, bound=Bound.SURVEY),
    _read("/surveys/{id}/observations", "survey_observations", "Looks of a survey at the stalls of its lot", SURVEYS,
          reads.observations_of_survey, lots.ObservationList, parameters.Listed, bound=Bound.SURVEY),
    _read("/surveys/{id}/sections", "survey_sections", "Looks of a survey at the sections of its lot", SURVEYS,
          reads.sections_of_survey, lots.SectionLookList, parameters.Listed, bound=Bound.SURVEY),
    _read("/surveys/{id}/vehicles", "survey_vehicles", "Vehicles of a survey by the ground that they stand on", SURVEYS,
          reads.vehicles_of_survey, lots.VehicleCounts, bound=Bound.SURVEY),
    *_of_lot(False),
)  # fmt: skip

_LOTS_REPORTS: Final = tuple(
    Operation(
        "GET", f"/report.{kind}", f"lots_report_{kind}",
        f"Report over several lots as {called}; 409 in flight",
        STATISTICS, reports.lots_handler(kind), None, parameters.LotsReportQuery,
        content_types=(REPORT_TYPES[kind].partition(";")[0],), bound=Bound.LISTED,
    )
    for kind, called in _REPORTS.items()
)  # fmt: skip

_CHANGES: Final = (
    _read("/changes", "changes", "Changes that persons made, the newest first", CHANGES, reads.changes,
          lots.ChangeList, parameters.Changes, bound=Bound.LISTED),
    _read("/lots/{id}/proposals", "proposals", "What the newest surveys of a lot propose to change of its layout",
          CHANGES, reads.proposals, lots.Proposals, bound=Bound.LOT),
    _change("/changes/{seq}/undo", "undo", "Undo a change, once", CHANGES, commands.undo, bodies.Nothing,
            lots.Undone, bound=Bound.CHANGE),
    _change("/lots/{id}/name", "rename", "Name a lot", CHANGES, commands.rename, bodies.LotName, lots.Done,
            bound=Bound.LOT),
    _change("/lots/{id}/time-zone", "choose_time_zone", "Say a lot's time zone", CHANGES, commands.choose_time_zone,
            bodies.LotTimeZone, lots.Done, bound=Bound.LOT),
    _change("/lots/{id}/merge", "merge", "Merge another lot into this one", CHANGES, commands.merge, bodies.LotMerge,
            lots.Done),
    _change("/lots/{id}/split", "split", "Make a lot of its own of a part of a lot", CHANGES, commands.split,
            bodies.LotSplit, lots.Done),
    _change("/lots/{id}/pin", "pin", "Pin a lot to its place on Earth", CHANGES, commands.pin, bodies.LotPin,
            lots.Pinned, bound=Bound.LOT),
    _change("/lots/{id}/take-over", "take_over", "Take proposals over into the layout", CHANGES, commands.take_over,
            bodies.TakeOver, lots.Done, bound=Bound.LOT),
    _change("/lots/{id}/drop", "drop", "Drop proposals", CHANGES, commands.drop, bodies.Chosen, lots.Done,
            bound=Bound.LOT),
    _change("/surveys/{id}/move", "move_survey", "Move a survey to another lot, or to a new one", CHANGES,
            commands.move, bodies.SurveyMove, lots.Done),
    _change("/surveys/{id}/delete", "delete_survey", "Delete a survey of a lot; undoing brings it back", CHANGES,
            commands.delete, bodies.Nothing, lots.Done, bound=Bound.SURVEY),
    _change("/surveys/{id}/place", "place_survey", "Choose the place of a survey whose place is not certain", CHANGES,
            commands.choose, bodies.Choose, lots.Done, bound=Bound.SURVEY),
)  # fmt: skip

_PLANS: Final = (
    _read("/lots/{id}/plan", "plan", "Plan of a lot: all of it, its changes since a revision, or an earlier version",
          PLANS, reads.plan, plans.Plan, parameters.PlanPart, bound=Bound.LOT),
    _change("/lots/{id}/edit", "open_edit", "Open an edit of a lot's plan, or go on with one's own", PLANS,
            commands.open_edit, bodies.OpenEdit, plans.Opened, bound=Bound.LOT),
    _change("/lots/{id}/plan", "edit_plan", "Do an operation on the plan", PLANS, commands.edit_plan, bodies.Do,
            plans.Edited, bound=Bound.LOT),
    _change("/lots/{id}/plan/undo", "undo_step", "Undo the newest operation of the edit", PLANS, commands.undo_step,
            bodies.InEdit, plans.Stepped, bound=Bound.LOT),
    _change("/lots/{id}/plan/redo", "redo_step", "Do the operation again that was undone last", PLANS,
            commands.redo_step, bodies.InEdit, plans.Stepped, bound=Bound.LOT),
    _change("/lots/{id}/edit/close", "close_edit", "Close the edit: its version of the layout is final", PLANS,
            commands.close_edit, bodies.CloseEdit, plans.Closed, bound=Bound.LOT),
    _file("/lots/{id}/plan/import", "preview_plan", "Read a file with a plan of a lot; nothing is written",
          bound=Bound.LOT),
    _post("/lots/{id}/plan/import/{preview}/take", "take_plan", "Take a plan that was read, within the edit", PLANS,
          plan_files.take, bodies.TakePlan, plans.Edited, bound=Bound.LOT),
    _file("/lots/import", "preview_lot", "Read a file with the plan of a new lot; nothing is written"),
    _post("/lots/import/{preview}/take", "begin_lot", "Make a lot of a plan that was read", PLANS, plan_files.begin,
          bodies.BeginLot, lots.Begun),
)  # fmt: skip

_LINKS: Final = (
    Operation("GET", "/lots/{id}/shares", "links", "Links to a lot, without their tokens", LINKS, links.listed,
              lots.SharedLinks, bound=Bound.LOT),
    _change("/lots/{id}/shares", "make_link", "Make a link by which others read a lot for some days", LINKS,
            commands.share, bodies.LinkDays, lots.SharedLink, bound=Bound.LOT),
    _change("/shares/{id}/take-back", "take_back_link", "Take a link back: it opens nothing from now on", LINKS,
            commands.take_back, bodies.Nothing, lots.TakenBack, bound=Bound.SHARE),
    *_of_lot(True),
)  # fmt: skip

_RECORDINGS: Final = (
    Operation("GET", "/recordings", "recordings", "Recordings on the drone's disk, the oldest first", RECORDINGS,
              recordings.listed, bodies.RecordingList, parameters.Listed),
    Operation("GET", "/recordings/{name}", "recording", "A recording, or the part of it that `Range` names; 409 in "
              "flight", RECORDINGS, recordings.download, None, content_types=(_ANY_FILE,), has_tag=False,
              for_operators=True),
    Operation("GET", "/recordings/{name}/film", "film", "Time line of a recording; 409 in flight", RECORDINGS,
              films.film, Film),
    Operation("GET", "/recordings/{name}/film/pictures/{number}", "film_picture", "A picture of a recording",
              RECORDINGS, films.picture, None, content_types=("image/jpeg",)),
    Operation("GET", "/recordings/{name}/film/maps/{number}", "film_map", "Stalls of a recording as they were known "
              "at a time", RECORDINGS, films.recorded_map, None, content_types=(GEOJSON,)),
    Operation("GET", "/surveys/{id}/recordings", "recordings_of_survey", "Recordings of a drone's survey, as far as "
              "they came", RECORDINGS, recording_requests.read, bodies.RecordingsOfSurvey),
    _post("/surveys/{id}/recordings/ask", "ask_recordings", "Ask the drone of a survey for its recordings, or not",
          RECORDINGS, recording_requests.ask, bodies.RecordingRequest, bodies.RecordingsOfSurvey,
          recording_requests.FOR_OPERATORS),
    Operation("PUT", "/surveys/{id}/recordings", "offer_recordings", "Say which recordings there are of a survey that "
              f"the header `{ASKED}` of changed lots names", RECORDINGS,
              recording_requests.offer, bodies.OfferState, body=bodies.RecordingOffer, for_drones=True),
    Operation("PUT", "/surveys/{id}/recordings/{name}", "put_recording_part", "Send a part of one: "
              "`Content-Range` (RFC 9110), and `Repr-Digest` of the whole (RFC 9530)", RECORDINGS,
              recording_requests.put_part, bodies.RecordingState, takes_file=True, for_drones=True),
    _post("/recordings/{name}/keep", "keep_recording", "Set the mark of a recording, or take it away", RECORDINGS,
          recordings.keep, bodies.Keep, bodies.Kept, recordings.FOR_OPERATORS),
    _post("/recordings/{name}/delete", "delete_recording", "Delete a recording, while no drone flies", RECORDINGS,
          recordings.delete, bodies.Nothing, bodies.Deleted, recordings.FOR_OPERATORS),
)  # fmt: skip

_FEEDS: Final = (
    Operation("GET", "/lots/{id}/due", "due", "When surveys of a lot are due, by `[[schedule]]`", SURVEYS, day_plan.due,
               bodies.DueList, parameters.Days, bound=Bound.LOT),
    Operation("GET", "/day-plan", "due_rounds", "Rounds of the next 24 hours by `[[schedule]]`, without a forecast: no "
              "start is proposed; 409 in flight", SURVEYS, day_plan.listed, bodies.DayPlan),
    Operation("POST", "/day-plan", "day_plan", "Propose the rounds of the next 24 hours by `[[schedule]]`, a forecast "
              "and full batteries: nothing starts; 409 in flight", SURVEYS, day_plan.proposed, bodies.DayPlan,
              body=bodies.DayPlanQuery),
    Operation("GET", "/lots/{id}/feeds/{feed}", "feed", f"A lot in the words of a receiver: {_NAMED}", FEEDS,
              exports.feed, None, parameters.FeedOptions, content_types=_FEED_TYPES, bound=Bound.LOT),
    Operation("GET", "/surveys/{id}/ground", "survey_ground", "Where the tiles of a survey's picture lie", SURVEYS,
              exports.survey_ground, lots.SurveyGround, bound=Bound.SURVEY),
    Operation("GET", "/surveys/{id}/ground/whole", "survey_whole", "A survey's picture in one; 204 without one",
              SURVEYS, exports.survey_whole, None, content_types=("image/webp",), bound=Bound.SURVEY),
    Operation("GET", "/surveys/{id}/ground/{row}/{column}", "survey_tile", "A tile of a survey's picture", SURVEYS,
              exports.survey_tile, None, content_types=("image/jpeg",), bound=Bound.SURVEY),
    Operation("GET", "/documents", "arrivals", "Documents and files that drones and programs sent here, and what was "
              "refused, the newest first", SURVEYS,
              arrivals.for_operators(reader(parameters.Arrivals, reads.arrivals)), ArrivalList,
              parameters.Arrivals, for_operators=True),
    Operation("PUT", "/surveys/{id}/document", "put_document", "Send a survey as such a document", SURVEYS,
              documents.put, bodies.SurveyState, body=SurveyDocument, body_type=documents.GZIP, for_drones=True),
    Operation("PUT", "/lots/{id}/document", "put_lot_document", "Send a lot with its plan as a document, packed by "
              "gzip, to a desk that collects; an earlier state changes nothing", LOTS, documents.put_lot,
              bodies.LotState, body=LotDocument, body_type=documents.GZIP, for_drones=True),
    Operation("GET", "/lots/documents", "changed_lots", "Lots that changed, with their plans, as such a document", LOTS,
              documents.changed_lots, None, parameters.ChangedLots, content_types=(documents.GZIP,), has_tag=False),
    Operation("PUT", "/inbox/{file}", "put_picture", "Send a picture or film of a flight into the inbox of a desk, "
              "which maps it; 413 and 507 beyond its limits", SURVEYS, inbox.put, bodies.InboxFile, inbox.InboxPlace,
              takes_file=True, for_drones=True),
    Operation("GET", "/surveys/{id}/files/{kind}", "survey_file", "A survey as a file; 409 where it cannot be drawn",
              FEEDS, exports.survey_file, None, content_types=_FILES, bound=Bound.SURVEY),
)  # fmt: skip

_FEATURES: Final = (
    _features("", "features", "Landing page: links to all that is here", features.landing, shapes.Landing,
              bound=Bound.OPEN),
    _features("/conformance", "conformance", "Parts of the standard that are kept", features.conformance,
              shapes.Conformance, bound=Bound.OPEN),
    _features("/collections", "collections", "The collections: lots, stalls, surveys", features.collections,
              shapes.Collections, bound=Bound.LISTED),
    _features("/collections/{collection}", "collection", "A collection", features.collection, shapes.Collection,
              bound=Bound.LISTED),
    _features("/collections/{collection}/items", "items", "Features of a collection", features.items,
              shapes.FeatureCollection, forms.Items, GEOJSON, bound=Bound.LISTED),
    _features("/collections/{collection}/items/{id}", "item", "A feature", features.item, shapes.LinkedFeature,
              content_type=GEOJSON, bound=Bound.LISTED),
)  # fmt: skip

OPERATIONS: Final[tuple[Operation, ...]] = (
    *_READS, *_LOTS_REPORTS, *_CHANGES, *_PLANS, *_LINKS, *_FEEDS, *_RECORDINGS, *_FEATURES,
)  # fmt: skip
