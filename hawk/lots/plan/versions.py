"""Versions of a lot's layout, the open edit that makes the next one, and the revision of its plan, by which a page
follows the changes that others make.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Final

from sqlalchemy import Connection, bindparam, func, select, update
from sqlalchemy.dialects.sqlite import insert

from hawk.lots.storage.schema import EDIT, LAYOUT, PLAN
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

_REVISION: Final = select(PLAN.c.revision).where(PLAN.c.lot == bindparam("lot"))
_NEXT: Final = (
    insert(PLAN)
    .values(lot=bindparam("lot"), revision=1, whole=0)
    .on_conflict_do_update(index_elements=[PLAN.c.lot], set_={"revision": PLAN.c.revision + 1})
    .returning(PLAN.c.revision)
)


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


def revision_of(connection: Connection, lot: str) -> int:
    """Return the revision of a lot's plan; 0 before its first change."""
    return int(connection.execute(_REVISION, {"lot": lot}).scalar() or 0)


def whole_since(connection: Connection, lot: str) -> int:
    """Return the revision from which on steps of edits say what changed."""
    return int(connection.execute(select(PLAN.c.whole).where(PLAN.c.lot == lot)).scalar() or 0)


def next_revision(connection: Connection, lot: str) -> int:
    """Give a lot's plan the next revision, and return it."""
    return int(connection.execute(_NEXT, {"lot": lot}).scalar_one())


def read_again(connection: Connection, lot: str) -> None:
    """Give a lot's plan the next revision after a change that is no step: who follows the plan reads all of it."""
    number = next_revision(connection, lot)
    connection.execute(update(PLAN).where(PLAN.c.lot == lot).values(whole=number))
