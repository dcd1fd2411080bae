"""Reach of a role that is for some lots: which lots these are now, and of which lot something else is.

A lot that was merged into another one counts as that one.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any, Final

from sqlalchemy import ColumnElement, Connection, select, true

from hawk.lots import pins
from hawk.lots.change_detection import takeover
from hawk.lots.plan import edits
from hawk.lots.storage.schema import CHANGE, LOT, SHARE, STALL, SURVEY

OF_ONE_LOT: Final = ("name", "time_zone", "place", "delete", pins.KIND, takeover.KIND, takeover.DROP, edits.KIND)
"""Kinds of changes that are about one lot alone: others make a lot, or end one."""
_LOT_OF: Final = {"survey": (SURVEY.c.id, SURVEY.c.lot), "stall": (STALL.c.id, STALL.c.lot),
                  "share": (SHARE.c.id, SHARE.c.lot)}  # fmt: skip
"""Kind of a thing -> the columns of its id and its lot."""


def lots_within(connection: Connection, given: Collection[str]) -> frozenset[str]:
    """Return the lots that some ids are of now, with all that were merged into one of these."""
    merged = select(LOT.c.id, LOT.c.merged_into).where(LOT.c.merged_into.is_not(None))
    into = {str(row.id): str(row.merged_into) for row in connection.execute(merged)}

    def whole(lot: str) -> str:
        passed = set()
        while lot in into and lot not in passed:
            passed.add(lot)
            lot = into[lot]
        return lot

    kept = {whole(each) for each in given}
    return frozenset(kept | {each for each in into if whole(each) in kept})


def is_within(column: ColumnElement[Any], lots: Collection[str] | None) -> ColumnElement[bool]:
    """Return the condition that a column names one of some lots; None: of all, and of none."""
    return true() if lots is None else column.in_(sorted(lots))


def lot_of(connection: Connection, kind: str, key: str) -> str | None:
    """Return the lot of a "lot", "survey", "stall", "share" or "change" by its id or number.

    None for one that is not there or has none, and for a change that is about more than one lot.
    """
    if kind == "lot":
        return key
    if kind == "change":
        named = CHANGE.c.seq == int(key), CHANGE.c.edit.is_(None), CHANGE.c.kind.in_(OF_ONE_LOT)
        asked = select(CHANGE.c.lot).where(*named)
    else:
        of_id, of_lot = _LOT_OF[kind]
        asked = select(of_lot).where(of_id == key)
    found = connection.execute(asked).scalar()
    return None if found is None else str(found)
