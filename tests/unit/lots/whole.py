"""All that the lists of a store say of a lot, as the JSON values of the API."""

from __future__ import annotations

from typing import Any

from sqlalchemy import Connection

from hawk.lots import lists
from hawk.lots.answers import Part
from hawk.lots.change_detection.comparison import newest_registered
from hawk.lots.lists import Asked

ALL = Asked(limit=100_000)


def items(part: Part) -> list[dict[str, Any]]:
    """Return the items of a list."""
    found: list[dict[str, Any]] = part.model_dump(mode="json")["items"]
    return found


def lots(connection: Connection) -> list[dict[str, Any]]:
    """Return every lot."""
    return items(lists.lots(connection, ALL))


def stalls(connection: Connection, lot: str) -> list[dict[str, Any]]:
    """Return the stalls of a lot."""
    return items(lists.stalls(connection, lot, ALL))


def surveys(connection: Connection, lot: str | None = None) -> list[dict[str, Any]]:
    """Return the surveys of a lot; None: all."""
    return items(lists.surveys(connection, ALL, lot))


def layouts(connection: Connection, lot: str) -> list[dict[str, Any]]:
    """Return the versions of a lot's layout."""
    return items(lists.layouts(connection, lot, ALL))


def lot(connection: Connection, lot: str) -> dict[str, Any]:
    """Return a lot with its stalls, zones, surveys and layouts, and the newest survey beside the layout."""
    shown = lists.lot(connection, lot).model_dump(mode="json")
    shown["stall_count"] = shown.pop("stalls")
    return {
        **shown,
        "stalls": stalls(connection, lot),
        "surveys": surveys(connection, lot),
        "layouts": layouts(connection, lot),
        "zones": items(lists.zones(connection, lot, ALL)),
        "newest_registered": newest_registered(connection, lot).model_dump(mode="json"),
    }
