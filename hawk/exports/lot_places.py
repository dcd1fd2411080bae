"""All lots as a map and a table of them show them, a list for each value: one answer for ten thousand lots.

The values are those of a list of lots, without what only a view of one lot needs.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

from sqlalchemy import ColumnElement, Connection, Row, select

from hawk.lots.names import schedule_names
from hawk.lots.queries import NextDue, never_due
from hawk.lots.storage.rows import readable
from hawk.lots.storage.schema import LOT
from hawk.lots.survey.last_surveys import LastSurvey, last_surveys_of
from hawk.lots.time_zone import time_zones_of
from hawk.lots.values import utc

_DEGREES: Final = 6
"""Decimals: a decimetre."""
_LOTS: Final = (
    select(LOT.c.id, LOT.c.name, LOT.c.latitude, LOT.c.longitude, LOT.c.time_zone)
    .where(LOT.c.merged_into.is_(None))
    .order_by(LOT.c.made, LOT.c.id)
)
_NO_SURVEY: Final = (None,) * 6
_NAMES: Final = (
    "ids", "names", "latitudes", "longitudes", "time_zones", "stalls", "survey_counts", "due", "surveys", "ended",
    "free", "taken", "unknown", "drones",
)  # fmt: skip


def lot_places(
    connection: Connection, due: NextDue = never_due, of: Sequence[ColumnElement[bool]] = ()
) -> dict[str, list[Any]]:
    """Return the lots that were not merged into another one, the oldest first, as
    `hawk.web.v1.features.answers.LotPlaces` says; a damaged lot or survey is passed over. ``of``: conditions of lots.
    """
    rows = connection.execute(_LOTS.where(*of)).all()
    newest = last_surveys_of(connection, [row.id for row in rows])
    zones = time_zones_of(connection, [row._mapping for row in rows])
    called = schedule_names(connection, [row.name for row in rows])
    surveyed = ((lot, of) for lot, of in newest.items() if of.survey is not None)
    surveys = dict(readable(_survey_values, surveyed))

    def values(each: int) -> tuple[Any, ...]:
        lot, name, latitude, longitude, _ = rows[each]
        of = newest[lot]
        at = due(lot, called[name], of.taken_at)
        place = round(float(latitude), _DEGREES), round(float(longitude), _DEGREES)
        due_at = None if at is None else utc(at.timestamp())
        return lot, name, *place, zones[each], of.stalls, of.surveys, due_at, *surveys.get(lot, _NO_SURVEY)

    found = readable(values, range(len(rows)))
    return dict(zip(_NAMES, map(list, zip(*found, strict=True)) if found else [[] for _ in _NAMES], strict=True))


def _survey_values(newest: tuple[str, LastSurvey | Row[Any]]) -> tuple[str, tuple[Any, ...]]:
    lot, of = newest
    return lot, (of.survey_id, utc(of.ended or 0.0), of.free, of.taken, of.unknown, of.drone)
