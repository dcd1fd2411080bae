"""Lots and surveys as JSON values with the keys of ``/api/v1``; and the changes that the API asks for."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any, Final

import numpy as np
from sqlalchemy import Connection, RowMapping, func, select

from hawk.lots import changes, operations, pinning, proposing, taking
from hawk.lots.changes import Change, Done, Row
from hawk.lots.comparing import newest_registered, shapes_of
from hawk.lots.counts import counts_of
from hawk.lots.database import version_of
from hawk.lots.digests import check_whole
from hawk.lots.newest import is_sure_row, newest_first, newest_look, now_of
from hawk.lots.operations import LotRows
from hawk.lots.plan import editing, follow, shown
from hawk.lots.plan.versions import check_not_edited, newest_layout
from hawk.lots.registering import (
    Doubt,
    Looked,
    datum_of,
    move_of,
    placed_by,
    present_stalls,
    registered,
)
from hawk.lots.saving import new_id, registered_place, used_labels
from hawk.lots.source import SOURCE_COLUMNS, source_json
from hawk.lots.tables import CHANGE, LAYOUT, LOT, OBSERVATION, STALL, SURVEY, ZONE
from hawk.lots.values import (
    Doubtful,
    LotStoreError,
    NotFoundError,
    Placed,
    Register,
    Registration,
    outline_or_none,
    utc,
)

_Shown = Mapping[str, Any] | RowMapping
CHANGES_SHOWN: Final = 20
"""Newest changes that are listed."""
_SHOWN: Final = ("id", "seq", "lot", "layout", "placed", "free", "taken", "unknown", "blurred", "simulated", "program")
SURVEY_SHOWN: Final = (
    *_SHOWN, "latitude", "longitude", "north", "east", "turn", "doubt", "began", "ended", "time_is_sure", "candidates",
    *SOURCE_COLUMNS,
)  # fmt: skip
"""Columns of a survey that are shown."""


def lots(connection: Connection) -> dict[str, Any]:
    """Return every lot that was not merged into another one, the surveys that wait for an answer, and the changes."""
    rows = connection.execute(select(LOT).where(LOT.c.merged_into.is_(None)).order_by(LOT.c.made)).mappings()
    shown = [lot_json(connection, row) for row in rows]
    known = {lot["id"] for lot in shown}
    asked = connection.execute(select(SURVEY).where(SURVEY.c.placed == Placed.UNDECIDED.value)).mappings().all()
    waiting = [
        {**survey, "candidates": [lot for lot in json.loads(row["candidates"]) if lot in known]}
        for row, survey in zip(asked, surveys_json(connection, asked), strict=True)
    ]
    return {"lots": shown, "undecided": waiting, "changes": _changes(connection)}


def lot(connection: Connection, lot_id: str) -> dict[str, Any]:
    """Return a lot with its outline, its surveys in their order, and its stalls with the last look at each.

    ``zones``: areas without stalls; ``named_zones``: those that statistics count; ``layouts``: the versions of the
    layout; ``edit``: who edits the plan, whose ``revision`` rises with every change. ``newest_registered`` says how
    that survey differs from the layout. Nothing follows from it without a person.

    Raises NotFoundError.
    """
    row = lot_row(connection, lot_id).values
    assert row is not None  # noqa: S101 - it is there
    outline = outline_or_none(row["outline"])
    surveys = connection.execute(select(SURVEY).where(SURVEY.c.lot == lot_id).order_by(SURVEY.c.seq)).mappings().all()
    looks = _last_looks(connection, lot_id)
    unseen = {"state": None, "taken_probability": None, "looked": None}
    return {
        **lot_json(connection, row),
        "datum": list(datum_of(connection, lot_id)),
        "datum_is_pinned": row["datum_is_pinned"],
        "outline": [[list(corner) for corner in ring] for ring in outline.polygons],
        "surveys": surveys_json(connection, surveys),
        "stalls": [
            {"id": stall.id, "label": stall.label, "north": stall.north, "east": stall.east, "angle": stall.angle}
            | {"width": stall.width, "length": stall.length, "kind": stall.kind, "is_confirmed": stall.is_confirmed}
            | looks.get(key, unseen)
            for stall, key in present_stalls(connection, lot_id).items()
        ],
        **shown.all_zones_json(connection, lot_id),
        "layouts": shown.layouts_json(connection, lot_id),
        "edit": shown.edit_json(connection, lot_id),
        "revision": follow.revision_of(connection, lot_id),
        "newest_registered": newest_registered(connection, lot_id),
    }


def rename(connection: Connection, lot_id: str, name: object, who: str, now: float) -> Done:
    """Name a lot. Raises LotInputError, NotFoundError."""
    return changes.write(connection, changes.named(lot_row(connection, lot_id), name), who, now)


def merge(connection: Connection, lot_id: str, other: object, who: str, now: float) -> Done:
    """Merge another lot into this one. Raises LotInputError, NotFoundError."""
    kept, beside = _whole(connection, lot_id), _whole(connection, str(other), "with")
    return changes.write(connection, operations.merged(kept, beside, who, now), who, now)


def split(connection: Connection, lot_id: str, asked: Mapping[str, Any], who: str, now: float) -> Done:
    """Split the stalls within ``outline`` off as a lot called ``name``. Raises LotInputError, NotFoundError."""
    name, part = changes.checked_name(asked.get("name")), operations.checked_outline(asked.get("outline"))
    change = operations.split(_whole(connection, lot_id), part, name, new_id(), who, now)
    return changes.write(connection, change, who, now)


def move(
    connection: Connection, survey_id: str, asked: Mapping[str, Any], who: str, now: float, register: Register | None
) -> Done:
    """Move a survey to the lot ``lot``; None: to a new one, called ``name``. Raises LotInputError, NotFoundError.

    ``register`` finds its stalls among those of that lot; where it is not certain, the survey is unregistered there.
    """
    survey = survey_row(connection, survey_id)
    looks = changes.rows_where(connection, OBSERVATION, survey=survey.key[0])
    return changes.write(connection, _move(connection, survey, looks, asked, now, register), who, now)


def delete(connection: Connection, survey_id: str, who: str, now: float) -> Done:
    """Delete a survey of a lot; undoing brings it back. Raises NotFoundError, LotStoreError."""
    survey = survey_row(connection, survey_id)
    assert survey.values is not None  # noqa: S101 - it is there
    if survey.values["lot"] is None:
        raise LotStoreError("survey: no lot has it; reload the list")
    looks = changes.rows_where(connection, OBSERVATION, survey=survey.key[0])
    return changes.write(connection, operations.deleted(survey, looks), who, now)


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
    lot_id, looked = survey.values["lot"], Looked.stored(survey.values)
    outcome = placed_by(connection, lot_id, looked, move_of(doubt.places[number]))
    chosen = changes.changed(survey, doubt=replace(doubt, chosen=number).json())
    return changes.write(connection, Change("place", lot_id, _at(connection, chosen, looked, outcome)), who, now)


def places(connection: Connection, survey_id: str) -> dict[str, Any]:
    """Return where a survey in doubt may lie: the stalls of its lot, and its own at each place, in the lot's frame.

    A stall is [north, east, angle, width, length]. Raises NotFoundError.
    """
    survey = survey_row(connection, survey_id)
    assert survey.values is not None  # noqa: S101 - it is there
    doubt, lot_id = Doubt.read(survey.values["doubt"]), survey.values["lot"]
    if doubt is None or lot_id is None:
        raise NotFoundError("survey: has no places to choose from; reload the list")
    seen = [stall for stall in Looked.stored(survey.values).stalls if stall.is_witness]
    shown = [np.round(shapes_of(move_of(place).stalls(seen)), 3).tolist() for place in doubt.places]
    known = np.round(shapes_of(tuple(present_stalls(connection, lot_id))), 3).tolist()
    return {"survey": survey_id, "lot": lot_id, "known": known, "places": [{"stalls": stalls} for stalls in shown]}


def plan(connection: Connection, lot_id: str, since: int | None = None, layout: int | None = None) -> dict[str, Any]:
    """Return the plan of a lot: all, those stalls that changed since a revision, or that of a layout.

    Raises NotFoundError.
    """
    lot_row(connection, lot_id)
    return shown.plan(connection, lot_id, since) if layout is None else shown.plan_of(connection, lot_id, layout)


def proposed(connection: Connection, lot_id: str) -> dict[str, Any]:
    """Return what the newest surveys propose to change of a lot's layout. Raises NotFoundError."""
    lot_row(connection, lot_id)
    return proposing.changes_json(connection, lot_id)


