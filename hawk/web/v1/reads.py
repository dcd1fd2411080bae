"""Reading of lots, layouts, stalls, zones, surveys, observations and statistics for `hawk.web.v1.table`.

Each function runs on a thread of the store, where SQLAlchemy is loaded.
"""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from hawk.lots.store import LotStore
from hawk.lots.values import LotStoreError, Placed
from hawk.web.v1 import asked as forms
from hawk.web.v1.answering import Answer
from hawk.web.v1.asked import Query, Request

if TYPE_CHECKING:  # loaded on the store's thread
    from sqlalchemy import ColumnElement, Connection

    from hawk.lots.lists import Asked, Part
    from hawk.stats.panel import Period

GEOJSON: Final = "application/geo+json"
_AT_ONCE: Final = 20
"""Surveys whose looks are put in one piece in one transaction: 0.1 s, after which a flight's survey may be stored."""


def _listed(part: Part) -> Answer:
    return Answer({"items": part.items, "next": part.next}, part.next)


def _part(query: forms.Listed) -> Asked:
    from hawk.lots.lists import Asked

    return Asked(query.limit, query.after)


def _during(query: forms.Period) -> Sequence[ColumnElement[bool]]:
    """Return the conditions that a survey ended within a period. Raises LotInputError."""
    from hawk.lots.schema import SURVEY
    from hawk.stats.period import period_of

    if query.begin is None and query.end is None:
        return ()
    return period_of(query.begin, query.end, query.time_zone).holds(SURVEY.c.ended)


def _period(query: forms.Period) -> Period:
    """Return a period, which may have no end. Raises LotInputError."""
    from hawk.stats.period import period_of

    return period_of(query.begin, query.end, query.time_zone)


def lots(connection: Connection, asked: Request[forms.Listed]) -> Answer:
    """Return every lot."""
    from hawk.lots import lists

    return _listed(lists.lots(connection, _part(asked.query)))


def lot(connection: Connection, asked: Request[Query]) -> Answer:
    """Return a lot."""
    from hawk.lots import lists

    return Answer(lists.lot(connection, asked.id))


def layouts(connection: Connection, asked: Request[forms.Listed]) -> Answer:
    """Return the versions of a lot's layout."""
    from hawk.lots import lists

    return _listed(lists.layouts(connection, asked.id, _part(asked.query)))


def stalls_of_layout(connection: Connection, asked: Request[forms.Listed]) -> Answer:
    """Return the stalls of a version of a lot's layout."""
    from hawk.lots import lists

    version = int(asked.path["version"])
    return _listed(lists.stalls_of_layout(connection, asked.id, version, _part(asked.query)))


def zones(connection: Connection, asked: Request[forms.Listed]) -> Answer:
    """Return the zones of a lot."""
    from hawk.lots import lists

    return _listed(lists.zones(connection, asked.id, _part(asked.query)))


def stalls(connection: Connection, asked: Request[forms.Stalls]) -> Answer:
    """Return the stalls of a lot."""
    from hawk.lots import lists

    query = asked.query
    part = lists.stalls(
        connection, asked.id, _part(query), row=query.row, kind=query.kind, state=query.state
    )  # fmt: skip
    return _listed(part)


def stall(connection: Connection, asked: Request[Query]) -> Answer:
    """Return a stall."""
    from hawk.lots import lists

    return Answer(lists.stall(connection, asked.id))


def surveys(connection: Connection, asked: Request[forms.Surveys]) -> Answer:
    """Return surveys: those of a lot where the address names one."""
    from hawk.lots import lists
    from hawk.lots.schema import SURVEY

    query = asked.query
    is_asked = SURVEY.c.placed != Placed.DELETED.value if query.placed is None else SURVEY.c.placed == query.placed
    conditions = [*_during(query), is_asked]
    part = replace(_part(query), newest_first=query.order == "newest", of=conditions)
    return _listed(lists.surveys(connection, part, asked.path.get("id")))


def survey(connection: Connection, asked: Request[Query]) -> Answer:
    """Return a survey."""
    from hawk.lots import lists

    return Answer(lists.survey(connection, asked.id))


def observations(connection: Connection, asked: Request[forms.Observations]) -> Answer:
    """Return the looks at the stalls of a lot."""
    from hawk.lots import lists

    query = asked.query
    part = replace(_part(query), newest_first=query.order == "newest", of=_during(query))
    found = lists.observations(connection, part, lot_id=asked.id, survey_id=query.survey, stall_id=query.stall)
    return _listed(found)


def observations_of_survey(connection: Connection, asked: Request[forms.Listed]) -> Answer:
    """Return the looks of a survey."""
    from hawk.lots import lists

    return _listed(lists.observations(connection, _part(asked.query), survey_id=asked.id))


def changes(connection: Connection, asked: Request[forms.Listed]) -> Answer:
    """Return the changes that persons made."""
    from hawk.lots import lists

    return _listed(lists.changes(connection, _part(asked.query)))


def proposals(connection: Connection, asked: Request[Query]) -> Answer:
    """Return what the newest surveys of a lot propose to change of its layout."""
    from hawk.lots import queries

    return Answer(queries.proposed(connection, asked.id))


def statistics(connection: Connection, asked: Request[forms.Statistics]) -> Answer:
    """Return the figures of a lot's use."""
    from hawk.stats.queries import statistics as figures
    from hawk.stats.serialize import figures_json

    return Answer(figures_json(figures(connection, asked.id, _period(asked.query), asked.query.by)))


def surveys_use(connection: Connection, asked: Request[forms.Period]) -> Answer:
    """Return the surveys of a lot with the share of taken stalls of each."""
    from hawk.stats.surveys import surveys_json

    return Answer(surveys_json(connection, asked.id, _period(asked.query)))


def stalls_use(connection: Connection, asked: Request[forms.Period]) -> Answer:
    """Return of each stall of a lot the share of the surveys in which it was taken."""
    from hawk.stats.stalls import heat_json

    return Answer(heat_json(connection, asked.id, _period(asked.query)))


def between(connection: Connection, asked: Request[forms.Between]) -> Answer:
    """Return what changed on a lot from one survey to another one."""
    from hawk.stats.queries import changes as found
    from hawk.stats.serialize import changes_json

    query = asked.query
    return Answer(changes_json(found(connection, asked.id, query.before, query.after, _period(query))))


def survey_stalls(connection: Connection, asked: Request[Query]) -> Answer:
    """Return a survey of a lot with its stalls, as GeoJSON."""
    from hawk.exports.records import read_survey, survey_of
    from hawk.exports.text_files import survey_geojson

    found = survey_of(connection, asked.id, asked.path["survey"])
    return Answer(survey_geojson(read_survey(connection, found)).decode(), content_type=GEOJSON)


async def keep_missing_looks(store: LotStore, asked: Request[Any]) -> None:
    """Put the looks of an archive that an earlier version wrote in one piece a survey, once: statistics read these.

    A store of a newer version is only read: each question then takes longer.
    """

    def missing(connection: Connection) -> list[int]:
        from hawk.lots.survey.observations import missing_looks

        return missing_looks(connection, asked.id)

    def keep(connection: Connection, surveys: Sequence[int]) -> None:
        from hawk.lots.survey.observations import keep_looks

        keep_looks(connection, surveys)

    found = await store.read(missing)
    with contextlib.suppress(LotStoreError):
        for first in range(0, len(found), _AT_ONCE):
            some = found[first : first + _AT_ONCE]
            await store.write(lambda connection, some=some: keep(connection, some))  # type: ignore[misc]
