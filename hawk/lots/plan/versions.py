"""Versions of a lot's layout, and the open edit that makes the next one."""

from __future__ import annotations

from dataclasses import dataclass, fields

from sqlalchemy import Connection, func, select

from hawk.lots.tables import EDIT, LAYOUT
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


def newest_layout(connection: Connection, lot: str) -> int:
    """Return the newest version of a lot's layout; 0 without one."""
    return int(connection.execute(select(func.max(LAYOUT.c.version)).where(LAYOUT.c.lot == lot)).scalar() or 0)


def edit_of(connection: Connection, lot: str) -> Edit | None:
    """Return the open edit of a lot's plan."""
    columns = [EDIT.c[each.name] for each in fields(Edit)]
    row = connection.execute(select(*columns).where(EDIT.c.lot == lot, EDIT.c.closed.is_(None))).first()
    return None if row is None else Edit(*row)


def check_not_edited(connection: Connection, lot: str) -> None:
    """Refuse a change of a lot whose plan a person edits. Raises BeingEditedError."""
    edit = edit_of(connection, lot)
    if edit is not None:
        words = f"{edit.who} edits the plan of this lot since {utc(edit.began)}: close the edit first"
        raise BeingEditedError(edit.who, edit.began, words)
