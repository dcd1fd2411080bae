"""Plans of lots as they are in the store: the stalls that an operation means and those near it, and JSON values."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from typing import Any, Final

import numpy as np
from sqlalchemy import ColumnElement, Connection, RowMapping, Select, Text, and_, cast, func, select
from sqlalchemy import Integer as IntegerType

from hawk.lots.labels import parts_of
from hawk.lots.plan import follow
from hawk.lots.plan.asked import AddRow, AddStall, Allow, Forbid, Operation, Split
from hawk.lots.plan.checks import highest_numbers
from hawk.lots.plan.drafting import Context
from hawk.lots.plan.steps import is_among, rows_touched, step_of
from hawk.lots.plan.values import LASTING, PlanStall, Zone
from hawk.lots.plan.versions import edit_of
from hawk.lots.saving import new_id
from hawk.lots.tables import EDIT, FORMER, LABEL, LAYOUT, NO_STALLS, STALL, STEP, ZONE
from hawk.lots.values import LotInputError, NotFoundError, utc

NEAR_M: Final = 30.0
"""Stalls farther from a new one neither overlap it nor stand in its row: the longest gap of a row is 15 m."""
USUAL_M: Final = (2.5, 5.0)
"""Width and length of a stall in a lot that has none."""
_COLUMNS: Final = ("key", "id", *LASTING, "begins")


def selected(connection: Connection, lot: str, asked: Operation) -> list[PlanStall]:
    """Return the stalls that an operation means, those of ids in their order. Raises LotInputError."""
    match asked:
        case AddStall() | AddRow() | Allow():
            return []
        case Forbid():
            return _in_box(connection, lot, np.array(asked.outline), 0.0)
        case Split():
            return _by_ids(connection, lot, [asked.stall], "stall")
    if asked.stalls is not None:
        return _by_ids(connection, lot, asked.stalls, "stalls")
    found = _stalls(connection, _present(lot) if asked.row is None else _of_row(lot, asked.row))
    if asked.row is not None:
        found = [stall for stall in found if (parts := parts_of(stall.label)) is not None and parts[0] == asked.row]
    if not found:
        field, words = ("all", "selects none: the plan") if asked.row is None else ("row", f"{asked.row}: the plan")
        raise LotInputError(field, f"{words} has no such stall; read the plan again")
    return found


def around(connection: Connection, lot: str, stalls: Sequence[PlanStall], without: Iterable[int]) -> list[PlanStall]:
    """Return the stalls of the plan near some stalls, without those of some keys."""
    left_out = set(without)
    if not stalls:
        return []
    places = np.array([(stall.north, stall.east) for stall in stalls])
    return [stall for stall in _in_box(connection, lot, places, NEAR_M) if stall.key not in left_out]


def zones_of(connection: Connection, lot: str, version: int | None = None) -> list[Zone]:
    """Return the areas without stalls, of the plan or of a version of the layout."""
    is_in = ZONE.c.ends.is_(None) if version is None else _is_in(ZONE.c, version)
    asked = select(ZONE).where(ZONE.c.lot == lot, ZONE.c.kind == NO_STALLS, is_in).order_by(ZONE.c.id)
    return [_zone(row) for row in connection.execute(asked).mappings()]


def context_of(connection: Connection, lot: str, asked: Operation) -> Context:
    """Return the facts that the draft of an operation needs besides the stalls."""
    needs_pitch = isinstance(asked, AddRow) and asked.count is None and asked.pitch is None
    width, length = (_usual(connection, lot, name) for name in ("width", "length")) if needs_pitch else USUAL_M
    return Context(width or USUAL_M[0], length or USUAL_M[1], zones_of(connection, lot), new_id)


def highest_of(connection: Connection, lot: str) -> dict[str, int]:
    """Return the highest number that was ever given in each row of a lot, by the row's letter."""
    gap = func.instr(LABEL.c.label, " ")
    letter = func.substr(LABEL.c.label, 1, gap - 1)
    number = func.max(cast(func.substr(LABEL.c.label, gap + 1), IntegerType))
    rows = connection.execute(select(letter, number).where(LABEL.c.lot == lot, gap > 1).group_by(letter)).all()
    return highest_numbers([(str(each), int(highest)) for each, highest in rows])


def owners_of(connection: Connection, lot: str, labels: Sequence[str]) -> dict[str, str]:
    """Return label -> id of the stall whose it is or was, of those labels that were given."""
    asked = select(LABEL.c.label, LABEL.c.stall).where(LABEL.c.lot == lot, is_among(LABEL.c.label, labels))
    return {str(row.label): str(row.stall) for row in connection.execute(asked)}


def plan(connection: Connection, lot: str, since: int | None = None) -> dict[str, Any]:
    """Return the plan as JSON values: all of it, or the stalls that changed after a revision.

    ``whole`` says which; ``gone``: ids of stalls that are no part of the plan any more.
    """
    revision = follow.revision_of(connection, lot)
    shown: dict[str, Any] = {"lot": lot, "revision": revision, "edit": edit_json(connection, lot)}
    if since is None or since < follow.whole_since(connection, lot) or since > revision:
        shown |= {
            "whole": True,
            "stalls": [stall_json(each) for each in _stalls(connection, _present(lot))],
            "gone": [],
        }
    else:
        steps = select(STEP.c.body).join(EDIT, EDIT.c.id == STEP.c.edit)
        bodies = connection.execute(steps.where(EDIT.c.lot == lot, STEP.c.revision > since)).scalars()
        keys = rows_touched([group for body in bodies for group in step_of(body)], STALL.name)
        shown |= {"whole": False, **touched_json(connection, keys)}
    return {**shown, "zones": zones_json(connection, lot)}


