"""Versions of a lot's layout, and the open edit that makes the next one."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Final

from sqlalchemy import Connection, bindparam, func, select

from hawk.lots.schema import EDIT, LAYOUT
from hawk.lots.values import BeingEditedError, utc


@dataclass(frozen=True, slots=True)
class Edit:
    """An open edit of a plan; ``version``: of the layout that it makes. Times are UTC, Unix seconds."""

    id: str
    lot: str
    version: int
    who: str
    began: float
    touched: float


_OPEN: Final = select(*(EDIT.c[each.name] for each in fields(Edit))).where(
    EDIT.c.lot == bindparam("lot"), EDIT.c.closed.is_(None)
)
_NEWEST: Final = select(func.max(LAYOUT.c.version)).where(LAYOUT.c.lot == bindparam("lot"))


def newest_layout(connection: Connection, lot: str) -> int:
    """Return the newest version of a lot's layout; 0 without one."""
    return int(connection.execute(_NEWEST, {"lot": lot}).scalar() or 0)


def edit_of(connection: Connection, lot: str) -> Edit | None:
    """Return the open edit of a lot's plan."""
    row = connection.execute(_OPEN, {"lot": lot}).first()
    return None if row is None else Edit(*row)


def check_not_edited(connection: Connection, lot: str) -> None:
    """Refuse a change of a lot whose plan a person edits. Raises BeingEditedError."""
    edit = edit_of(connection, lot)
    if edit is not None:
        words = f"{edit.who} edits the plan of this lot since {utc(edit.began)}: close the edit first"
        raise BeingEditedError(edit.who, edit.began, words)
