"""Every address of the API, in the order of its documentation."""

from __future__ import annotations

from http import HTTPStatus
from typing import Final

from pydantic import BaseModel

from hawk.web import links, lots, plan_files, plans, recordings
from hawk.web.lot_answers import Change
from hawk.web.v1 import asked, bodies, changing, features, figures, importing, models, reads, shapes
from hawk.web.v1 import features_asked as forms
from hawk.web.v1 import links as of_links
from hawk.web.v1.answering import JSON, Prepare, Read, reader
from hawk.web.v1.asked import Query
from hawk.web.v1.bodies import Given
from hawk.web.v1.changing import changer, of_recordings
from hawk.web.v1.features_asked import ROOT as FEATURES_ROOT
from hawk.web.v1.models import Shown
from hawk.web.v1.operations import Operation
from hawk.web.v1.reads import GEOJSON

LOTS: Final = "Lots"
SURVEYS: Final = "Surveys"
STATISTICS: Final = "Statistics"
CHANGES: Final = "Changes"
PLANS: Final = "Plans"
RECORDINGS: Final = "Recordings"
LINKS: Final = "Links"
SHARED: Final = "Read by a link"
FEATURES: Final = "OGC API Features"


def _read(
    path: str, name: str, text: str, tag: str, read: Read, answer: type[Shown], query: type[Query] = Query,
    prepare: Prepare | None = None,
) -> Operation:  # fmt: skip
    return Operation("GET", path, name, text, tag, reader(query, read, prepare), answer, query)


def _change(
    path: str, name: str, text: str, tag: str, change: Change, body: type[Given], answer: type[Shown]
) -> Operation:  # fmt: skip
    return Operation("POST", path, name, text, tag, changer(body, change), answer, body=body)


def _file(path: str, name: str, text: str) -> Operation:
    return Operation("POST", path, name, text, PLANS, importing.preview, bodies.PlanPreview, importing.ImportChoices,
                     takes_file=True)  # fmt: skip


def _features(
    path: str, name: str, text: str, read: Read, answer: type[BaseModel], query: type[Query] = Query,
    content_type: str = JSON,
) -> Operation:  # fmt: skip
    handler = reader(query, read, bad_parameter=HTTPStatus.BAD_REQUEST)
    return Operation("GET", f"{FEATURES_ROOT}{path}", name, text, FEATURES, handler, answer, query,
                     content_type=content_type)  # fmt: skip


def _of_lot(by_link: bool) -> tuple[Operation, ...]:
    """Return the reads of one lot over its surveys: by its id, or by the token of a link."""

    def one(
        path: str, name: str, text: str, tag: str, read: Read, answer: type[Shown], query: type[Query] = Query,
        prepare: Prepare | None = None, content_type: str = JSON,
    ) -> Operation:  # fmt: skip
        handler = reader(query, read, prepare, lot_of=links.lot_of if by_link else None)
        whole, called = ("/shared/{token}", f"shared_{name}") if by_link else ("/lots/{id}", name)
        return Operation("GET", f"{whole}{path}", called, text, SHARED if by_link else tag, handler, answer, query,
                         content_type=content_type, is_open=by_link)  # fmt: skip

    return (
        one("/observations", "observations", "Looks of all surveys at the stalls of a lot", SURVEYS,
            reads.observations, models.ObservationList, asked.Observations),
        one("/surveys/{survey}/stalls", "survey_stalls", "A survey of a lot with its stalls, as its GeoJSON file",
            SURVEYS, reads.survey_stalls, shapes.SurveyStalls, content_type=GEOJSON),
        one("/statistics", "statistics", "Figures of a lot's use, as `hawk-drone stats --json` prints them",
            STATISTICS, reads.statistics, figures.Figures, asked.Statistics, reads.keep_missing_looks),
        one("/statistics/surveys", "surveys_use", "Surveys of a lot, each with its share of taken stalls", STATISTICS,
            reads.surveys_use, figures.SurveysUse, asked.Period, reads.keep_missing_looks),
        one("/statistics/stalls", "stalls_use", "Stalls of a lot by the share of surveys that found them taken",
            STATISTICS, reads.stalls_use, figures.StallsUse, asked.Period, reads.keep_missing_looks),
        one("/statistics/between", "between", "Changes of a lot's stalls from one survey to another one", STATISTICS,
            reads.between, figures.Changed, asked.Between, reads.keep_missing_looks),
    )  # fmt: skip


