"""Lots that come back from the desk that a store is sent to: the desk's plan takes the place of the one here.

Nothing is lost: a lot that was changed here stays until the desk has that change, and the looks of surveys stay with
their stalls (`hawk.lots.documents.plan_rows`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Final

from pydantic import TypeAdapter, ValidationError
from sqlalchemy import Connection, select, update
from sqlalchemy.dialects.sqlite import insert

from hawk.lots import commands
from hawk.lots.documents import plan_rows
from hawk.lots.documents.collection import is_erased
from hawk.lots.documents.lot_document import LotDocument, LotDue, LotPart, plan_digest
from hawk.lots.documents.lot_states import LotState, keep, outer_first, part_here, plan_here
from hawk.lots.documents.parts import digest_of
from hawk.lots.documents.source import came_from_desk
from hawk.lots.ingest import lot_places
from hawk.lots.outbox import is_waiting
from hawk.lots.plan.versions import edit_of, revision_of
from hawk.lots.registration.lot_match import SAME_SHARE, which_lot
from hawk.lots.storage.schema import DESK, DOCUMENT, LOT, LOT_DOCUMENT, SURVEY
from hawk.lots.storage.states import LOT_STATE
from hawk.lots.values import Register

DESK_WRITER: Final = ""
"""Writer of what a desk gave."""
WHO: Final = "desk"
"""Name by which the log of changes calls it."""
_DUE: Final = TypeAdapter(tuple[LotDue, ...])


@dataclass(frozen=True, slots=True)
class LotQuery:
    """Question to a desk for its lots. ``target``: name of the desk, as deliveries have it.

    ``after``: the state behind which lots are asked for. ``held``: the least state of a lot that has to wait here;
    ``apart``: of one that was left out, since another lot here has its ground. ``is_first``: the desk has given nothing
    yet, or has another store: states of before say nothing of its lots. ``is_any``: answers brought something.
    """

    target: str
    after: int = 0
    held: int | None = None
    apart: int | None = None
    is_first: bool = False
    is_any: bool = False

    def following(self, state: int) -> LotQuery | None:
        """Return the question after an answer up to a state; None when the desk has no more.

        With what came, a lot that was left out may have a place here: it is asked for again.
        """
        if state > self.after:
            return replace(self, after=state, is_first=False)
        if self.is_any and self.apart is not None:
            return replace(self, after=self.apart - 1, apart=None, is_any=False)
        return None


@dataclass(frozen=True, slots=True)
class LotAnswer:
    """``next``: the next question; None when the desk has no more.

    ``replaced``: names of lots whose plan had versions of its own here, and is the desk's now. ``due``: what is due
    there.
    """

    next: LotQuery | None
    replaced: tuple[str, ...]
    due: tuple[LotDue, ...] = ()


def first_query(connection: Connection, target: str) -> LotQuery:
    """Return the first question to a desk, by its name in deliveries."""
    row = connection.execute(select(DESK).where(DESK.c.target == target)).first()
    return LotQuery(target, is_first=True) if row is None else LotQuery(target, row.state, apart=row.apart)


def due_there(connection: Connection, target: str) -> tuple[LotDue, ...]:
    """Return what was due at a desk, by its name in deliveries, when it was asked last."""
    found = connection.execute(select(DESK.c.due).where(DESK.c.target == target)).scalar()
    try:
        return () if found is None else _DUE.validate_json(found, strict=True)
    except ValidationError:  # damaged: the next answer brings it
        return ()


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
    asked = replace(asked, is_first=False)
    replaced: list[str] = []
    joined = {part.id for part in document.lots if part.merged_into is not None}
    for part in outer_first(document.lots):
        here = part_here(connection, part.id)
        if is_erased(connection, part.id):
            continue
        if _is_apart(connection, part, here, joined):
            asked = replace(asked, apart=_least(asked.apart, part.state))
        elif here is not None and _is_held(connection, here, asked.target):
            asked = replace(asked, held=_least(asked.held, part.state))
        elif not _is_known(connection, part):
            asked = replace(asked, is_any=True)
            replaced += [part.name] if _take(connection, part, here) else []
    _move_surveys(connection, document, now, register)
    reached = _least(document.state, None if asked.held is None else asked.held - 1)
    due = _DUE.dump_json(document.due).decode()
    values = {"target": asked.target, "state": reached, "apart": asked.apart, "due": due}
    noted = insert(DESK).values(values)
    connection.execute(noted.on_conflict_do_update(index_elements=["target"], set_=values))
    return LotAnswer(asked.following(document.state), tuple(replaced), document.due)


def _least(one: int | None, other: int | None) -> int | None:
    return min((each for each in (one, other) if each is not None), default=None)


def _is_apart(connection: Connection, part: LotPart, here: LotPart | None, joined: set[str]) -> bool:
    """Return whether a lot that is not here was made apart from one that is, on its ground, or is part of such a lot.

    Two lots there would make each next survey a question. It comes when a person at the desk has merged both.
    ``joined``: lots that became part of others.
    """
    if part.merged_into is not None:
        return part_here(connection, part.merged_into) is None
    if here is not None:
        return False
    lots = [each for each in lot_places(connection) if each.id not in joined]
    decision = which_lot(plan_rows.outline_of(part.outline), lots)
    return any(each.overlap >= SAME_SHARE for each in decision.candidates)


def _is_known(connection: Connection, part: LotPart) -> bool:
    """Return whether this state of a lot is here, or a later one."""
    came = came_from_desk(connection, part.id)
    return came is not None and (came.state, came.digest) >= (part.state, digest_of(part))


def _is_held(connection: Connection, here: LotPart, target: str) -> bool:
    """Return whether a lot is edited here, or has a change that the desk has not got."""
    if edit_of(connection, here.id) is not None:
        return True
    came = came_from_desk(connection, here.id)
    is_changed = came is None or came.is_changed(connection, here)
    return is_changed and is_waiting(connection, LOT_STATE, here.id, target)


def _take(connection: Connection, part: LotPart, here: LotPart | None) -> bool:
    """Take a lot in; return whether its plan here had versions of its own."""
    arrived = LotState(DESK_WRITER, "", part.state, digest_of(part), "", 0)
    is_other = here is None or plan_digest(here) != plan_digest(part)
    touched = plan_rows.store(connection, part, DESK_WRITER) if is_other else []
    plan_rows.name_lot(connection, part)
    keep(connection, part, arrived)
    for lot in (part.id, *touched):
        is_row = (LOT_DOCUMENT.c.lot == lot) & (LOT_DOCUMENT.c.writer == DESK_WRITER)
        values = {"plan": plan_here(connection, lot), "decided": revision_of(connection, lot)}
        connection.execute(update(LOT_DOCUMENT).where(is_row).values(**values))
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
