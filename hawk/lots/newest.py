"""Order of surveys by the time at which they were taken: pictures of an earlier day may be stored later.

A landing follows the landings before it, whatever its clock says; its time counts where it is sure. Pictures have the
time of their files, or the one that a person gave. Surveys of one time are in the order in which they were stored.
"""

from __future__ import annotations

from typing import Any, Final

from sqlalchemy import ColumnElement, Connection, FromClause, ScalarSelect, case, exists, func, or_, select

from hawk.lots.source import SurveyKind
from hawk.lots.tables import OBSERVATION, SURVEY

_STALL: Final = OBSERVATION.alias()
_LOOKED: Final = SURVEY.alias()


def taken_at(survey: FromClause = SURVEY) -> ColumnElement[Any]:
    """Return when a survey was taken, Unix seconds: of a landing without a sure time that of the one before it."""
    before = SURVEY.alias()
    is_before = before.c.time_is_sure & (before.c.kind == SurveyKind.FLOWN.value) & (before.c.seq < survey.c.seq)
    earlier = select(func.max(before.c.ended)).where(is_before, before.c.lot == survey.c.lot)
    is_said = or_(survey.c.time_is_sure, survey.c.kind == SurveyKind.PICTURE.value)
    return case((is_said, survey.c.ended), else_=func.coalesce(earlier.correlate(survey).scalar_subquery(), 0.0))


def newest_first(survey: FromClause = SURVEY) -> tuple[ColumnElement[Any], ...]:
    """Return the order of surveys with the last one first."""
    return taken_at(survey).desc(), survey.c.seq.desc()


def oldest_first(survey: FromClause = SURVEY) -> tuple[ColumnElement[Any], ...]:
    """Return the order of surveys with the last one at the end."""
    return taken_at(survey), survey.c.seq


def last_of(lot: ColumnElement[Any]) -> ScalarSelect[Any]:
    """Return the number of the last survey of a lot, correlated with the table of ``lot``."""
    each = SURVEY.alias()
    asked = select(each.c.seq).where(each.c.lot == lot).order_by(*newest_first(each)).limit(1)
    return asked.correlate(lot.table).scalar_subquery()


def newest_look(connection: Connection, stall: ColumnElement[Any]) -> ScalarSelect[Any]:
    """Return the number of the last survey that looked at a stall, correlated with the table of ``stall``.

    Without pictures in the store it is the greatest number, by the index: a thousand surveys cost no more than one.
    """
    looks = select(_STALL.c.survey).where(_STALL.c.stall == stall)
    has_pictures = select(exists().where(SURVEY.c.kind == SurveyKind.PICTURE.value))
    if connection.execute(has_pictures).scalar():
        of = looks.join(_LOOKED, _LOOKED.c.seq == _STALL.c.survey)
        asked = of.order_by(*newest_first(_LOOKED)).limit(1)
    else:
        asked = looks.with_only_columns(func.max(_STALL.c.survey))
    return asked.correlate(stall.table).scalar_subquery()