_READS: Final = (
    _read("/lots", "lots", "Lots, the oldest first", LOTS, reads.lots, models.LotList, asked.Listed),
    _read("/lots/{id}", "lot", "A lot", LOTS, reads.lot, models.Lot),
    _read("/lots/{id}/layouts", "layouts", "Versions of a lot's layout, the first one first", LOTS, reads.layouts,
          models.LayoutList, asked.Listed),
    _read("/lots/{id}/layouts/{version}/stalls", "layout_stalls", "Stalls of a version of a lot's layout, as they were",
          LOTS, reads.stalls_of_layout, models.PlanStallList, asked.Listed),
    _read("/lots/{id}/stalls", "stalls", "Stalls of a lot's plan with the last look at each", LOTS, reads.stalls,
          models.StallList, asked.Stalls),
    _read("/stalls/{id}", "stall", "A stall of any layout", LOTS, reads.stall, models.Stall),
    _read("/lots/{id}/zones", "zones", "Zones of a lot's plan, and areas without stalls", LOTS, reads.zones,
          models.ZoneList, asked.Listed),
    _read("/surveys", "surveys", "Surveys of all lots, and of none", SURVEYS, reads.surveys, models.SurveyList,
          asked.Surveys),
    _read("/lots/{id}/surveys", "lot_surveys", "Surveys of a lot", SURVEYS, reads.surveys, models.SurveyList,
          asked.Surveys),
    _read("/surveys/{id}", "survey", "A survey", SURVEYS, reads.survey, models.Survey),
    _read("/surveys/{id}/observations", "survey_observations", "Looks of a survey at the stalls of its lot", SURVEYS,
          reads.observations_of_survey, models.ObservationList, asked.Listed),
    *_of_lot(False),
)  # fmt: skip

_CHANGES: Final = (
    _read("/changes", "changes", "Changes that persons made, the newest first", CHANGES, reads.changes,
          models.ChangeList, asked.Listed),
    _read("/lots/{id}/proposals", "proposals", "What the newest surveys of a lot propose to change of its layout",
          CHANGES, reads.proposals, models.Proposals),
    _change("/changes/{seq}/undo", "undo", "Undo a change, once", CHANGES, lots.undo, bodies.Nothing, bodies.Undone),
    _change("/lots/{id}/name", "rename", "Name a lot", CHANGES, lots.rename, bodies.LotName, bodies.Done),
    _change("/lots/{id}/merge", "merge", "Merge another lot into this one", CHANGES, lots.merge, bodies.LotMerge,
            bodies.Done),
    _change("/lots/{id}/split", "split", "Make a lot of its own of a part of a lot", CHANGES, lots.split,
            bodies.LotSplit, bodies.Done),
    _change("/lots/{id}/pin", "pin", "Pin a lot to its place on Earth", CHANGES, lots.pin, bodies.LotPin,
            bodies.Pinned),
    _change("/lots/{id}/take-over", "take_over", "Take proposals over into the layout", CHANGES, lots.take_over,
            bodies.TakeOver, bodies.Done),
    _change("/lots/{id}/drop", "drop", "Drop proposals", CHANGES, lots.drop, bodies.Chosen, bodies.Done),
    _change("/surveys/{id}/move", "move_survey", "Move a survey to another lot, or to a new one", CHANGES, lots.move,
            bodies.SurveyMove, bodies.Done),
    _change("/surveys/{id}/delete", "delete_survey", "Delete a survey of a lot; undoing brings it back", CHANGES,
            lots.delete, bodies.Nothing, bodies.Done),
    _change("/surveys/{id}/place", "place_survey", "Choose the place of a survey whose place is not certain", CHANGES,
            lots.choose, bodies.Choose, bodies.Done),
)  # fmt: skip

