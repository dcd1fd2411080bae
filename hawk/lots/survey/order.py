"""Order of surveys by the time at which they were taken: pictures of an earlier day may be stored later.

A landing follows the landings before it, whatever its clock says; its time counts where it is sure. Pictures whose time
is not sure, or later than now, come before all others: none of them is the last survey while another one is there.
Surveys of one time are in the order in which they were stored first: documents come in any order.
`hawk.lots.survey.moments` is the same without a store.
"""

from __future__ import annotations

from typing import Any, Final

from sqlalchemy import (
    ColumnElement,
    Connection,
    FromClause,
    ScalarSelect,
    and_,
    case,
    exists,
    func,
    not_,
    or_,
    select,
)

from hawk.lots.storage.schema import DOCUMENT, LOT, OBSERVATION, STALL, SURVEY
from hawk.lots.survey import moments
from hawk.lots.survey.source import SurveyKind

_LOOK: Final = OBSERVATION.alias()
_LOOKED: Final = SURVEY.alias()


def has_been(survey: FromClause = SURVEY) -> ColumnElement[bool]:
    """Return whether a survey's time is not later than now by the clock of the store's connection."""
    found: ColumnElement[bool] = moments.has_been(survey.c.ended, func.hawk_now())
    return found


def is_sure(survey: FromClause = SURVEY) -> ColumnElement[bool]:
    """Return whether a survey's time is sure.

    A landing's was compared when it landed (`hawk.lots.survey.landing.at_landing`): the clock here may be wrong.
    """
    return and_(survey.c.time_is_sure, or_(has_been(survey), survey.c.kind == SurveyKind.FLOWN.value))


def landing_of(survey: FromClause = SURVEY) -> ColumnElement[Any]:
    """Return the number of a survey in the order of the store that it was stored in first."""
    return func.coalesce(survey.c.landing, survey.c.seq)


def now_of(connection: Connection) -> float:
    """Return now by the clock of the store's connection, Unix seconds."""
    return float(connection.execute(select(func.hawk_now())).scalar_one())


def is_ordered(survey: FromClause = SURVEY) -> ColumnElement[bool]:
    """Return whether it is known which surveys a survey follows: by its sure time, or as a landing."""
    return or_(is_sure(survey), survey.c.kind == SurveyKind.FLOWN.value)


def taken_at(survey: FromClause = SURVEY) -> ColumnElement[Any]:
    """Return when a survey was taken, Unix seconds: of a landing without a sure time that of the one before it.

    Pictures whose time is later than now have 0.
    """
    before = SURVEY.alias()
    is_first = landing_of(before) < landing_of(survey)
    is_before = before.c.time_is_sure & (before.c.kind == SurveyKind.FLOWN.value) & is_first
    earlier = select(func.max(before.c.ended)).where(is_before, before.c.lot == survey.c.lot)
    is_picture = survey.c.kind == SurveyKind.PICTURE.value
    return case(
        (is_sure(survey), survey.c.ended),
        (and_(is_picture, has_been(survey)), survey.c.ended),
        (is_picture, 0.0),
        else_=func.coalesce(earlier.correlate(survey).scalar_subquery(), 0.0),
    )


def ordered_at(survey: FromClause = SURVEY) -> ColumnElement[Any]:
    """Return when a survey was taken, Unix seconds; NULL where it is not known which surveys it follows."""
    return case((is_ordered(survey), taken_at(survey)))


def newest_first(survey: FromClause = SURVEY) -> tuple[ColumnElement[Any], ...]:
    """Return the order of surveys with the last one first."""
    return is_ordered(survey).desc(), taken_at(survey).desc(), *_last_stored(survey)


def oldest_first(survey: FromClause = SURVEY) -> tuple[ColumnElement[Any], ...]:
    """Return the order of surveys with the last one at the end."""
    return is_ordered(survey), taken_at(survey), landing_of(survey), survey.c.id


def _last_stored(survey: FromClause) -> tuple[ColumnElement[Any], ...]:
    return landing_of(survey).desc(), survey.c.id.desc()