def plan_of(connection: Connection, lot: str, version: int) -> dict[str, Any]:
    """Return the plan as a version of the layout has it, as JSON values. Raises NotFoundError."""
    is_there = select(LAYOUT.c.version).where(LAYOUT.c.lot == lot, LAYOUT.c.version == version)
    if connection.execute(is_there).scalar() is None:
        raise NotFoundError(f"layout: there is no version {version}; read the lot again")
    stalls = _stalls(connection, and_(STALL.c.lot == lot, _is_in(STALL.c, version)))
    asked = select(FORMER).where(FORMER.c.lot == lot, FORMER.c.ends > version).order_by(FORMER.c.ends.desc())
    former = {row["stall"]: row for row in connection.execute(asked).mappings()}  # that of the smallest `ends` is last
    shown = [stall_json(each, former.get(each.key)) for each in stalls]
    zones = [_zone_json(zone) for zone in zones_of(connection, lot, version)]
    return {"lot": lot, "layout": version, "stalls": shown, "zones": zones}


def touched_json(connection: Connection, keys: Sequence[int | str]) -> dict[str, Any]:
    """Return stalls of some keys: ``stalls`` of the plan as they are, and the ids of those that are ``gone``."""
    found = select(*(STALL.c[name] for name in _COLUMNS), STALL.c.ends).where(is_among(STALL.c.key, keys))
    rows = connection.execute(found.order_by(STALL.c.key)).mappings().all()
    stalls = [stall_json(_stall(row)) for row in rows if row["ends"] is None]
    return {"stalls": stalls, "gone": [row["id"] for row in rows if row["ends"] is not None]}


def stall_json(stall: PlanStall, former: RowMapping | None = None) -> dict[str, Any]:
    """Return a stall as JSON values, with what a row of the table of former stalls says otherwise."""
    return {"id": stall.id} | {name: getattr(stall, name) if former is None else former[name] for name in LASTING}


def zones_json(connection: Connection, lot: str) -> list[dict[str, Any]]:
    """Return the areas of the plan as JSON values."""
    return [_zone_json(zone) for zone in zones_of(connection, lot)]


def edit_json(connection: Connection, lot: str) -> dict[str, Any] | None:
    """Return who edits the plan, since when and until when last, with the version that it makes; None for nobody.

    Its id is not shown: who has it may write.
    """
    edit = edit_of(connection, lot)
    if edit is None:
        return None
    return {"who": edit.who, "since": utc(edit.began), "last": utc(edit.touched), "layout": edit.version}


def layouts_json(connection: Connection, lot: str) -> list[dict[str, Any]]:
    """Return the versions of a lot's layout: when, by whom and why each began."""
    rows = connection.execute(select(LAYOUT).where(LAYOUT.c.lot == lot).order_by(LAYOUT.c.version)).mappings()
    return [
        {"version": row["version"], "valid_from": utc(row["valid_from"]), "who": row["who"], "why": row["why"]}
        for row in rows
    ]


def _present(lot: str) -> ColumnElement[bool]:
    return and_(STALL.c.lot == lot, STALL.c.ends.is_(None))


def _of_row(lot: str, letter: str) -> ColumnElement[bool]:
    return and_(_present(lot), cast(STALL.c.label, Text).like(f"{letter} %"))


def _is_in(columns: Any, version: int) -> ColumnElement[bool]:
    return and_(columns.begins <= version, columns.ends.is_(None) | (columns.ends > version))


def _asked(condition: ColumnElement[bool]) -> Select[Any]:
    return select(*(STALL.c[name] for name in _COLUMNS)).where(condition)


def _stalls(connection: Connection, condition: ColumnElement[bool]) -> list[PlanStall]:
    return [PlanStall(*row) for row in connection.execute(_asked(condition).order_by(STALL.c.key))]


def _stall(row: RowMapping) -> PlanStall:
    return PlanStall(*(row[name] for name in _COLUMNS))


def _in_box(connection: Connection, lot: str, places: Any, margin: float) -> list[PlanStall]:
    """Return the stalls of the plan whose middle is in the box around places (N, 2), or nearer than a margin."""
    low, high = places.min(axis=0) - margin, places.max(axis=0) + margin
    is_there = and_(
        STALL.c.north.between(float(low[0]), float(high[0])), STALL.c.east.between(float(low[1]), float(high[1]))
    )
    return _stalls(connection, and_(_present(lot), is_there))


def _by_ids(connection: Connection, lot: str, ids: Sequence[str], field: str) -> list[PlanStall]:
    found = {stall.id: stall for stall in _stalls(connection, and_(_present(lot), is_among(STALL.c.id, ids)))}
    for number, each in enumerate(ids):
        if each not in found:
            place = field if field == "stall" else f"{field}[{number}]"
            raise LotInputError(place, "is no stall of this plan: read the plan again")
    return [found[each] for each in ids]


def _usual(connection: Connection, lot: str, name: str) -> float | None:
    """Return the median of a column over the stalls of the plan; None without stalls."""
    column = STALL.c[name]
    count = connection.execute(select(func.count()).select_from(STALL).where(_present(lot))).scalar_one()
    middle = select(column).where(_present(lot)).order_by(column).offset(count // 2).limit(1)
    found = connection.execute(middle).scalar()
    return None if found is None else float(found)


def _zone(row: RowMapping) -> Zone:
    outline = tuple((float(north), float(east)) for north, east in json.loads(row["outline"]))
    return Zone(row["id"], row["name"], outline)


def _zone_json(zone: Zone) -> dict[str, Any]:
    return {"id": zone.id, "name": zone.name, "kind": NO_STALLS, "outline": [list(corner) for corner in zone.outline]}