_PLANS: Final = (
    _change("/lots/{id}/edit", "open_edit", "Open an edit of a lot's plan, or go on with one's own", PLANS,
            plans.open_edit, bodies.OpenEdit, bodies.Opened),
    _change("/lots/{id}/plan", "edit_plan", "Do an operation on the plan", PLANS, plans.do, bodies.Do, bodies.Edited),
    _change("/lots/{id}/plan/undo", "undo_step", "Undo the newest operation of the edit", PLANS, plans.undo,
            bodies.InEdit, bodies.Stepped),
    _change("/lots/{id}/plan/redo", "redo_step", "Do the operation again that was undone last", PLANS, plans.redo,
            bodies.InEdit, bodies.Stepped),
    _change("/lots/{id}/edit/close", "close_edit", "Close the edit: its version of the layout is final", PLANS,
            plans.close, bodies.CloseEdit, bodies.Closed),
    _file("/lots/{id}/plan/import", "preview_plan", "Read a file with a plan of a lot; nothing is written"),
    _change("/lots/{id}/plan/import/{preview}/take", "take_plan", "Take a plan that was read, within the edit", PLANS,
            plan_files.take, bodies.TakePlan, bodies.Edited),
    _file("/lots/import", "preview_lot", "Read a file with the plan of a new lot; nothing is written"),
    _change("/lots/import/{preview}/take", "begin_lot", "Make a lot of a plan that was read", PLANS, plan_files.begin,
            bodies.BeginLot, bodies.Begun),
)  # fmt: skip

_LINKS: Final = (
    Operation("GET", "/lots/{id}/shares", "links", "Links to a lot, without their tokens", LINKS, of_links.listed,
              bodies.SharedLinks),
    _change("/lots/{id}/shares", "make_link", "Make a link by which others read a lot for some days", LINKS,
            links.share, bodies.LinkDays, bodies.SharedLink),
    _change("/shares/{id}/take-back", "take_back_link", "Take a link back: it opens nothing from now on", LINKS,
            links.take_back, bodies.Nothing, bodies.TakenBack),
    *_of_lot(True),
)  # fmt: skip

_RECORDINGS: Final = (
    Operation("GET", "/recordings", "recordings", "Recordings on the drone's disk, the oldest first", RECORDINGS,
              changing.listed, models.RecordingList, asked.Listed),
    Operation("POST", "/recordings/{name}/keep", "keep_recording", "Set the mark of a recording, or take it away",
              RECORDINGS, of_recordings(bodies.Keep, recordings.kept), bodies.Kept, body=bodies.Keep),
    Operation("POST", "/recordings/{name}/delete", "delete_recording", "Delete a recording, while no drone flies",
              RECORDINGS, of_recordings(bodies.Nothing, recordings.deleted), bodies.Deleted, body=bodies.Nothing),
)  # fmt: skip

_FEATURES: Final = (
    _features("", "features", "Landing page: links to all that is here", features.landing, shapes.Landing),
    _features("/conformance", "conformance", "Parts of the standard that are kept", features.conformance,
              shapes.Conformance),
    _features("/collections", "collections", "The collections: lots, stalls, surveys", features.collections,
              shapes.Collections),
    _features("/collections/{collection}", "collection", "A collection", features.collection, shapes.Collection),
    _features("/collections/{collection}/items", "items", "Features of a collection", features.items,
              shapes.FeatureCollection, forms.Items, GEOJSON),
    _features("/collections/{collection}/items/{id}", "item", "A feature", features.item, shapes.LinkedFeature,
              content_type=GEOJSON),
)  # fmt: skip

OPERATIONS: Final[tuple[Operation, ...]] = (
    *_READS, *_CHANGES, *_PLANS, *_LINKS, *_RECORDINGS, *_FEATURES,
)  # fmt: skip
