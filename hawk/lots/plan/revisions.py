"""Revision numbers of plans, by which a page follows the changes that others make."""

from __future__ import annotations

from typing import Final

from sqlalchemy import Connection, bindparam, select, update
from sqlalchemy.dialects.sqlite import insert

from hawk.lots.schema import PLAN

_REVISION: Final = select(PLAN.c.revision).where(PLAN.c.lot == bindparam("lot"))
_NEXT: Final = (
    insert(PLAN)
    .values(lot=bindparam("lot"), revision=1, whole=0)
    .on_conflict_do_update(index_elements=[PLAN.c.lot], set_={"revision": PLAN.c.revision + 1})
    .returning(PLAN.c.revision)
)


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
