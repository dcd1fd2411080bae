"""Period and clock of a question about statistics, from text."""

from __future__ import annotations

from datetime import date, datetime, timedelta, tzinfo
from typing import Final

from sqlalchemy import Connection

from hawk.lots.time_zone import clock_of, shown_zone, zone_of_lot
from hawk.lots.values import LotInputError
from hawk.stats.panel import Period

_FORM: Final = "a date, as 2026-05-04, or a date with a time, as 2026-05-04T10:30"


def period_of_lot(
    connection: Connection, lot: str, begin: str | None = None, end: str | None = None, time_zone: str | None = None
) -> Period:  # fmt: skip
    """Return a period on the lot's clock, or on that of ``time_zone``. Raises NotFoundError, LotInputError."""
    return period_of(begin, end, zone_of_lot(connection, lot) if time_zone is None else time_zone)


def period_of(begin: str | None, end: str | None, time_zone: str) -> Period:
    """Return the period from ``begin`` to ``end``: the day of an end that is a date belongs to it.

    Times without an offset are those of the time zone. Raises LotInputError with the field and the remedy.
    """
    clock = clock_of(time_zone)
    first = None if begin is None else _moment("from", begin, clock, is_end=False)
    last = None if end is None else _moment("to", end, clock, is_end=True)
    if first is not None and last is not None and first >= last:
        raise LotInputError("to", f"{end} is not after {begin}: exchange both, or leave one out")
    return Period(first, last, clock, shown_zone(time_zone))


def _moment(field: str, text: str, clock: tzinfo, *, is_end: bool) -> float:
    try:
        if ":" not in text:
            day = date.fromisoformat(text.strip()) + timedelta(days=int(is_end))
            return datetime(day.year, day.month, day.day, tzinfo=clock).timestamp()
        moment = datetime.fromisoformat(text.strip())
        return (moment if moment.tzinfo is not None else moment.replace(tzinfo=clock)).timestamp()
    except (ValueError, OverflowError):
        raise LotInputError(field, f"must be {_FORM}, not {text!r}") from None
