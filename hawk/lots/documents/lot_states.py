"""States of lots that came as documents: which of them the tables follow, and which wait for a person.

A lot's plan is followed from the drone that made the lot: as long as nobody here has changed it since, or where the
drone changed the very plan that it took from here. Each other state waits, as proposals
(`hawk.lots.documents.plan_edits`). Of one writer's states from one base the newest counts, whatever came last.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from sqlalchemy import Connection, insert, or_, select, update

from hawk.lots.documents import plan_rows, source
from hawk.lots.documents.arrival import Outcome
from hawk.lots.documents.lot_document import LotBase, LotPart, kept_lot, lot_body, plan_digest
from hawk.lots.documents.parts import digest_of
from hawk.lots.plan.versions import edit_of
from hawk.lots.storage.schema import LOT, LOT_DOCUMENT

_MOST_PLANS: Final = 16
"""Digests of a lot's tables that are kept with a state."""
UNKNOWN: Final = "unknown"
"""Digest of a plan that an earlier version of the store has written, and that nobody has changed before its end."""


@dataclass(frozen=True, slots=True)
class LotState:
    """A row of `LOT_DOCUMENT`, without its body."""

    writer: str
    base: str
    state: int
    digest: str
    plan: str
    decided: int

    @property
    def plans(self) -> tuple[str, ...]:
        """Digests of the tables since they were written by this state, the last one as they are."""
        return tuple(self.plan.split())

    @property
    def order(self) -> tuple[int, str]:
        """Order of states: of the greater number, of two alike of the greater digest."""
        return self.state, self.digest


def states_of(connection: Connection, lot: str) -> list[LotState]:
    """Return the states of a lot that came, each writer's and base's newest."""
    names = ("writer", "base", "state", "digest", "plan", "decided")
    asked = select(*(LOT_DOCUMENT.c[name] for name in names)).where(LOT_DOCUMENT.c.lot == lot)
    return [LotState(*row) for row in connection.execute(asked.order_by(LOT_DOCUMENT.c.writer, LOT_DOCUMENT.c.base))]


def is_followed(state: LotState) -> bool:
    """Return whether a state was written into the tables, or dropped by a person."""
    return state.decided >= state.state


@dataclass(frozen=True, slots=True)
class LotArrival:
    """Outcome of a state that came. ``is_current``: the tables were written by it, or say the same."""

    outcome: Outcome
    is_current: bool

    @classmethod
    def of(cls, newness: Outcome, *, is_current: bool) -> LotArrival:
        """Return what became of a state that was new here, known or older: a new one that is not followed waits."""
        return cls(Outcome.WAITS if newness is Outcome.TAKEN and not is_current else newness, is_current)


def newness(arrived: tuple[int, str], known: tuple[int, str] | None) -> Outcome:
    """Return whether a state is new here, known or older, by the orders of both: number, and digest."""
    if known is None or known < arrived:
        return Outcome.TAKEN
    return Outcome.KNOWN if known == arrived else Outcome.OLDER


def outer_first(lots: Sequence[LotPart]) -> list[LotPart]:
    """Return lots, each behind the one that it became part of; those that go round at the end."""
    found: list[LotPart] = []
    left = [*lots]
    while left:
        there = {each.id for each in found}
        next_ones = [each for each in left if each.merged_into is None or each.merged_into in there] or left
        found += next_ones
        left = [each for each in left if each not in next_ones]
    return found


def collect_lot(connection: Connection, part: LotPart, writer: str) -> LotArrival:
    """Keep a state of a lot that a drone has sent; return what became of it.

    Raises LotStoreError for a lot that is damaged here.
    """
    states = states_of(connection, part.id)
    base = part.base.plan if part.base is not None else ""
    known = next((each for each in states if (each.writer, each.base) == (writer, base)), None)
    arrived = LotState(writer, base, part.state, digest_of(part), "", 0)
    is_new = newness(arrived.order, None if known is None else known.order)
    if known is not None and is_new is not Outcome.TAKEN and is_followed(known) and known.plan:
        return LotArrival(is_new, is_current=True)  # most surveys bring a lot as it was: its plan is not read
    here = part_here(connection, part.id)
    if known is None and here is not None and _is_copy(part):
        return LotArrival(Outcome.KNOWN, is_current=plan_digest(here) == base)
    former = None if known is None else body_of(connection, part.id, known)
    if known is not None and former is not None and is_new is not Outcome.TAKEN:
        arrived, part = known, former
    else:
        if known is not None:
            arrived = replace(arrived, plan=known.plan, decided=min(known.decided, part.state - 1))
        keep(connection, part, arrived)
    states = [each for each in states if each is not known] + [arrived]
    if here is None:
        follow(connection, part, arrived, states)
        return LotArrival.of(is_new, is_current=True)
    if _is_makers(states, arrived):
        part = _with_names(part, former, here)
        plan_rows.name_lot(connection, part)
    if not is_followed(arrived) and _may_follow(connection, here, arrived, states):
        follow(connection, part, arrived, states)
        return LotArrival.of(is_new, is_current=True)
    return LotArrival.of(is_new, is_current=plan_digest(here) == plan_digest(part))