def take_over(connection: Connection, lot_id: str, asked: Mapping[str, Any], who: str, now: float) -> Done:
    """Take proposals of a survey over as one version of the layout. Raises as `taking.take_over`, and NotFoundError."""
    lot_row(connection, lot_id)
    return taking.take_over(connection, lot_id, asked, who, now)


def drop(connection: Connection, lot_id: str, asked: Mapping[str, Any], who: str, now: float) -> Done:
    """Drop proposals of a survey. Raises LotInputError, NotFoundError."""
    lot_row(connection, lot_id)
    return taking.drop(connection, lot_id, asked, who, now)


def pin(connection: Connection, lot_id: str, asked: Mapping[str, Any], who: str, now: float) -> dict[str, Any]:
    """Pin a lot to its place on Earth, or unpin it; return the change and by how much the lot is moved.

    ``north``, ``east`` (metres) and ``turn`` (degrees) are those of the lot's datum and frame; ``residual``: metres by
    which two points are farther apart than the lot has them. Raises LotInputError, NotFoundError, BeingEditedError.
    """
    lot_row(connection, lot_id)
    done, pinned = pinning.pin(connection, lot_id, asked, who, now)
    moved = {"north": round(pinned.move.north, 3), "east": round(pinned.move.east, 3)}
    moved |= {"turn": round(math.degrees(pinned.move.turn), 4), "residual": round(pinned.residual, 3)}
    return {**asdict(done), **moved, "datum": list(datum_of(connection, lot_id))}


