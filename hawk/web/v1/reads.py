"""Reading of lots, layouts, stalls, zones, sections, surveys, observations and statistics for `hawk.web.v1.table`.

Each function runs on a thread of the store, which loads this module and SQLAlchemy with it (`hawk.runtime.late`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

from sqlalchemy import ColumnElement, Connection

from hawk.exports.lot_places import lot_places
from hawk.exports.records import read_survey, survey_of
from hawk.exports.text_files import survey_geojson, survey_map
from hawk.lots import lists, names, queries, reach
from hawk.lots.answers import Change, Part
from hawk.lots.change_detection.comparison import newest_registered
from hawk.lots.documents import arrival_log
from hawk.lots.lists import Asked
from hawk.lots.sections import lists as section_lists
from hawk.lots.sections.vehicle_counts import vehicle_counts
from hawk.lots.storage.schema import CHANGE, LOT, STALL, SURVEY
from hawk.lots.survey.pictures import PictureFolder
from hawk.lots.time_zone import zone_of_lot
from hawk.lots.values import UTC_NAME, Placed
from hawk.report.options import Form, Kind, Wanted
from hawk.runtime.late import late_functions
from hawk.stats import queries as uses
from hawk.stats import use_query
from hawk.stats.panel import Period
from hawk.stats.period import period_of, period_of_lot
from hawk.web.v1 import parameters as forms
from hawk.web.v1.answers import GEOJSON, Answer
from hawk.web.v1.parameters import Query, Request

if TYPE_CHECKING:  # it loads templates and messages: not for other questions
    from hawk.report import files
    from hawk.report.files import Prepared
else:
    files = late_functions("hawk.report.files")

P = TypeVar("P", bound=forms.Period)


def _listed(part: Part) -> Answer:
    return Answer(part, part.next)


def _part(query: forms.Listed) -> Asked:
    return Asked(query.limit, query.after)


def _during(connection: Connection, query: forms.Period, lot: str | None) -> Sequence[ColumnElement[bool]]:
    """Return the conditions that a survey ended within a period, by the clock of a lot, or UTC for surveys of all.

    Raises NotFoundError, LotInputError.
    """
    if query.begin is None and query.end is None:
        return ()
    named = query.time_zone or UTC_NAME if lot is None else query.time_zone or zone_of_lot(connection, lot)
    return period_of(query.begin, query.end, named).holds(SURVEY.c.ended)


def within(connection: Connection, asked: Request[Any]) -> frozenset[str] | None:
    """Return the lots that the role of the client is for, as they are now; None: all."""
    return None if asked.lots is None else reach.lots_within(connection, asked.lots)


def _theirs(connection: Connection, asked: Request[Any], lot: ColumnElement[str]) -> Sequence[ColumnElement[bool]]:
    """Return the conditions that a column names a lot that the role of the client is for."""
    return () if asked.lots is None else (reach.is_within(lot, within(connection, asked)),)


def _period(connection: Connection, asked: Request[P]) -> Period:
    """Return a period, which may have no end. Raises NotFoundError, LotInputError."""
    query = asked.query
    return period_of_lot(connection, asked.id, query.begin, query.end, query.time_zone)


def lots(connection: Connection, asked: Request[forms.Listed]) -> Answer:
    """Return every lot."""
    part = replace(_part(asked.query), of=_theirs(connection, asked, LOT.c.id))
    return _listed(lists.lots(connection, part, asked.due))


def places_of_lots(connection: Connection, asked: Request[Query]) -> Answer:
    """Return every lot as the page's map and table of them show it."""
    return Answer(lot_places(connection, asked.due, _theirs(connection, asked, LOT.c.id)))


def lot(connection: Connection, asked: Request[Query]) -> Answer:
    """Return a lot."""
    return Answer(lists.lot(connection, asked.id, asked.due))


def layouts(connection: Connection, asked: Request[forms.Listed]) -> Answer:
    """Return the versions of a lot's layout."""
    return _listed(lists.layouts(connection, asked.id, _part(asked.query)))


def arrivals(connection: Connection, asked: Request[forms.Arrivals]) -> Answer:
    """Return what came from drones and programs."""
    query = asked.query
    return _listed(arrival_log.listed(connection, _part(query), query.sender, query.lot, query.outcome))


