"""Changes of lots, layouts and surveys by persons, each written with its undo in the transaction of a connection.

Requests are JSON values as the API takes them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from sqlalchemy import Connection, func, select

from hawk.lots import change_log, operations, pins
from hawk.lots.answers import Done, Pinned
from hawk.lots.change_detection import takeover
from hawk.lots.change_log import Change
from hawk.lots.documents import plan_edits
from hawk.lots.ingest import registered_place
from hawk.lots.operations import Estate
from hawk.lots.plan.queries import all_stalls
from hawk.lots.plan.versions import check_not_edited, newest_layout
from hawk.lots.queries import lot_row, survey_row
from hawk.lots.registration.frames import Move
from hawk.lots.registration.lot_pair import move_onto
from hawk.lots.registration.survey_place import (
    Doubt,
    Findings,
    datum_of,
    move_of,
    placed_by,
    registered,
)
from hawk.lots.storage.rows import Row, rows_where
from hawk.lots.storage.schema import LAYOUT, LOT, OBSERVATION, SECTION, STALL, SURVEY, ZONE
from hawk.lots.time_zone import checked_zone
from hawk.lots.values import (
    Doubtful,
    LotStoreError,
    Placed,
    Register,
    Registration,
    checked_name,
    new_id,
)


def rename(connection: Connection, lot_id: str, name: object, who: str, now: float) -> Done:
    """Name a lot. Raises LotInputError, NotFoundError."""
    named = lot_row(connection, lot_id).setting(name=checked_name(name))
    return change_log.write(connection, Change("name", lot_id, (named,)), who, now)


def choose_time_zone(connection: Connection, lot_id: str, name: object, who: str, now: float) -> Done:
    """Say a lot's time zone; None: that of its place. Raises LotInputError, NotFoundError."""
    chosen = lot_row(connection, lot_id).setting(time_zone=checked_zone(name))
    return change_log.write(connection, Change("time_zone", lot_id, (chosen,)), who, now)


def merge(
    connection: Connection, lot_id: str, other: object, who: str, now: float, register: Register | None = None
) -> Done:
    """Merge another lot into this one. Raises LotInputError, NotFoundError.

    ``register``: finds the plan of a lot on the same ground on this one's: so its surveys get their stalls here, and
    each that had no place by itself. Where it is not certain, they are unregistered.
    """
    kept, beside = _whole(connection, lot_id), _whole(connection, str(other), "with")
    change = operations.merged(kept, beside, who, now)
    unplaced = {row.key for row in change.rows if row.table == SURVEY.name and row["placed"] == Placed.UNREGISTERED}
    if register is not None and unplaced:
        surveys = [row for row in beside.surveys if row.key in unplaced]
        joined = _joined(connection, kept.id, beside.id, surveys, register)
        placed = {row.key for row in joined if row.table == SURVEY.name}
        rows = [row for row in change.rows if row.table != SURVEY.name or row.key not in placed]
        change = replace(change, rows=(*rows, *joined))
    return change_log.write(connection, change, who, now)


def _joined(connection: Connection, kept: str, other: str, surveys: Sequence[Row], register: Register) -> list[Row]:
    """Return the rows of surveys of another lot as surveys of the kept one, with their places among its stalls."""
    move = move_onto(connection, kept, other, register)
    rows: list[Row] = []
    for survey in surveys:
        if survey["seen_ground"] is None:
            continue
        looked = Findings.stored(survey.values or {})
        if move is None or survey["north"] is None:
            outcome = registered(connection, kept, looked, register, other)
        else:
            outcome = placed_by(connection, kept, looked, move.after(Move.stored(survey.values or {})))
        rows += [row.removed() for row in rows_where(connection, OBSERVATION, survey=survey.key[0])]
        rows += _at(connection, survey, kept, looked, outcome)
    return rows


def split(connection: Connection, lot_id: str, asked: Mapping[str, Any], who: str, now: float) -> Done:
    """Split the stalls within ``outline`` off as a lot called ``name``. Raises LotInputError, NotFoundError."""
    name, part = checked_name(asked.get("name")), operations.checked_outline(asked.get("outline"))
    change = operations.split(_whole(connection, lot_id), part, name, new_id(), who, now)
    return change_log.write(connection, change, who, now)


def move(
    connection: Connection, survey_id: str, asked: Mapping[str, Any], who: str, now: float, register: Register | None
) -> Done:
    """Move a survey to the lot ``lot``; None: to a new one, called ``name``. Raises LotInputError, NotFoundError.

    ``register`` finds its stalls among those of that lot; where it is not certain, the survey is unregistered there.
    """
    survey = survey_row(connection, survey_id)
    looks = rows_where(connection, OBSERVATION, survey=survey.key[0])
    return change_log.write(connection, _move(connection, survey, looks, asked, now, register), who, now)


def delete(connection: Connection, survey_id: str, who: str, now: float) -> Done:
    """Delete a survey of a lot; undoing brings it back. Raises NotFoundError, LotStoreError."""
    survey = survey_row(connection, survey_id)
    assert survey.values is not None  # noqa: S101 - it is there
    if survey.values["lot"] is None:
        raise LotStoreError("survey: no lot has it; reload the list")
    looks = rows_where(connection, OBSERVATION, survey=survey.key[0])
    return change_log.write(connection, operations.deleted(survey, looks), who, now)