def undo(connection: Connection, seq: int, now: float) -> str:
    """Undo a change; return its kind. Raises NotFoundError, and LotStoreError when something followed it."""
    check_whole(connection, "change", seq, "change")
    kind = connection.execute(select(CHANGE.c.kind).where(CHANGE.c.seq == seq)).scalar()
    if kind != editing.KIND:
        return changes.undo(connection, seq, now)
    editing.undo_edit(connection, seq, now)
    return editing.KIND


def _at(connection: Connection, survey: Row, looked: Looked, outcome: Registration | Doubtful) -> tuple[Row, ...]:
    """Return the rows of an unregistered survey as they are after the outcome of its registration."""
    if isinstance(outcome, Doubtful):
        return (changes.changed(survey, doubt=Doubt(outcome.why, outcome.places).json()),)
    assert survey.values is not None  # noqa: S101 - it is there
    lot_id = str(survey.values["lot"])
    keys = {stall.id: key for stall, key in present_stalls(connection, lot_id).items()}
    same = {number: keys[stall] for number, stall in outcome.same.items()}
    placed = changes.changed(survey, **registered_place(outcome, newest_layout(connection, lot_id)))
    return (placed, *operations.look_rows(survey.key[0], same, looked.stalls))


def lots_of_surveys(connection: Connection) -> dict[str, dict[str, str]]:
    """Return id and name of the lot of each survey that has one, by the name of the survey's journal."""
    rows = connection.execute(
        select(SURVEY.c.origin, LOT.c.id, LOT.c.name).join(LOT, SURVEY.c.lot == LOT.c.id).order_by(SURVEY.c.seq)
    )
    return {origin.partition(" ")[0]: {"id": lot, "name": name} for origin, lot, name in rows}


def survey_row(connection: Connection, survey_id: str) -> Row:
    """Return a survey by its id. Raises NotFoundError."""
    found = connection.execute(select(SURVEY.c.seq).where(SURVEY.c.id == survey_id)).scalar()
    check_whole(connection, "survey", found, "survey", version_of(connection))
    if found is None:
        raise NotFoundError("survey: there is none with this id; reload the list")
    return changes.row_of(connection, SURVEY.name, (found,))


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
        home, *gone = change.rows
        if register is None or home.values is None:
            return change
        looked = Looked.stored(home.values)
        outcome = registered(connection, lot_id, looked, register)
        return Change(change.kind, change.lot, (*gone, *_at(connection, home, looked, outcome)))
    number = connection.execute(select(func.count()).select_from(LOT)).scalar_one() + 1
    name = changes.checked_name(asked.get("name", f"Lot {number}"))
    first_key = int(connection.execute(select(func.max(STALL.c.key))).scalar() or 0) + 1
    begun = operations.begun(survey, name, new_id(), first_key, now)
    ended = tuple(Row(row.table, row.key, None) for row in looks)
    return Change(begun.kind, begun.lot, (*ended, *begun.rows))


