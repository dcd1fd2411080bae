"""Edits of plans: one person at a time corrects a plan; an edit is one version of the layout until it is closed.

Operations count at once: a survey that lands meanwhile is placed on the stalls as the person has them, and says the
version. An edit is in the store, so that it outlives the program. Undo and redo go through all steps of the open edit.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, Final

from sqlalchemy import Connection, RowMapping, Select, bindparam, delete, func, insert, select, update

from hawk.lots import change_log
from hawk.lots.change_log import Group, State
from hawk.lots.plan import checks, drafts, label_claims, queries, serialize, steps, versions
from hawk.lots.plan.answers import Closed, Edited, Opened, StepCounts, Stepped
from hawk.lots.plan.operations import operation_of
from hawk.lots.plan.values import Draft, PlanZone
from hawk.lots.plan.versions import Edit, edit_of, newest_layout
from hawk.lots.storage.rows import row_of
from hawk.lots.storage.schema import CHANGE, EDIT, FORMER, LAYOUT, LOT, SURVEY
from hawk.lots.values import (
    BeingEditedError,
    LotInputError,
    LotStoreError,
    NotFoundError,
    check_fields,
    checked_name,
    moment,
    new_id,
    utc,
)

IDLE_S: Final = 15 * 60.0
"""Seconds without an operation after which another person takes an edit over without being asked."""
CORRECTED: Final = "corrected by hand"
KIND: Final = "plan"
"""Kind of the change that an edit is."""


def open_edit(connection: Connection, lot: str, asked: Mapping[str, Any], now: float) -> Opened:
    """Open an edit for the person ``who``, or go on with theirs.

    Another person's edit is closed as it is and a new one opened where that one was idle for `IDLE_S`, or where
    ``take_over`` is true. Raises LotInputError, NotFoundError and BeingEditedError.
    """
    check_lot(connection, lot)
    check_fields(asked, ("who", "take_over"))
    who = checked_name(asked.get("who"), "who")
    if not isinstance(asked.get("take_over", False), bool):
        raise LotInputError("take_over", "must be true or false")
    edit = edit_of(connection, lot)
    if edit is not None and edit.who == who:
        connection.execute(update(EDIT).where(EDIT.c.id == edit.id).values(touched=now))
        return _opened(connection, edit)
    if edit is not None:
        if not asked.get("take_over") and now - edit.touched < IDLE_S:
            words = f"{edit.who} edits this plan since {utc(edit.began)}: wait until it is closed, or take it over"
            raise BeingEditedError(edit.who, edit.began, words)
        _close(connection, edit, f"taken over by {who}", now)
    made = Edit(new_id(), lot, newest_layout(connection, lot) + 1, who, now, now)
    values = {"version": made.version, "who": who, "began": now, "touched": now}
    connection.execute(insert(EDIT).values(id=made.id, lot=lot, **values))
    return _opened(connection, made)


def do(connection: Connection, lot: str, asked: Mapping[str, Any], now: float) -> Edited:
    """Do the ``operation`` within the open ``edit``; return the stalls that changed.

    Raises LotInputError, NotFoundError and LotStoreError; nothing is written then.
    """
    check_fields(asked, ("edit", "operation"))
    operation = operation_of(asked.get("operation"))
    edit = held(connection, lot, asked, now)
    stalls = queries.selected(connection, lot, operation)
    context = queries.context_of(connection, lot, operation)
    return done(connection, edit, operation.do, drafts.drafted(operation, stalls, context), now)


def done(connection: Connection, edit: Edit, kind: str, drafted: Draft, now: float) -> Edited:
    """Do a draft as one step of an edit, ``kind``; return the stalls that changed.

    Raises LotInputError for a draft that does not fit the plan; nothing is written then.
    """
    lot = edit.lot
    draft = checked(connection, lot, drafted, queries.zones_of(connection, lot))
    if draft.is_empty:
        return _edited(connection, edit, versions.revision_of(connection, lot), ())
    if newest_layout(connection, lot) < edit.version:
        first = {"version": edit.version, "valid_from": now, "why": CORRECTED, "who": edit.who}
        connection.execute(insert(LAYOUT).values(lot=lot, **first))
    groups = steps.store(connection, lot, edit.version, draft)
    revision = versions.next_revision(connection, lot)
    was_undone = (CHANGE.c.edit == edit.id) & (CHANGE.c.state == State.UNDONE.value)
    connection.execute(update(CHANGE).where(was_undone).values(state=State.DROPPED.value))
    change_log.record(connection, kind, lot, edit.who, now, groups, edit=edit.id, revision=revision)
    return _edited(connection, edit, revision, groups)


def checked(connection: Connection, lot: str, draft: Draft, zones: Sequence[PlanZone]) -> Draft:
    """Return a draft that fits the plan, with a label for each stall. Raises LotInputError for one that does not."""
    found = label_claims.with_labels_free(connection, lot, draft)
    near = queries.around(
        connection, lot, (*found.placed, *found.nameless), found.touched, with_rows=bool(found.nameless)
    )
    checks.check_places(found, near, zones)
    if found.placed or found.begun_sections:
        checks.check_extent(found, queries.extent_of(connection, lot))
    if not found.nameless:
        return found
    return label_claims.labelled(found, near, queries.labels_beside(connection, lot, found.touched))


def undo(connection: Connection, lot: str, asked: Mapping[str, Any], now: float) -> Stepped:
    """Undo the newest step of the open ``edit``; return the stalls that changed. Raises as `do`."""
    edit = held(connection, lot, asked, now, ("edit",))
    newest = _steps(edit, State.DONE).order_by(CHANGE.c.seq.desc())
    row = connection.execute(newest.limit(1)).mappings().first()
    if row is None:
        raise LotStoreError("edit: nothing of it is left to undo")
    return _stepped(connection, edit, row, State.UNDONE)


def redo(connection: Connection, lot: str, asked: Mapping[str, Any], now: float) -> Stepped:
    """Do the step again that was undone last; return the stalls that changed. Raises as `do`."""
    edit = held(connection, lot, asked, now, ("edit",))
    oldest = _steps(edit, State.UNDONE).order_by(CHANGE.c.seq)
    row = connection.execute(oldest.limit(1)).mappings().first()
    if row is None:
        raise LotStoreError("edit: nothing of it is left to do again")
    return _stepped(connection, edit, row, State.DONE)


def _steps(edit: Edit, state: State) -> Select[Any]:
    return select(CHANGE).where(CHANGE.c.edit == edit.id, CHANGE.c.state == state.value)


def _stepped(connection: Connection, edit: Edit, row: RowMapping, state: State) -> Stepped:
    groups = change_log.read(connection, row["seq"])
    if state is State.UNDONE:
        groups = tuple(group.back() for group in reversed(groups))
    change_log.apply(connection, groups)
    revision = versions.next_revision(connection, edit.lot)
    connection.execute(update(CHANGE).where(CHANGE.c.seq == row["seq"]).values(state=state.value, revision=revision))
    return Stepped(**dict(_edited(connection, edit, revision, groups)), operation=row["kind"])


def close(connection: Connection, lot: str, asked: Mapping[str, Any], now: float) -> Closed:
    """Close the open ``edit``: its version of the layout is final, with the reason ``why``.

    Returns the number of the change, which undoes the whole edit, and the version; both None when nothing is changed.
    Raises as `do`.
    """
    edit = held(connection, lot, asked, now, ("edit", "why"))
    why = CORRECTED if asked.get("why") in (None, "") else checked_name(asked["why"], "why")
    return _close(connection, edit, why, now)


def _close(connection: Connection, edit: Edit, why: str, now: float) -> Closed:
    version = {"lot": edit.lot, "version": edit.version}
    seq = None
    if _steps_left(connection, edit).undo:
        is_version = (LAYOUT.c.lot == edit.lot) & (LAYOUT.c.version == edit.version)
        connection.execute(update(LAYOUT).where(is_version).values(why=why))
        made = row_of(connection, LAYOUT.name, tuple(version.values()))
        begun = Group(LAYOUT.name, (made.key,), None, made.values)
        seq = change_log.record(connection, KIND, edit.lot, edit.who, now, [begun])
    elif not _surveys_with(connection, edit.lot, edit.version):
        connection.execute(delete(FORMER).where(FORMER.c.lot == edit.lot, FORMER.c.ends == edit.version))
        connection.execute(delete(LAYOUT).where(LAYOUT.c.lot == edit.lot, LAYOUT.c.version == edit.version))
    connection.execute(update(EDIT).where(EDIT.c.id == edit.id).values(closed=now, change=seq))
    return Closed(lot=edit.lot, edit=edit.id, seq=seq, layout=None if seq is None else edit.version)


def _surveys_with(connection: Connection, lot: str, version: int) -> int:
    asked = select(func.count()).select_from(SURVEY).where(SURVEY.c.lot == lot, SURVEY.c.layout == version)
    return int(connection.execute(asked).scalar_one())


def check_lot(connection: Connection, lot: str) -> None:
    """Refuse an id of no lot. Raises NotFoundError."""
    there = select(LOT.c.id).where(LOT.c.id == lot, LOT.c.merged_into.is_(None))
    if connection.execute(there).scalar() is None:
        raise NotFoundError("lot: there is no lot with this id; reload the list")


def held(connection: Connection, lot: str, asked: Mapping[str, Any], now: float, keys: tuple[str, ...] = ()) -> Edit:
    """Return the open edit that a request names, which is not idle since now. ``keys``: those that it may have.

    Raises LotInputError, NotFoundError, BeingEditedError, and LotStoreError for an edit that was closed.
    """
    check_lot(connection, lot)
    if keys:
        check_fields(asked, keys)
    named = asked.get("edit")
    if not isinstance(named, str) or not named.isascii():
        raise LotInputError("edit", "must be the id of your edit: open one first")
    edit = edit_of(connection, lot)
    if edit is None or edit.id != named:
        former = connection.execute(select(EDIT.c.closed).where(EDIT.c.id == named, EDIT.c.lot == lot)).scalar()
        words = "there is none with this id" if former is None else f"it was closed at {utc(former)}"
        if edit is None:
            raise LotStoreError(f"edit: {words}; open another one")
        words += f", and {edit.who} edits this plan since {utc(edit.began)}; wait, or take it over"
        raise BeingEditedError(edit.who, edit.began, words)
    connection.execute(update(EDIT).where(EDIT.c.id == edit.id).values(touched=now))
    return edit


def _opened(connection: Connection, edit: Edit) -> Opened:
    return Opened(
        **dict(_steps_left(connection, edit)), edit=edit.id, lot=edit.lot, who=edit.who, since=moment(edit.began),
        layout=edit.version, revision=versions.revision_of(connection, edit.lot),
    )  # fmt: skip


def _steps_left(connection: Connection, edit: Edit) -> StepCounts:
    states = Counter(connection.execute(_STATES, {"edit": edit.id}).scalars())
    return StepCounts(undo=states[State.DONE.value], redo=states[State.UNDONE.value])


_STATES: Final = select(CHANGE.c.state).where(CHANGE.c.edit == bindparam("edit"))


def _edited(connection: Connection, edit: Edit, revision: int, groups: Sequence[Group]) -> Edited:
    changes, left = serialize.changes_of(connection, edit.lot, groups), _steps_left(connection, edit)
    return Edited(**dict(changes), **dict(left), edit=edit.id, revision=revision)