def stalls_of_layout(connection: Connection, asked: Request[forms.Listed]) -> Answer:
    """Return the stalls of a version of a lot's layout."""
    version = int(asked.path["version"])
    return _listed(lists.stalls_of_layout(connection, asked.id, version, _part(asked.query)))


def zones(connection: Connection, asked: Request[forms.Listed]) -> Answer:
    """Return the zones of a lot."""
    return _listed(lists.zones(connection, asked.id, _part(asked.query)))


def sections(connection: Connection, asked: Request[forms.Listed]) -> Answer:
    """Return the sections of a lot."""
    return _listed(section_lists.sections(connection, asked.id, _part(asked.query)))


def sections_of_survey(connection: Connection, asked: Request[forms.Listed]) -> Answer:
    """Return what a survey saw of the sections of its lot."""
    return _listed(section_lists.looks(connection, asked.id, _part(asked.query)))


def sections_seen(connection: Connection, asked: Request[Query]) -> Answer:
    """Return the sections of a lot with what one survey saw of each."""
    survey = survey_of(connection, asked.id, asked.path["survey"])
    return Answer(section_lists.sections_seen(connection, asked.id, survey))


def vehicles_of_survey(connection: Connection, asked: Request[Query]) -> Answer:
    """Return how many vehicles of a survey stand where."""
    return Answer(vehicle_counts(connection, asked.id))


def stalls(connection: Connection, asked: Request[forms.Stalls]) -> Answer:
    """Return the stalls of a lot."""
    query = asked.query
    part = lists.stalls(
        connection, asked.id, _part(query), row=query.row, kind=query.kind, state=query.state
    )  # fmt: skip
    return _listed(part)


def stall(connection: Connection, asked: Request[Query]) -> Answer:
    """Return a stall."""
    return Answer(lists.stall(connection, asked.id))


def surveys(connection: Connection, asked: Request[forms.Surveys]) -> Answer:
    """Return surveys: those of a lot where the address names one."""
    query = asked.query
    is_asked = SURVEY.c.placed != Placed.DELETED.value if query.placed is None else SURVEY.c.placed == query.placed
    of_lots = _theirs(connection, asked, SURVEY.c.lot)
    conditions = [*_during(connection, query, asked.path.get("id")), *of_lots, is_asked]
    part = replace(_part(query), newest_first=query.order == "newest", of=conditions)
    return _listed(lists.surveys(connection, part, asked.path.get("id")))


def survey(connection: Connection, asked: Request[Query]) -> Answer:
    """Return a survey."""
    return Answer(lists.survey(connection, asked.id))


def observations(connection: Connection, asked: Request[forms.Observations]) -> Answer:
    """Return the looks at the stalls of a lot: for a role for some lots, at those that are theirs now."""
    query = asked.query
    of = [*_during(connection, query, asked.id), *_theirs(connection, asked, STALL.c.lot)]
    part = replace(_part(query), newest_first=query.order == "newest", of=of)
    found = lists.observations(connection, part, lot_id=asked.id, survey_id=query.survey, stall_id=query.stall)
    return _listed(found)


def observations_of_survey(connection: Connection, asked: Request[forms.Listed]) -> Answer:
    """Return the looks of a survey: as `observations` does."""
    part = replace(_part(asked.query), of=_theirs(connection, asked, STALL.c.lot))
    return _listed(lists.observations(connection, part, survey_id=asked.id))


def changes(connection: Connection, asked: Request[forms.Changes]) -> Answer:
    """Return the changes that persons made."""
    part = replace(_part(asked.query), of=_theirs(connection, asked, CHANGE.c.lot))
    found = lists.changes(connection, part, asked.query.lot)
    if asked.lots is not None:
        found = found.model_copy(update={"items": [_kept_of_lots(each) for each in found.items]})
    return _listed(found)


def _kept_of_lots(change: Change) -> Change:
    """Return a change as a role for some lots sees it: one of more than one lot is not theirs to undo."""
    is_kept = change.kept is None and change.kind not in reach.OF_ONE_LOT
    return change.model_copy(update={"kept": f"change: {change.seq} is about more than one lot"}) if is_kept else change


