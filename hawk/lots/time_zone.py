"""Time zone of a lot: the one that a person chose, else that of its place.

The map of time zones is read by a process of its own: it takes 35 MB, and holds the interpreter for tenths of a second.
It steps back as the thread that waits for it does, and no further: that would wait for seconds beside other programs.
"""

from __future__ import annotations

import json
import logging
import subprocess
import sys
from collections.abc import Collection, Mapping, Sequence
from functools import lru_cache
from typing import Any, Final
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError, available_timezones

from sqlalchemy import Connection, RowMapping, select

from hawk.lots.storage.schema import LOT
from hawk.lots.values import UTC_NAME, LotInputError, NotFoundError

_LOG = logging.getLogger(__name__)
_FORM: Final = "must be a name of the time zone database, as Europe/Amsterdam or UTC"
_LONGEST_S: Final = 30.0
_UTC_NAMES: Final = ("Etc/UCT", "Etc/UTC", "Etc/Universal", "Etc/Zulu", "UCT", "Universal", "Zulu")
_READER: Final = (
    "import json, sys, tzfpy; "
    "json.dump([tzfpy.get_tz(east, north) for north, east in json.load(sys.stdin)], sys.stdout)"
)
_Place = tuple[float, float]
"""Latitude and longitude, degrees."""


def time_zone_of(connection: Connection, row: Mapping[str, Any] | RowMapping) -> str:
    """Return the name of the time zone of a lot, a row of `LOT`."""
    return time_zones_of(connection, [row])[0]


def time_zones_of(connection: Connection, rows: Sequence[Mapping[str, Any] | RowMapping]) -> list[str]:
    """Return the names of the time zones of lots, rows of `LOT`: that of its place for one with a name, chosen on
    another computer, that this computer does not know.
    """
    said = [row["time_zone"] for row in rows]
    chosen = ["" if name is None or _clock(str(name)) is None else str(name) for name in said]
    if all(chosen):
        return chosen
    places = [(float(row["latitude"]), float(row["longitude"])) for row in rows]
    known = _known()
    if any(place not in known for place in places):  # the map is read once for all lots
        others = connection.execute(select(LOT.c.latitude, LOT.c.longitude).where(LOT.c.time_zone.is_(None))).all()
        _learn({*places, *((float(north), float(east)) for north, east in others)} - known.keys())
    return [name or known[place] for name, place in zip(chosen, places, strict=True)]


def zone_of_lot(connection: Connection, lot: str) -> str:
    """Return the name of the time zone of a lot by its id. Raises NotFoundError."""
    row = connection.execute(select(LOT).where(LOT.c.id == lot, LOT.c.merged_into.is_(None))).mappings().first()
    if row is None:
        raise NotFoundError("lot: there is no lot with this id; reload the list")
    return time_zone_of(connection, row)


def clock_of(name: str) -> ZoneInfo:
    """Return the clock of a time zone by its name. Raises LotInputError."""
    found = _clock(name)
    if found is None:
        raise LotInputError("time_zone", f"{_FORM}, not {name!r}")
    return found


def _clock(name: str) -> ZoneInfo | None:
    try:
        return ZoneInfo(name)
    except (ZoneInfoNotFoundError, ValueError, OSError):
        return None


def shown_zone(name: str) -> str:
    """Return the name of a time zone as it is shown: UTC has several in the database, browsers and computers differ."""
    return UTC_NAME if name in _UTC_NAMES else name


def checked_zone(name: object) -> str | None:
    """Return the name of a time zone that a person chose, None for that of the place. Raises LotInputError."""
    if name is None:
        return None
    if not isinstance(name, str) or name not in available_timezones() - {"Factory", "localtime"}:
        raise LotInputError("time_zone", f"{_FORM}, not {name!r}; null: that of the lot's place")
    return shown_zone(name)


@lru_cache(maxsize=1)
def _known() -> dict[_Place, str]:
    """Return the time zones of the places that were asked for since the program began."""
    return {}


def _learn(places: Collection[_Place]) -> None:
    """Note the time zones of places: UTC for one that Python does not know."""
    asked = sorted(places)
    try:
        done = subprocess.run(
            [sys.executable, "-P", "-c", _READER], input=json.dumps(asked), capture_output=True, text=True,
            timeout=_LONGEST_S, check=True,
        )  # fmt: skip
        found = dict(zip(asked, json.loads(done.stdout), strict=True))
    except (OSError, ValueError, subprocess.SubprocessError) as error:
        _LOG.warning("the time zones of lots are not known by their places, times are UTC: %s", error)
        found = {}
    shown = {name: shown_zone(name) for name in {*found.values()} if _clock(name) is not None}
    _known().update({place: shown.get(found.get(place, ""), UTC_NAME) for place in asked})
