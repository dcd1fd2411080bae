"""Lots that come back from the desk that a store is sent to: the desk's plan takes the place of the one here.

Nothing is lost: a lot that was changed here stays until the desk has that change, and the looks of surveys stay with
their stalls (`hawk.lots.documents.plan_rows`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from sqlalchemy import Connection, select, update
from sqlalchemy.dialects.sqlite import insert

from hawk.lots import commands
from hawk.lots.documents import plan_rows
from hawk.lots.documents.collection import is_erased
from hawk.lots.documents.lot_document import LotDocument, LotPart, plan_digest
from hawk.lots.documents.lot_states import LotState, keep, outer_first, part_here, plan_here
from hawk.lots.documents.parts import digest_of
from hawk.lots.documents.source import came_from_desk
from hawk.lots.outbox import is_waiting
from hawk.lots.plan.versions import edit_of
from hawk.lots.schema import DESK, DOCUMENT, LOT, LOT_DOCUMENT, SURVEY
from hawk.lots.storage.states import LOT_STATE
from hawk.lots.values import Register

DESK_WRITER: Final = ""
"""Writer of what a desk gave."""
WHO: Final = "desk"
"""Name by which the log of changes calls it."""


@dataclass(frozen=True, slots=True)
class LotQuery:
    """Question to a desk for its lots. ``target``: name of the desk, as deliveries have it.

    ``after``: the state behind which lots are asked for. ``held``: that of a lot which an answer before left out here.
    """

    target: str
    after: int = 0
    held: int | None = None
    is_first: bool = False
    """The desk has given nothing yet, or has another store: states of before say nothing of its lots."""


@dataclass(frozen=True, slots=True)
class LotAnswer:
    """``next``: the next question; None when the desk has no more.

    ``replaced``: names of lots whose plan had versions of its own here, and is the desk's now.
    """

    next: LotQuery | None
    replaced: tuple[str, ...]


def first_query(connection: Connection, target: str) -> LotQuery:
    """Return the first question to a desk, by its name in deliveries."""
    state = connection.execute(select(DESK.c.state).where(DESK.c.target == target)).scalar()
    return LotQuery(target, int(state or 0), is_first=state is None)


def take_back(
    connection: Connection, document: LotDocument, asked: LotQuery, now: float, register: Register | None
) -> LotAnswer:
    """Take lots of a desk in.

    A lot that is edited here, or whose change the desk has not got, stays, and comes again with a later question.

    Args:
        connection: One that writes.
        document: The answer to a question.
        asked: The question.
        now: UTC, Unix seconds.
        register: Finds the stalls of surveys of a lot that became part of another one.

    Raises LotStoreError for a lot that is damaged here.
    """
    if document.state < asked.after:  # the desk has another store, or an older copy of it
        return LotAnswer(LotQuery(asked.target, is_first=True), ())
    if asked.is_first:
        connection.execute(update(LOT_DOCUMENT).where(LOT_DOCUMENT.c.writer == DESK_WRITER).values(state=0))
    held, replaced = asked.held, []
    for part in outer_first(document.lots):
        here = part_here(connection, part.id)
        if is_erased(connection, part.id):
            continue
        if here is not None and _is_held(connection, here, asked.target):
            held = part.state if held is None else min(held, part.state)
        elif _take(connection, part, here):
            replaced.append(part.name)
    _move_surveys(connection, document, now, register)
    values = {"target": asked.target, "state": document.state if held is None else min(held - 1, document.state)}
    is_other = DESK.c.state != values["state"]
    noted = insert(DESK).values(values)
    connection.execute(noted.on_conflict_do_update(index_elements=["target"], set_=values, where=is_other))
    following = LotQuery(asked.target, document.state, held) if document.state > asked.after else None
    return LotAnswer(following, tuple(replaced))


def _is_held(connection: Connection, here: LotPart, target: str) -> bool:
    """Return whether a lot is edited here, or has a change that the desk has not got."""
    if edit_of(connection, here.id) is not None:
        return True
    came = came_from_desk(connection, here.id)
    is_changed = came is None or came.is_changed(here)
    return is_changed and is_waiting(connection, LOT_STATE, here.id, target)


def _take(connection: Connection, part: LotPart, here: LotPart | None) -> bool:
    """Take a lot in, unless a later state of it is here; return whether its plan here had versions of its own."""
    came = came_from_desk(connection, part.id)
    arrived = LotState(DESK_WRITER, "", part.state, digest_of(part), "", part.state)
    if came is not None and (came.state, came.digest) >= arrived.order:
        return False
    is_other = here is None or plan_digest(here) != plan_digest(part)
    touched = plan_rows.store(connection, part, DESK_WRITER) if is_other else []
    plan_rows.name_lot(connection, part)
    keep(connection, part, arrived)
    for lot in (part.id, *touched):
        is_row = (LOT_DOCUMENT.c.lot == lot) & (LOT_DOCUMENT.c.writer == DESK_WRITER)
        connection.execute(update(LOT_DOCUMENT).where(is_row).values(plan=plan_here(connection, lot)))
    return here is not None and bool({*here.layouts} - {*part.layouts})


def _move_surveys(connection: Connection, document: LotDocument, now: float, register: Register | None) -> None:
    """Bring surveys of this store from lots that became part of others into those."""
    for part in document.lots:
        into = _whole_of(connection, part.id)
        if into is None or into == part.id:
            continue
        own = select(SURVEY.c.id).where(SURVEY.c.lot == part.id, SURVEY.c.seq.not_in(select(DOCUMENT.c.survey)))
        for survey in connection.execute(own).scalars().all():
            commands.move(connection, survey, {"lot": into}, WHO, now, register)


def _whole_of(connection: Connection, lot: str) -> str | None:
    """Return the lot that a lot became part of in the end: itself, where it did not."""
    asked: Any = select(LOT.c.merged_into).where(LOT.c.id == lot)
    row = connection.execute(asked).first()
    if row is None:
        return None
    return lot if row.merged_into is None else _whole_of(connection, row.merged_into)
