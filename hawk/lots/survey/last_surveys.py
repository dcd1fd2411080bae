"""The newest survey of each lot with its counts, kept in the store: ten thousand lots are listed without a count.

A row follows from the lot, its plan and sections, all of its surveys with their looks, and the clock. Each of the first
is in a part of the store that has a digest. Triggers forget the row of a lot in the statement that changes such a part,
or that takes a survey to or from the lot; the end of the transaction makes it again (`renew`), and one that is
damaged. Of a lot with pictures a row holds while the same pictures have been. What is missing, or holds no more,
readers count themselves.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any, Final

from sqlalchemy import ColumnElement, Connection, Row, and_, bindparam, func, not_, or_, select, update

from hawk.lots.storage.rows import is_among
from hawk.lots.storage.schema import DOCUMENT, LAST_SURVEY, LOT, SECTION, STALL, SURVEY
from hawk.lots.survey import moments
from hawk.lots.survey.counts import COUNTS, counts_of
from hawk.lots.survey.order import has_been, last_of, ordered_at
from hawk.lots.survey.source import SurveyKind

_AT_ONCE: Final = 100
"""Rows that a transaction makes again at most, in some hundredths of a second: an upgrade leaves all to be made."""
_LOG = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class LastSurvey:
    """Numbers of stalls, sections and surveys of a lot, and its newest survey; None without one.

    ``survey``, ``survey_id``: its number and id; ``ended``, ``taken_at``: Unix seconds, the second one as of
    `ordered_at`; ``drone``: who sent it as a document; ``free``, ``taken``, ``unknown``: as of `counts_of`. ``been``,
    ``to_come``: end of the last picture that has been, and of the first one that is to come.
    """

    stalls: int
    sections: int
    surveys: int
    survey: int | None
    survey_id: str | None
    ended: float | None
    taken_at: float | None
    drone: str | None
    free: int | None
    taken: int | None
    unknown: int | None
    been: float | None
    to_come: float | None


def _number(asked: Any) -> ColumnElement[Any]:
    found: ColumnElement[Any] = asked.correlate(LOT).scalar_subquery()
    return found


def _present(table: Any) -> ColumnElement[Any]:
    return _number(select(func.count()).select_from(table).where(table.c.lot == LOT.c.id, table.c.ends.is_(None)))


_OTHER: Final = SURVEY.alias()
_OF_LOT: Final = _OTHER.c.lot == LOT.c.id
_PICTURE: Final = and_(_OF_LOT, _OTHER.c.kind != SurveyKind.FLOWN.value)
_MADE: Final = (
    select(
        LOT.c.id, _present(STALL).label("stalls"), _present(SECTION).label("sections"),
        _number(select(func.count()).select_from(_OTHER).where(_OF_LOT)).label("surveys"),
        SURVEY.c.seq.label("survey"), SURVEY.c.id.label("survey_id"), SURVEY.c.ended, ordered_at().label("taken_at"),
        DOCUMENT.c.writer.label("drone"),
        _number(select(func.max(_OTHER.c.ended)).where(_PICTURE, has_been(_OTHER))).label("been"),
        _number(select(func.min(_OTHER.c.ended)).where(_PICTURE, not_(has_been(_OTHER)))).label("to_come"),
        *(SURVEY.c[name] for name in ("seq", "lot", "layout", "placed", *COUNTS)),
    )
    .select_from(
        LOT.outerjoin(SURVEY, SURVEY.c.seq == last_of(LOT.c.id)).outerjoin(DOCUMENT, DOCUMENT.c.survey == SURVEY.c.seq)
    )
    .where(is_among(LOT.c.id))
)  # fmt: skip
_HOLDS: Final = and_(
    LAST_SURVEY.c.stalls.is_not(None),
    or_(LAST_SURVEY.c.been.is_(None), moments.has_been(LAST_SURVEY.c.been, func.hawk_now())),
    or_(LAST_SURVEY.c.to_come.is_(None), not_(moments.has_been(LAST_SURVEY.c.to_come, func.hawk_now()))),
)
_KEPT: Final = select(LAST_SURVEY).where(is_among(LAST_SURVEY.c.lot), _HOLDS)
_IS_OPEN: Final = or_(LAST_SURVEY.c.stalls.is_(None), LAST_SURVEY.c.to_come.is_not(None))
"""The condition of an index: rows that are to be made again, now or later."""
_CHANGED: Final = (
    select(LAST_SURVEY.c.lot)
    .where(_IS_OPEN, not_(_HOLDS), not_(is_among(LAST_SURVEY.c.lot)))
    .order_by(LAST_SURVEY.c.lot)
    .limit(_AT_ONCE + 1)
)
"""Rows to be made again, but for those of lots that are ``among``."""
_KEEP: Final = update(LAST_SURVEY).where(LAST_SURVEY.c.lot == bindparam("of"))
_NAMES: Final = tuple(each.name for each in fields(LastSurvey) if each.name not in COUNTS)


def last_surveys_of(connection: Connection, lots: Sequence[str]) -> dict[str, LastSurvey | Row[Any]]:
    """Return the newest surveys of lots by their ids: as they are kept, or as they are made now."""
    rows = connection.execute(_KEPT, {"among": json.dumps([*lots])}).all()
    found: dict[str, LastSurvey | Row[Any]] = {row.lot: row for row in rows}
    missing = [lot for lot in lots if lot not in found]
    return {**found, **made(connection, missing)} if missing else found


def made(connection: Connection, lots: Sequence[str]) -> Mapping[str, LastSurvey]:
    """Return the newest surveys of lots, by ids, from the rows that they follow from."""
    rows = connection.execute(_MADE, {"among": json.dumps([*lots])}).mappings().all()
    surveyed = [row for row in rows if row["survey"] is not None]
    counts = {row["id"]: each for row, each in zip(surveyed, counts_of(connection, surveyed), strict=True)}
    none: dict[str, Any] = dict.fromkeys(COUNTS)
    return {
        str(row["id"]): LastSurvey(**{name: row[name] for name in _NAMES}, **counts.get(row["id"], none))
        for row in rows
    }


def has_more(connection: Connection) -> bool:
    """Return whether rows are to be made again."""
    return connection.execute(_CHANGED.limit(1), {"among": "[]"}).first() is not None


def renew(connection: Connection, damaged: Sequence[str] = ()) -> bool:
    """Make the rows again that triggers have forgotten, some at most; return whether others are left.

    ``damaged``: lots that get none, because readers pass over some of what it would follow from.
    """
    changed = connection.execute(_CHANGED, {"among": json.dumps([*damaged])}).scalars().all()
    if not changed:
        return False
    try:
        rows = made(connection, changed[:_AT_ONCE])
    except (TypeError, ValueError, OverflowError) as error:  # a value that is none: readers pass it over, or name it
        _LOG.warning("the newest surveys of lots are not kept: %s", error)
        return False
    connection.execute(_KEEP, [{"of": lot, **asdict(each)} for lot, each in rows.items()])
    return len(changed) > _AT_ONCE