def follow(connection: Connection, part: LotPart, arrived: LotState, states: Sequence[LotState]) -> None:
    """Write a state into the tables of its lot. ``states``: all of the lot."""
    for each in states:
        if each.plan and (each.writer, each.base) != (arrived.writer, arrived.base):
            _note(connection, part.id, each, plan="", decided=each.decided if each.writer == arrived.writer else 0)
    for lot in plan_rows.store(connection, part, arrived.writer):
        _note_plan(connection, lot)
    _note(connection, part.id, arrived, plan=plan_here(connection, part.id), decided=arrived.state)


def part_here(connection: Connection, lot: str) -> LotPart | None:
    """Return a lot as it is here, None without one. Raises LotStoreError for one that is damaged."""
    if connection.execute(select(LOT.c.id).where(LOT.c.id == lot)).first() is None:
        return None
    return source.lot_part(connection, lot)


def plan_here(connection: Connection, lot: str) -> str:
    """Return the digest of a lot's plan here; "" where there is none."""
    found = part_here(connection, lot)
    return "" if found is None else plan_digest(found)


def body_of(connection: Connection, lot: str, state: LotState) -> LotPart:
    """Return a lot as a state has it."""
    body = connection.execute(select(LOT_DOCUMENT.c.body).where(*_is_row(lot, state))).scalar_one()
    return kept_lot(body)


def _is_copy(part: LotPart) -> bool:
    """Return whether a lot is as it was given from here: it says nothing."""
    return part.base is not None and LotBase.of(part) == part.base


def _is_makers(states: Sequence[LotState], arrived: LotState) -> bool:
    """Return whether a state is the newest one of the drone whose states the tables follow."""
    own = [each for each in states if each.writer == arrived.writer]
    return any(each.plan for each in own) and all(each.order <= arrived.order for each in own)


def _is_of_copy(states: Sequence[LotState], arrived: LotState, plan: str) -> bool:
    """Return whether a state is of the drone that made a lot, of which another drone has sent a copy before."""
    makers = {each.writer for each in states if each.plan}
    is_copy = bool(makers) and all(each.base for each in states if each.writer in makers)
    is_own = not arrived.base and arrived.writer not in makers
    return is_copy and is_own and any(each.plans[-1:] == (plan,) for each in states)


def _may_follow(connection: Connection, here: LotPart, arrived: LotState, states: Sequence[LotState]) -> bool:
    """Return whether a plan is the maker's, who knew the one here when it was changed, and nobody here edits it."""
    if edit_of(connection, here.id) is not None:
        return False
    plan = plan_digest(here)
    as_written = [each.plans for each in states if each.plans[-1:] == (plan,) and each.writer == arrived.writer]
    is_known = plan == arrived.base or arrived.plan == UNKNOWN
    is_known |= any(arrived.base in plans or plans == arrived.plans for plans in as_written)
    return (_is_makers(states, arrived) and is_known) or _is_of_copy(states, arrived, plan)


def _with_names(part: LotPart, former: LotPart | None, here: LotPart) -> LotPart:
    """Return a state with the name and time zone that the lot gets: what was said here since stays."""
    before = former or part.base
    said: dict[str, Any] = {}
    for name in ("name", "time_zone"):
        was = getattr(part if before is None else before, name)
        is_changed_there, is_changed_here = getattr(part, name) != was, getattr(here, name) != was
        said[name] = getattr(here if is_changed_here or not is_changed_there else part, name)
    return part.model_copy(update=said)


def keep(connection: Connection, part: LotPart, state: LotState) -> None:
    """Keep a state of a lot in place of the one of its writer and base before."""
    values = {
        "state": state.state, "digest": state.digest, "plan": state.plan, "decided": state.decided,
        "body": lot_body(part),
    }  # fmt: skip
    changed = connection.execute(update(LOT_DOCUMENT).where(*_is_row(part.id, state)).values(**values))
    if not changed.rowcount:
        connection.execute(insert(LOT_DOCUMENT).values(lot=part.id, writer=state.writer, base=state.base, **values))


def _note(connection: Connection, lot: str, state: LotState, **values: Any) -> None:
    """Set columns of a state that have other values: each write is a change of the lot."""
    is_other = or_(*(LOT_DOCUMENT.c[name] != value for name, value in values.items()))
    connection.execute(update(LOT_DOCUMENT).where(*_is_row(lot, state), is_other).values(**values))


def _note_plan(connection: Connection, lot: str) -> None:
    """Note the plan of a lot of which another one's state has taken stalls, or brought them back."""
    states = states_of(connection, lot)
    plan = plan_here(connection, lot) if states else ""
    for each in states:
        if each.plans and each.plans[-1] != plan:
            _note(connection, lot, each, plan=" ".join((*each.plans[1 - _MOST_PLANS :], plan)))


def _is_row(lot: str, state: LotState) -> tuple[Any, ...]:
    return LOT_DOCUMENT.c.lot == lot, LOT_DOCUMENT.c.writer == state.writer, LOT_DOCUMENT.c.base == state.base