def last_of(lot: ColumnElement[Any]) -> ScalarSelect[Any]:
    """Return the number of the last survey of a lot, correlated with the table of ``lot``.

    It is the last one of the last of each kind, which the index of the order finds: a lot with thousands of surveys
    costs no more than one with some.
    """
    each = SURVEY.alias()
    of_kinds = [_last(lot, kind, is_sure) for kind in SurveyKind for is_sure in (True, False)]
    asked = select(each.c.seq).where(each.c.seq.in_([*of_kinds, _last_to_come(lot)]))
    return asked.order_by(*newest_first(each)).limit(1).correlate(lot.table).scalar_subquery()


def _last(lot: ColumnElement[Any], kind: SurveyKind, is_sure: bool) -> ScalarSelect[Any]:
    """Return the last survey of a lot among those of one kind whose times are sure, or are not, and have been.

    Landings follow each other whatever their clocks say, so without sure times the last one was stored last.
    """
    each = SURVEY.alias()
    is_of = and_(each.c.lot == lot, each.c.kind == kind.value, each.c.time_is_sure.is_(is_sure))
    if kind is SurveyKind.FLOWN and not is_sure:
        asked = select(each.c.seq).where(is_of).order_by(*_last_stored(each)).limit(1)
    else:
        is_there = is_of if kind is SurveyKind.FLOWN else and_(is_of, has_been(each))
        asked = select(each.c.seq).where(is_there).order_by(each.c.ended.desc(), *_last_stored(each)).limit(1)
    return asked.correlate(lot.table).scalar_subquery()


def _last_to_come(lot: ColumnElement[Any]) -> ScalarSelect[Any]:
    """Return the picture of a lot that was stored last among those whose time is later than now."""
    each = SURVEY.alias()
    is_of = and_(each.c.lot == lot, each.c.kind == SurveyKind.PICTURE.value, not_(has_been(each)))
    asked = select(each.c.seq).where(is_of).order_by(*_last_stored(each)).limit(1)
    return asked.correlate(lot.table).scalar_subquery()


def last_landing(connection: Connection, origin: str) -> float | None:
    """Return the end of the last landing whose time is sure, Unix seconds, without the survey of an ``origin``.

    Lot by lot, by the index of the order: the rows of a million surveys are not read.
    """
    is_other = and_(SURVEY.c.time_is_sure, SURVEY.c.kind == SurveyKind.FLOWN.value, SURVEY.c.origin != origin)
    last = select(SURVEY.c.ended).order_by(SURVEY.c.ended.desc()).limit(1)
    of_lot = last.where(SURVEY.c.lot == LOT.c.id, is_other).correlate(LOT).scalar_subquery()
    of_lots = select(func.max(of_lot)).select_from(LOT)
    of_none = last.where(SURVEY.c.lot.is_(None), is_other)
    found = [connection.execute(asked).scalar() for asked in (of_lots, of_none)]
    return max((float(each) for each in found if each is not None), default=None)


def is_last_look(connection: Connection) -> ColumnElement[bool]:
    """Return the condition that a row of `OBSERVATION` is the last look at its row of `STALL`: that of a join."""
    is_of = OBSERVATION.c.stall == STALL.c.key
    return and_(is_of, OBSERVATION.c.survey == _newest_look(connection, STALL.c.key))


def _newest_look(connection: Connection, stall: ColumnElement[Any]) -> ScalarSelect[Any]:
    """Return the number of the last survey that looked at a stall, correlated with the table of ``stall``.

    Without pictures and documents in the store it is the greatest number, by the index: a thousand surveys cost no more
    than one.
    """
    looks = select(_LOOK.c.survey).where(_LOOK.c.stall == stall)
    of_lot = select(SURVEY.c.seq).where(SURVEY.c.lot == LOT.c.id, SURVEY.c.kind == SurveyKind.PICTURE.value)
    has_pictures = select(LOT.c.id).where(of_lot.correlate(LOT).exists()).exists()  # lot by lot, by the index
    if connection.execute(select(or_(has_pictures, exists().select_from(DOCUMENT)))).scalar():
        of = looks.join(_LOOKED, _LOOKED.c.seq == _LOOK.c.survey)
        asked = of.order_by(*newest_first(_LOOKED)).limit(1)
    else:
        asked = looks.with_only_columns(func.max(_LOOK.c.survey))
    return asked.correlate(stall.table).scalar_subquery()
