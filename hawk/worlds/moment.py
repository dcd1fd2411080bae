"""Moments of a lot, read from text on the lot's own clock, and its conditions. It imports no library that draws."""

from __future__ import annotations

import re
from datetime import UTC, datetime, timedelta, timezone
from enum import StrEnum
from typing import Final

EARLIEST: Final = datetime(2025, 1, 1, 12, tzinfo=UTC)
LATEST: Final = datetime(2089, 12, 31, 12, tzinfo=UTC)
"""Moments between these are allowed: the daemon believes a GNSS clock from 2025 to 2090."""
_FORM: Final = "an ISO 8601 date and time, as 2026-05-04T10:30 (the lot's clock) or 2026-05-04T10:30+02:00"
_SPACE_FOR_PLUS: Final = re.compile(r"(T.*) (\d\d:?\d\d)$")


class Condition(StrEnum):
    """Time of day and weather of a world; ``day`` is dry, with some sun."""

    DAY = "day"
    OVERCAST = "overcast"
    DUSK = "dusk"
    NIGHT = "night"
    WET = "wet"
    SNOW = "snow"
    LEAVES = "leaves"


HOURS: Final = (Condition.DUSK, Condition.NIGHT)
"""Conditions that are times of day."""


def clock_of(longitude: float) -> timezone:
    """Return the clock of a place: the nautical time zone, one hour for each 15 degrees of longitude.

    The sun stands in the south (north of the tropics) within half an hour, and the equation of time, of its noon. It
    knows neither borders nor daylight saving.
    """
    return timezone(timedelta(hours=round(longitude / 15.0)))


def read_moment(text: str, longitude: float = 0.0) -> datetime:
    """Return a moment on the clock of a place, in whole seconds; a text without an offset is on that clock.

    A space before an offset counts as its plus, which a URL turns into a space.

    Raises:
        ValueError: The text is no moment, or one before `EARLIEST` or after `LATEST`; the message names the remedy.
    """
    clock = clock_of(longitude)
    plain = _SPACE_FOR_PLUS.sub(r"\1+\2", text.strip())
    try:
        moment = datetime.fromisoformat(plain)
    except ValueError:
        raise ValueError(f"must be {_FORM}, not {text!r}") from None
    if ":" not in plain:
        raise ValueError(f"must be {_FORM}, not {text!r}: the time of day is missing")
    if moment.tzinfo is None:
        moment = moment.replace(tzinfo=clock)
    try:
        moment = moment.astimezone(clock).replace(microsecond=0)
    except OverflowError:
        raise ValueError(f"must be {_FORM}, not {text!r}") from None
    if not EARLIEST <= moment <= LATEST:
        raise ValueError(f"must lie within {EARLIEST:%Y-%m-%d} to {LATEST:%Y-%m-%d}, not {text!r}")
    return moment