def lot_row(connection: Connection, lot_id: str, field: str = "lot") -> Row:
    """Return a lot that was not merged into another one. Raises NotFoundError."""
    known = lot_id if lot_id.isascii() else ""  # SQLite takes no half character
    check_whole(connection, "lot", known, field, version_of(connection))
    found = changes.row_of(connection, LOT.name, (known,))
    if found.values is None or found.values["merged_into"] is not None:
        raise NotFoundError(f"{field}: there is no lot with this id; reload the list")
    return found


def _whole(connection: Connection, lot_id: str, field: str = "lot") -> LotRows:
    found = lot_row(connection, lot_id, field)
    check_not_edited(connection, lot_id)
    read: Callable[..., list[Row]] = changes.rows_where
    return LotRows(
        lot=found,
        datum=datum_of(connection, lot_id),
        layouts=tuple(read(connection, LAYOUT, lot=lot_id)),
        stalls=tuple(read(connection, STALL, lot=lot_id)),
        zones=tuple(read(connection, ZONE, lot=lot_id)),
        surveys=tuple(read(connection, SURVEY, lot=lot_id)),
        used=used_labels(connection, lot_id),
    )


def lot_json(connection: Connection, row: _Shown) -> dict[str, Any]:
    """Return a lot of the table with its numbers of stalls and surveys, and the newest survey."""
    of_lot = SURVEY.c.lot == row["id"]
    surveys = connection.execute(select(func.count()).select_from(SURVEY).where(of_lot)).scalar_one()
    last = connection.execute(select(SURVEY).where(of_lot).order_by(*newest_first()).limit(1)).mappings().first()
    present = (STALL.c.lot == row["id"]) & STALL.c.ends.is_(None)
    stalls = connection.execute(select(func.count()).select_from(STALL).where(present)).scalar_one()
    return {
        "id": row["id"],
        "name": row["name"],
        "stalls": stalls,
        "survey_count": surveys,
        "last_survey": None if last is None else surveys_json(connection, [last])[0],
    }


def surveys_json(connection: Connection, rows: Sequence[_Shown]) -> list[dict[str, Any]]:
    """Return surveys of the table, which need `SURVEY_SHOWN` only, each with its counts."""
    now = now_of(connection)
    return [_survey_json(row, now) | counts for row, counts in zip(rows, counts_of(connection, rows), strict=True)]


def _survey_json(row: _Shown, now: float) -> dict[str, Any]:
    shown = {name: row[name] for name in _SHOWN}
    doubt = Doubt.read(row["doubt"])
    is_placed = row["north"] is not None
    shown["datum"] = [row["latitude"], row["longitude"]]
    shown["place"] = {name: row[name] for name in ("north", "east", "turn")} if is_placed else None
    shown["doubt"] = None if doubt is None else asdict(doubt)
    shown |= {"began": utc(row["began"]), "ended": utc(row["ended"]), "time_is_sure": is_sure_row(row, now)}
    return {**shown, **source_json(row)}


def _last_looks(connection: Connection, lot_id: str) -> dict[int, dict[str, Any]]:
    """Return the look of the newest survey at each stall of a lot, by the stall's key."""
    is_last = (OBSERVATION.c.stall == STALL.c.key) & (OBSERVATION.c.survey == newest_look(connection, STALL.c.key))
    asked = select(OBSERVATION).select_from(STALL).join(OBSERVATION, is_last).where(STALL.c.lot == lot_id)
    rows = connection.execute(asked).mappings()
    return {
        row["stall"]: {"state": row["state"], "taken_probability": row["taken"], "looked": utc(row["looked"])}
        for row in rows
    }


def _changes(connection: Connection) -> list[dict[str, Any]]:
    newest = select(CHANGE).order_by(CHANGE.c.seq.desc()).limit(CHANGES_SHOWN)
    return [
        {"seq": row["seq"], "kind": row["kind"], "who": row["who"], "made": utc(row["made"])}
        | {"undone": None if row["undone"] is None else utc(row["undone"])}
        for row in connection.execute(newest).mappings()
    ]
