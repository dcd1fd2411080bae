"""A question about a lot's use: parts of it, days of the week and hours of the day, read once from text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Final

from pydantic import Field

from hawk.lots.values import LotInputError
from hawk.stats.values import WEEKDAYS, Weekday

SHORT: Final = tuple(day[:3].lower() for day in WEEKDAYS)
"""Days of the week as a question names them."""
_DAYS_FORM: Final = "as mon-fri, sat or mon,wed"
_HOURS_FORM: Final = "hours from 0 to 24, as 7-11, 8 or 7-9,16-18"
DayHour = Annotated[int, Field(ge=0, le=23)]


@dataclass(frozen=True, slots=True)
class Asked:
    """Stalls of any of the ``rows``, of any of the ``zones`` and of any of the ``kinds``, or ``sections``; none named:
    all stalls.

    ``hours``: those of the lot's clock that begin then, as 7 for 7:00 to 8:00.
    """

    weekdays: tuple[Weekday, ...] = WEEKDAYS
    hours: tuple[DayHour, ...] = tuple(range(24))
    rows: tuple[str, ...] = ()
    zones: tuple[str, ...] = ()
    kinds: tuple[str, ...] = ()
    sections: tuple[str, ...] = ()


def asked_of(
    weekday: str | None = None, hour: str | None = None, rows: Sequence[str] = (), zones: Sequence[str] = (),
    kinds: Sequence[str] = (), sections: Sequence[str] = (),
) -> Asked:  # fmt: skip
    """Return a question from text: days as "mon-fri" or "sat,sun", hours as "7-11", whose end is not asked.

    Raises LotInputError with the field and the remedy.
    """
    weekdays = WEEKDAYS if weekday is None else tuple(WEEKDAYS[number] for number in _weekdays(weekday))
    hours = range(24) if hour is None else _hours(hour)
    if sections and (rows or zones or kinds):
        raise LotInputError("section", "counts vehicles; rows, zones and kinds are of stalls: ask for one or the other")
    parts = (tuple(dict.fromkeys(each)) for each in (rows, zones, kinds, sections))
    return Asked(weekdays, tuple(hours), *parts)


def _weekdays(text: str) -> list[int]:
    found: set[int] = set()
    for begin, given in _ranges(text):
        end = begin if given is None else given
        if begin not in SHORT or end not in SHORT:
            raise LotInputError("weekday", f"must be days out of {', '.join(SHORT)}, {_DAYS_FORM}, not {text!r}")
        first, last = SHORT.index(begin), SHORT.index(end)
        found.update(day % len(SHORT) for day in range(first, last + 1 if first <= last else last + 1 + len(SHORT)))
    return sorted(found)


def _hours(text: str) -> list[int]:
    found: set[int] = set()
    for begin, given in _ranges(text):
        end = begin if given is None else given
        if not all(each.isascii() and each.isdecimal() and len(each) <= 2 for each in (begin, end)):
            raise LotInputError("hour", f"must be {_HOURS_FORM}, not {text!r}")
        first, last = int(begin), int(end) + (given is None)
        if not first < last <= 24:
            remedy = f"; write {begin}-24,0-{end} for a night" if 24 > first > last else ""
            raise LotInputError("hour", f"must be {_HOURS_FORM}, not {text!r}: the end is after the begin{remedy}")
        found.update(range(first, last))
    return sorted(found)


def _ranges(text: str) -> list[tuple[str, str | None]]:
    """Return the ends of each range of a list; None behind one value."""
    pairs = (each.lower().partition("-") for each in text.split(","))
    return [(begin.strip(), end.strip() if dash else None) for begin, dash, end in pairs]
