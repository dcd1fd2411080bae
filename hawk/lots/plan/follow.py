"""Revision numbers of plans, by which a page follows what others change."""

from __future__ import annotations

from sqlalchemy import Connection, insert, select, update

from hawk.lots.tables import PLAN


def revision_of(connection: Connection, lot: str) -> int:
    """Return the revision of a lot's plan; 0 before its first change."""
    return int(connection.execute(select(PLAN.c.revision).where(PLAN.c.lot == lot)).scalar() or 0)


def whole_since(connection: Connection, lot: str) -> int:
    """Return the revision from which on steps of edits say what changed."""
    return int(connection.execute(select(PLAN.c.whole).where(PLAN.c.lot == lot)).scalar() or 0)


def next_revision(connection: Connection, lot: str) -> int:
    """Give a lot's plan the next revision, and return it."""
    number = revision_of(connection, lot) + 1
    if number == 1:
        connection.execute(insert(PLAN).prefix_with("OR IGNORE").values(lot=lot, revision=0, whole=0))
    connection.execute(update(PLAN).where(PLAN.c.lot == lot).values(revision=number))
    return number


def read_again(connection: Connection, lot: str) -> None:
    """Give a lot's plan the next revision after a change that is no step: who follows the plan reads all of it."""
    number = next_revision(connection, lot)
    connection.execute(update(PLAN).where(PLAN.c.lot == lot).values(whole=number))
