"""Parameters of OGC API Features (OGC 17-069r4): a part of a list, a box of the Earth, and a time or a period."""

from __future__ import annotations

import math
from datetime import UTC, date, datetime, timedelta
from typing import Annotated, Any, Final

from pydantic import Field

from hawk.lots.values import LotInputError
from hawk.web.v1.parameters import OF_DIGITS, USUAL_ITEMS, Query

ROOT: Final = "/features"
"""Address of the landing page below that of the API."""
MOST_FEATURES: Final = 500
"""Features have corners: 500 of them are as much text as 1000 items of a list."""
_LONGEST: Final = 200
_OPEN: Final = ("", "..")
_NUMBER: Final = {"type": "number"}


def _as_box(schema: dict[str, Any]) -> None:
    """Show a box as the standard's OpenAPI does: a list of 4 or 6 numbers, in one text."""
    description = schema["description"]
    schema.clear()
    sizes = [{"minItems": size, "maxItems": size} for size in (4, 6)]
    schema.update(type="array", oneOf=sizes, items=_NUMBER, description=description)


class Items(Query):
    """The part of a collection that is asked for."""

    limit: Annotated[
        int,
        Field(ge=1, description=f"most features of the answer; {USUAL_ITEMS} without it, {MOST_FEATURES} at most"),
        OF_DIGITS,
    ] = USUAL_ITEMS
    offset: Annotated[int, Field(ge=0, description="features that are left out before the first one"), OF_DIGITS] = 0
    bbox: Annotated[
        str | None,
        Field(
            max_length=_LONGEST, json_schema_extra=_as_box,
            description="west, south, east, north in degrees; heights between them are not used",
        ),
    ] = None  # fmt: skip
    datetime: Annotated[
        str | None,
        Field(
            max_length=_LONGEST,
            description="a time, a date, or a period: two of them with a slash between, `..` for an open end",
        ),
    ] = None  # fmt: skip


def box_of(text: str) -> tuple[float, float, float, float]:
    """Return west, south, east and north of a box. Raises LotInputError."""
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) == 6:
        numbers = [numbers[k] for k in (0, 1, 3, 4)]
    if len(numbers) != 4 or not all(map(math.isfinite, numbers)):
        raise LotInputError("bbox", "must be four numbers with commas between: west, south, east, north")
    west, south, east, north = numbers
    if south > north:
        raise LotInputError("bbox", f"has its south, {south:g}, above its north, {north:g}: exchange both")
    return west, south, east, north


def period_of(text: str) -> tuple[float | None, float | None]:
    """Return begin and end of a time or a period, UTC, Unix seconds; None for an open end. Raises LotInputError."""
    first, slash, last = text.partition("/")
    if not slash:
        return _moment(first, is_end=False), _moment(first, is_end=True)
    begin = None if first in _OPEN else _moment(first, is_end=False)
    end = None if last in _OPEN else _moment(last, is_end=True)
    if begin is not None and end is not None and begin > end:
        raise LotInputError("datetime", "ends before it begins: exchange both")
    return begin, end


def _moment(text: str, *, is_end: bool) -> float:
    """Return a moment; a date is its first moment, or its last one."""
    try:
        if "T" not in text.upper():
            day = date.fromisoformat(text)
            begin = datetime(day.year, day.month, day.day, tzinfo=UTC)
            return (begin + timedelta(days=1)).timestamp() - 1e-3 if is_end else begin.timestamp()
        found = datetime.fromisoformat(text)
        return (found if found.tzinfo is not None else found.replace(tzinfo=UTC)).timestamp()
    except (ValueError, OverflowError):
        words = "must be a time, as 2026-05-04T10:30:00Z, a date, or two of them with a slash between"
        raise LotInputError("datetime", words) from None
