"""All lots as a map and a table of them show them, a list for each value: one answer for ten thousand lots.

The values are those of a list of lots, without what only a view of one lot needs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

from sqlalchemy import ColumnElement, Connection, Row, String, cast, func, select

from hawk.lots.queries import NextDue, never_due
from hawk.lots.rows import readable
from hawk.lots.schema import DIGEST, DOCUMENT, LOT, STALL, SURVEY
from hawk.lots.survey.counts import counts_of
from hawk.lots.survey.order import last_of, ordered_at
from hawk.lots.time_zone import time_zones_of
from hawk.lots.values import utc

_DEGREES: Final = 6
"""Decimals: a decimetre."""
_OF_LOT: Final = (LOT.c.id, LOT.c.name, LOT.c.latitude, LOT.c.longitude, LOT.c.time_zone)
_OF_SURVEY: Final = tuple(
    SURVEY.c[name] for name in ("seq", "lot", "layout", "placed", "ended", "free", "taken", "unknown")
)
_COUNTED: Final = "hawk_counted"
"""Key among the values of a connection: the counts of its last question."""
_Counts = Mapping[str, int]
_Digests = tuple[bytes, bytes]
"""Of a lot and of its newest survey (`hawk.lots.storage.digests`)."""
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
    stalls = select(func.count()).select_from(STALL).where(STALL.c.lot == LOT.c.id, STALL.c.ends.is_(None))
    of_lot = SURVEY.alias()
    surveys = select(func.count()).select_from(of_lot).where(of_lot.c.lot == LOT.c.id)
    numbers = (_counted(stalls, "stalls"), _counted(surveys, "surveys"))
    plan, seen = DIGEST.alias(), DIGEST.alias()
    digests = (plan.c.digest.label("plan"), seen.c.digest.label("seen"))
    newest = (SURVEY.c.id.label("survey"), ordered_at().label("taken_at"), DOCUMENT.c.writer)
    joined = LOT.outerjoin(SURVEY, SURVEY.c.seq == last_of(LOT.c.id))
    joined = joined.outerjoin(DOCUMENT, DOCUMENT.c.survey == SURVEY.c.seq)
    joined = joined.outerjoin(plan, (plan.c.part == "lot") & (plan.c.key == LOT.c.id))
    joined = joined.outerjoin(seen, (seen.c.part == "survey") & (seen.c.key == cast(SURVEY.c.seq, String)))
    columns: list[Any] = [*_OF_LOT, *_OF_SURVEY, *numbers, *newest, *digests]
    asked = select(*columns).select_from(joined).where(LOT.c.merged_into.is_(None), *of)
    rows = connection.execute(asked.order_by(LOT.c.made, LOT.c.id)).all()
    counted = _counts(connection, rows)
    zones = time_zones_of(connection, [row._mapping for row in rows])
    found = readable(lambda each: _values(rows[each], zones[each], counted[each], due), range(len(rows)))
    return dict(zip(_NAMES, map(list, zip(*found, strict=True)) if found else [[] for _ in _NAMES], strict=True))


def _counts(connection: Connection, rows: Sequence[Row[Any]]) -> list[_Counts | None]:
    """Return the counts of the newest surveys, None without one.

    Those of a survey and a lot that have not changed since the connection's last question, by their digests, are of it.
    """
    before: dict[_Digests, _Counts] = connection.info.get(_COUNTED, {})
    surveyed = [(row, (row.plan, row.seen)) for row in rows if row.survey is not None]
    new = [(row, key) for row, key in surveyed if None in key or key not in before]
    counts = counts_of(connection, [row._mapping for row, _ in new])
    read = {row.seq: each for (row, _), each in zip(new, counts, strict=True)}
    now: dict[int, _Counts] = {row.seq: read[row.seq] if row.seq in read else before[key] for row, key in surveyed}
    connection.info[_COUNTED] = {key: now[row.seq] for row, key in surveyed if None not in key}
    return [now.get(row.seq) for row in rows]


def _counted(asked: Any, name: str) -> ColumnElement[int]:
    found: ColumnElement[int] = asked.correlate(LOT).scalar_subquery().label(name)
    return found


def _values(row: Row[Any], zone: str, counts: _Counts | None, due: NextDue) -> tuple[Any, ...]:
    at = due(row.id, row.name, row.taken_at)
    place = round(float(row.latitude), _DEGREES), round(float(row.longitude), _DEGREES)
    of_lot = (row.id, row.name, *place, zone, row.stalls, row.surveys, None if at is None else utc(at.timestamp()))
    of_survey = [] if counts is None else readable(_survey_values, [(row, counts)])
    return (*of_lot, *(of_survey[0] if of_survey else (None,) * 6))


def _survey_values(surveyed: tuple[Row[Any], _Counts]) -> tuple[Any, ...]:
    row, counts = surveyed
    return row.survey, utc(row.ended), counts["free"], counts["taken"], counts["unknown"], row.writer
