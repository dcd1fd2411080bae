"""Period and clock of a question about statistics, from text."""

from __future__ import annotations

import time
from datetime import date, datetime, timedelta, tzinfo
from pathlib import Path
from typing import Final
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

from hawk.lots.values import LotInputError
from hawk.stats.panel import Period

_FORM: Final = "a date, as 2026-05-04, or a date with a time, as 2026-05-04T10:30"
_UTC: Final = ("Etc/UCT", "Etc/UTC", "Etc/Universal", "Etc/Zulu", "UCT", "Universal", "Zulu")
_LOCAL: Final = Path("/etc/localtime")


def clock_of(name: str | None) -> tuple[tzinfo, str]:
    """Return the clock of a time zone by its name, as Europe/Amsterdam; without one the computer's.

    Raises LotInputError. The store knows no lot's time zone: the name says which clock the figures use.
    """
    if name is not None:
        try:
            return ZoneInfo(name), _called(name)
        except (ZoneInfoNotFoundError, ValueError, OSError):
            words = f"must be a name of the time zone database, as Europe/Amsterdam or UTC, not {name!r}"
            raise LotInputError("time_zone", words) from None
    return _computers()


def _called(zone: str) -> str:
    """Return the name of a time zone as it is shown: UTC has several in the database, browsers and computers differ."""
    return "UTC" if zone in _UTC else zone


def _computers() -> tuple[tzinfo, str]:
    _, found, zone = str(_LOCAL.resolve()).partition("zoneinfo/")
    if found:
        try:
            return ZoneInfo(zone), f"{_called(zone)} (this computer's)"
        except (ZoneInfoNotFoundError, ValueError, OSError):
            pass  # a database of time zones that Python does not know: its offset of today
    local = datetime.now().astimezone().tzinfo
    assert local is not None  # noqa: S101 - `astimezone` sets one
    return local, f"{time.strftime('%Z')} (this computer's)"


def period_of(begin: str | None, end: str | None, time_zone: str | None = None) -> Period:
    """Return the period from ``begin`` to ``end``: the day of an end that is a date belongs to it.

    Times without an offset are those of the clock. Raises LotInputError with the field and the remedy.
    """
    clock, name = clock_of(time_zone)
    first = None if begin is None else _moment("from", begin, clock, is_end=False)
    last = None if end is None else _moment("to", end, clock, is_end=True)
    if first is not None and last is not None and first >= last:
        raise LotInputError("to", f"{end} is not after {begin}: exchange both, or leave one out")
    return Period(first, last, clock, name)


def _moment(field: str, text: str, clock: tzinfo, *, is_end: bool) -> float:
    try:
        if ":" not in text:
            day = date.fromisoformat(text.strip()) + timedelta(days=int(is_end))
            return datetime(day.year, day.month, day.day, tzinfo=clock).timestamp()
        moment = datetime.fromisoformat(text.strip())
        return (moment if moment.tzinfo is not None else moment.replace(tzinfo=clock)).timestamp()
    except (ValueError, OverflowError):
        raise LotInputError(field, f"must be {_FORM}, not {text!r}") from None