def choose(connection: Connection, survey_id: str, asked: Mapping[str, Any], who: str, now: float) -> Done:
    """Register a survey at ``place``, the number of one of those that its doubt names, from 0.

    Raises LotInputError, NotFoundError, and LotStoreError for a survey that waits for no place.
    """
    survey = survey_row(connection, survey_id)
    assert survey.values is not None  # noqa: S101 - it is there
    doubt = Doubt.read(survey.values["doubt"])
    if survey.values["placed"] != Placed.UNREGISTERED or doubt is None:
        raise LotStoreError("survey: waits for no place; reload the list")
    number = doubt.choice(asked.get("place"))
    lot_id, looked = survey["lot"], Findings.stored(survey.values)
    outcome = placed_by(connection, lot_id, looked, move_of(doubt.places[number]))
    rows = _at(connection, survey, lot_id, looked, outcome, replace(doubt, chosen=number).json())
    return change_log.write(connection, Change("place", lot_id, rows), who, now)


def take_over(connection: Connection, lot_id: str, asked: Mapping[str, Any], who: str, now: float) -> Done:
    """Take proposals of a survey, or of a ``drone``, over as one version of the layout.

    Raises as `takeover.take_over`, and NotFoundError.
    """
    lot_row(connection, lot_id)
    if "drone" in asked:
        return plan_edits.take_over(connection, lot_id, asked, who, now)
    return takeover.take_over(connection, lot_id, asked, who, now)


def drop(connection: Connection, lot_id: str, asked: Mapping[str, Any], who: str, now: float) -> Done:
    """Drop proposals of a survey, or of a ``drone``. Raises LotInputError, NotFoundError."""
    lot_row(connection, lot_id)
    if "drone" in asked:
        return plan_edits.drop(connection, lot_id, asked, who, now)
    return takeover.drop(connection, lot_id, asked, who, now)


def pin(connection: Connection, lot_id: str, asked: Mapping[str, Any], who: str, now: float) -> Pinned:
    """Pin a lot to its place on Earth, or unpin it; return the change and by how much the lot is moved.

    ``north``, ``east`` (metres) and ``turn`` (degrees) are those of the lot's datum and frame; ``residual``: metres by
    which two points are farther apart than the lot has them. Raises LotInputError, NotFoundError, BeingEditedError.
    """
    lot_row(connection, lot_id)
    done, pinned = pins.pin(connection, lot_id, asked, who, now)
    return Pinned(
        **dict(done), north=round(pinned.move.north, 3), east=round(pinned.move.east, 3),
        turn=round(math.degrees(pinned.move.turn), 4), residual=round(pinned.residual, 3),
        datum=list(datum_of(connection, lot_id)),
    )  # fmt: skip


def undo(connection: Connection, seq: int, now: float) -> str:
    """Undo a change; return its kind. Raises NotFoundError, and LotStoreError when something followed it."""
    return change_log.undo(connection, seq, now)


def _move(
    connection: Connection,
    survey: Row,
    looks: list[Row],
    asked: Mapping[str, Any],
    now: float,
    register: Register | None,
) -> Change:
    target = asked.get("lot")
    if target is not None:
        lot_id = str(lot_row(connection, str(target)).key[0])
        change = operations.moved(survey, looks, lot_id)
        if register is None or survey.values is None:
            return change
        looked = Findings.stored(survey.values)
        outcome = registered(connection, lot_id, looked, register)
        return Change(change.kind, change.lot, (*change.rows[1:], *_at(connection, survey, lot_id, looked, outcome)))
    number = connection.execute(select(func.count()).select_from(LOT)).scalar_one() + 1
    name = checked_name(asked.get("name", f"Lot {number}"))
    first_key = int(connection.execute(select(func.max(STALL.c.key))).scalar() or 0) + 1
    begun = operations.begun(survey, name, new_id(), first_key, now)
    ended = tuple(row.removed() for row in looks)
    return Change(begun.kind, begun.lot, (*ended, *begun.rows))


def _at(
    connection: Connection, survey: Row, lot_id: str, looked: Findings, outcome: Registration | Doubtful,
    doubt: str | None = None,
) -> tuple[Row, ...]:  # fmt: skip
    """Return the rows of a survey of a lot as they are after the outcome of its registration."""
    if isinstance(outcome, Doubtful):
        doubt = Doubt(outcome.why, outcome.places).json()
    here = operations.unplaced(survey, lot_id, Placed.UNREGISTERED, doubt)
    if isinstance(outcome, Doubtful):
        return (here,)
    keys = {stall.id: stall.key for stall in all_stalls(connection, lot_id)}
    same = {number: keys[stall] for number, stall in outcome.same.items()}
    placed = operations.placed(here, **registered_place(outcome, newest_layout(connection, lot_id)))
    return (placed, *operations.look_rows(survey.key[0], same, looked.stalls))


def _whole(connection: Connection, lot_id: str, field: str = "lot") -> Estate:
    found = lot_row(connection, lot_id, field)
    check_not_edited(connection, lot_id)
    read: Callable[..., list[Row]] = rows_where
    return Estate(
        lot=found,
        datum=datum_of(connection, lot_id),
        layouts=tuple(read(connection, LAYOUT, lot=lot_id)),
        stalls=tuple(read(connection, STALL, lot=lot_id)),
        zones=tuple(read(connection, ZONE, lot=lot_id)),
        sections=tuple(read(connection, SECTION, lot=lot_id)),
        surveys=tuple(read(connection, SURVEY, lot=lot_id)),
    )