def proposals(connection: Connection, asked: Request[Query]) -> Answer:
    """Return what the newest surveys of a lot propose to change of its layout."""
    return Answer(queries.proposed(connection, asked.id, within(connection, asked)))


def plan(connection: Connection, asked: Request[forms.PlanPart]) -> Answer:
    """Return the plan of a lot."""
    return Answer(queries.plan(connection, asked.id, asked.query.since, asked.query.layout))


def comparison(connection: Connection, asked: Request[Query]) -> Answer:
    """Return how the newest registered survey of a lot differs from its layout."""
    queries.lot_row(connection, asked.id)
    return Answer(newest_registered(connection, asked.id))


def places(connection: Connection, asked: Request[Query]) -> Answer:
    """Return the places where a survey may lie."""
    return Answer(queries.places(connection, asked.id))


def statistics(connection: Connection, asked: Request[forms.Statistics]) -> Answer:
    """Return the figures of a lot's use."""
    return Answer(uses.statistics(connection, asked.id, _period(connection, asked), asked.query.by))


def _question(query: forms.UseQuery) -> use_query.Asked:
    return use_query.asked_of(query.weekday, query.hour, query.row, query.zone, query.kind, query.section)


def ask(connection: Connection, asked: Request[forms.UseQuery]) -> Answer:
    """Return the answer to a question about a lot's use."""
    return Answer(uses.ask(connection, asked.id, _period(connection, asked), _question(asked.query)))


def report(
    connection: Connection, pictures: PictureFolder, asked: Request[forms.ReportQuery], kind: Kind, form: Form,
    has_ground: bool,
) -> Prepared:  # fmt: skip
    """Return a report of a lot's use, prepared to be written."""
    query = asked.query
    wanted = Wanted(asked.id, _question(query), query.begin, query.end, query.time_zone, has_ground)
    return files.prepared(connection, pictures, wanted, kind, form, asked.now)


def lots_of_report(connection: Connection, asked: Request[forms.LotsReportQuery]) -> list[str]:
    """Return the lots that a report is asked over, whether it takes as many or not."""
    return list(asked.query.lot) or names.lots_by_name(connection, *_theirs(connection, asked, LOT.c.id))


def report_of_lots(
    connection: Connection, pictures: PictureFolder, lots: Sequence[str], asked: Request[forms.LotsReportQuery],
    kind: Kind, form: Form,
) -> Prepared:  # fmt: skip
    """Return a report over several lots, prepared to be written."""
    query = asked.query
    wanted = Wanted("", use_query.asked_of(query.weekday, query.hour), query.begin, query.end, query.time_zone)
    return files.prepared_of_lots(connection, pictures, lots, wanted, kind, form, asked.now, asked.due)


def surveys_use(connection: Connection, asked: Request[forms.SurveysOf]) -> Answer:
    """Return the surveys of a lot with the share of taken stalls of each."""
    query, period = asked.query, _period(connection, asked)
    return Answer(uses.surveys_use(connection, asked.id, period, query.survey, query.newest))


def stalls_use(connection: Connection, asked: Request[forms.Period]) -> Answer:
    """Return of each stall of a lot the share of the surveys in which it was taken."""
    return Answer(uses.stalls_use(connection, asked.id, _period(connection, asked)))


def between(connection: Connection, asked: Request[forms.Between]) -> Answer:
    """Return what changed on a lot from one survey to another one."""
    query = asked.query
    return Answer(uses.changes(connection, asked.id, query.before, query.after))


def survey_on_map(connection: Connection, asked: Request[Query]) -> Answer:
    """Return the stalls of a survey of a lot as the page draws them."""
    return Answer(survey_map(read_survey(connection, survey_of(connection, asked.id, asked.path["survey"]))))


def survey_stalls(connection: Connection, asked: Request[Query]) -> Answer:
    """Return a survey of a lot with its stalls, as GeoJSON."""
    found = survey_of(connection, asked.id, asked.path["survey"])
    return Answer(survey_geojson(read_survey(connection, found)).decode(), content_type=GEOJSON)
