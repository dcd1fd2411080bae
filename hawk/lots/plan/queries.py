"""Plans of lots as they are in the store: the stalls that an operation means, those near them, and their labels."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
from sqlalchemy import ColumnElement, Connection, Select, and_, bindparam, func, select, true

from hawk.lots.plan import geometry
from hawk.lots.plan.drafts import Context
from hawk.lots.plan.operations import (
    LENGTHS_M,
    WIDTHS_M,
    AddRow,
    AddStall,
    Allow,
    ChangeSection,
    DrawSection,
    DrawZone,
    EraseZone,
    Forbid,
    Operation,
    RemoveSection,
    Split,
    Swap,
)
from hawk.lots.plan.values import BARE, LASTING, PRIVATE, Floats, LayoutSection, LayoutStall, PlanZone, shapes_of
from hawk.lots.storage.outlines import ring_of
from hawk.lots.storage.rows import is_among
from hawk.lots.storage.schema import FORMER, SECTION, STALL, ZONE
from hawk.lots.values import LotInputError, new_id
from hawk.model.poses import Ring
from hawk.model.sentences import say

_LARGEST_M: Final = (WIDTHS_M[1] + LENGTHS_M[1]) / 2
"""No stall reaches farther from its middle."""
ROW_M: Final = 30.0
"""Stalls farther from a new one do not stand in its row: its longest gap is 15 m."""
USUAL_M: Final = (2.5, 5.0)
"""Width and length of a stall in a lot that has none."""
_CELL_M: Final = 50.0
"""Stalls of one operation that are farther apart are looked around one by one."""
_DIGITS: Final = "0123456789"
COLUMNS: Final = ("id", *LASTING, "key", "begins")
"""Columns of the table of stalls in the order of `LayoutStall`."""


def in_plan(columns: Any, lot: object, version: int | None = None) -> ColumnElement[bool]:
    """Return the condition that a stall or zone is of a lot's plan, or of a version of its layout."""
    is_in = columns.ends.is_(None)
    if version is not None:
        is_in = (columns.begins <= version) & (columns.ends.is_(None) | (columns.ends > version))
    return and_(columns.lot == lot, is_in)


def is_of_row(label: ColumnElement[str], row: Any) -> ColumnElement[bool]:
    """Return the condition that a label is one of a row, as "B 12" is of "B"."""
    return and_(func.rtrim(label, _DIGITS) == row + " ", label != row + " ")


def _asked(*conditions: ColumnElement[bool]) -> Select[Any]:
    return select(*(STALL.c[name] for name in COLUMNS)).where(*conditions).order_by(STALL.c.key)


_LOT: Final[Any] = bindparam("lot")
_PRESENT: Final = in_plan(STALL.c, _LOT)
_ALL: Final = _asked(_PRESENT)
_OF_ROW: Final = _asked(_PRESENT, is_of_row(STALL.c.label, bindparam("row")))
_OF_IDS: Final = _asked(_PRESENT, is_among(STALL.c.id))
_IN_BOX: Final = _asked(
    _PRESENT,
    STALL.c.north.between(bindparam("south"), bindparam("north")),
    STALL.c.east.between(bindparam("west"), bindparam("east")),
)
_REACH: Final = (STALL.c.width + STALL.c.length) / 2
_TOUCHING: Final = _IN_BOX.where(
    STALL.c.north.between(bindparam("low_north") - _REACH, bindparam("high_north") + _REACH),
    STALL.c.east.between(bindparam("low_east") - _REACH, bindparam("high_east") + _REACH),
)
"""Stalls whose box touches a box, which the index by place finds within `_LARGEST_M`."""
_EXTENT: Final = select(*(end(STALL.c[name]) for end in (func.min, func.max) for name in ("north", "east"))).where(
    _PRESENT
)
_ZONES: Final = select(ZONE.c.id, ZONE.c.name, ZONE.c.outline, ZONE.c.kind).where(
    in_plan(ZONE.c, _LOT), ZONE.c.kind.in_(BARE)
)
_LABELLED: Final = _asked(_PRESENT, is_among(STALL.c.label))
_LABELS: Final = select(STALL.c.label).where(_PRESENT, ~is_among(STALL.c.key))
_MEDIANS: Final = {
    name: select(STALL.c[name])
    .where(_PRESENT)
    .order_by(STALL.c[name])
    .limit(1)
    .offset(select(func.count() // 2).select_from(STALL).where(_PRESENT).scalar_subquery())
    for name in ("width", "length")
}


def selected(connection: Connection, lot: str, asked: Operation) -> list[LayoutStall]:
    """Return the stalls that an operation means, those of ids in their order. Raises LotInputError."""
    match asked:
        case AddStall() | AddRow() | Allow() | DrawZone() | EraseZone():
            return []
        case DrawSection() | ChangeSection() | RemoveSection():
            return []
        case Forbid():
            return _in_box(connection, lot, np.array(asked.outline), 0.0)
        case Split():
            return _by_ids(connection, lot, [asked.stall], "stall")
        case Swap():
            return [stall for n, row in enumerate(asked.rows) for stall in _row(connection, lot, row, f"rows[{n}]")]
    if asked.stalls is not None:
        return _by_ids(connection, lot, asked.stalls, "stalls")
    if asked.row is not None:
        return _row(connection, lot, asked.row, "row")
    found = all_stalls(connection, lot)
    if not found:
        raise LotInputError("all", say("finds none: the plan has no such stall; read the plan again"))
    return found


def _row(connection: Connection, lot: str, row: str, field: str) -> list[LayoutStall]:
    """Return the stalls of a row that an operation means. Raises LotInputError."""
    found = of_row(connection, lot, row)
    if not found:
        raise LotInputError(field, say("{row} has none: the plan has no such stall; read the plan again", row=row))
    return found


def all_stalls(connection: Connection, lot: str) -> list[LayoutStall]:
    """Return the stalls of a plan."""
    return _stalls(connection, _ALL, lot=lot)


def stalls_of_keys(connection: Connection, lot: str, keys: Iterable[int]) -> list[LayoutStall]:
    """Return the stalls of a lot with these keys, of any version of its layout, as they are now."""
    asked = _asked(STALL.c.lot == lot, is_among(STALL.c.key))
    return _stalls(connection, asked, among=json.dumps([*keys]))


def stalls_in(connection: Connection, lot: str, version: int, then: Sequence[str] = LASTING) -> list[LayoutStall]:
    """Return the stalls of a version of the layout as it has them.

    ``then``: the columns as they were; the others are as they are now.
    """
    asked = select(FORMER).where(FORMER.c.lot == lot, FORMER.c.ends > version).order_by(FORMER.c.ends.desc())
    former = {row["stall"]: row for row in connection.execute(asked).mappings()}  # that of the smallest `ends` is last
    return [
        replace(each, **{name: former[each.key][name] for name in then}) if each.key in former else each
        for each in _stalls(connection, _asked(in_plan(STALL.c, lot, version)))
    ]


def around(
    connection: Connection, lot: str, stalls: Sequence[LayoutStall], without: Iterable[int], *, with_rows: bool
) -> list[LayoutStall]:
    """Return the stalls of the plan that may overlap some stalls, without those of some keys.

    ``with_rows``: those of rows that the stalls may join too.
    """
    left_out = set(without)
    cells: dict[tuple[int, int], list[LayoutStall]] = defaultdict(list)
    for stall in stalls:
        cells[int(stall.north // _CELL_M), int(stall.east // _CELL_M)].append(stall)
    near: dict[int, LayoutStall] = {}
    for members in cells.values():
        shapes = shapes_of(members)
        own = float((shapes[:, 3] + shapes[:, 4]).max()) / 2
        look = _in_box if with_rows else _touching
        near |= {each.key: each for each in look(connection, lot, shapes[:, :2], ROW_M if with_rows else own)}
    return [stall for key, stall in near.items() if key not in left_out]


def zones_of(connection: Connection, lot: str, version: int | None = None) -> list[PlanZone]:
    """Return the areas without stalls, of the plan or of a version of the layout."""
    asked = _ZONES
    if version is not None:
        asked = select(*_ZONES.selected_columns).where(in_plan(ZONE.c, lot, version), ZONE.c.kind.in_(BARE))
    found = connection.execute(asked.order_by(ZONE.c.id), {"lot": lot} if version is None else {})
    return [PlanZone(key, name, ring_of(outline), kind) for key, name, outline, kind in found]


def private_zones(connection: Connection, lot: str) -> list[Ring]:
    """Return the rings of a lot's plan that nobody may look at, metres in its frame."""
    return [each.outline for each in zones_of(connection, lot) if each.kind == PRIVATE and each.outline]


def hidden_stalls(connection: Connection, lots: Collection[str] | None = None) -> frozenset[int]:
    """Return the keys of the stalls, of any layout, whose middle lies on private ground of the plan of their lot.

    ``lots``: None for all. Earlier surveys looked at them: their states are neither shown nor counted.
    """
    is_of = true() if lots is None else is_among(ZONE.c.lot, lots)
    asked = select(ZONE.c.lot, ZONE.c.outline).where(ZONE.c.kind == PRIVATE, ZONE.c.ends.is_(None), is_of)
    rings: dict[str, list[Ring]] = defaultdict(list)
    for lot, outline in connection.execute(asked):
        rings[lot].append(ring_of(outline))
    hidden: set[int] = set()
    for lot, private in rings.items():
        asked = select(STALL.c.key, STALL.c.north, STALL.c.east).where(STALL.c.lot == lot)
        rows = connection.execute(asked).all()
        places = np.array([row[1:] for row in rows], np.float64).reshape(-1, 2)
        for ring in private:
            lies = geometry.within(ring, places)
            hidden.update(row.key for row, is_in in zip(rows, lies, strict=True) if is_in)
    return frozenset(hidden)


def named_zones(connection: Connection, lot: str, version: int | None = None) -> list[PlanZone]:
    """Return the zones with a name, by it, of the plan or of a version of the layout."""
    columns = (ZONE.c.id, ZONE.c.name, ZONE.c.outline, ZONE.c.kind)
    asked = select(*columns).where(in_plan(ZONE.c, lot, version), ZONE.c.kind.not_in(BARE))
    found = connection.execute(asked.order_by(ZONE.c.name, ZONE.c.id))
    return [PlanZone(key, name, ring_of(outline), kind) for key, name, outline, kind in found]


_OF_SECTION: Final = ("id", "name", "outline", "kind", "length_m", "capacity", "is_capacity_given", "note", "key")


def sections_of(connection: Connection, lot: str, version: int | None = None) -> list[LayoutSection]:
    """Return the sections by their names, of the plan or of a version of the layout."""
    asked = select(*(SECTION.c[name] for name in _OF_SECTION)).where(in_plan(SECTION.c, lot, version))
    found = connection.execute(asked.order_by(SECTION.c.name, SECTION.c.id)).mappings()
    return [LayoutSection(**{**row, "outline": ring_of(row["outline"])}) for row in found]


def extent_of(connection: Connection, lot: str) -> Floats | None:
    """Return the least box around the stalls and sections of a plan: its corners (2, 2), metres; None without any."""
    found = connection.execute(_EXTENT, {"lot": lot}).one()
    corners = [] if None in found else [(found[0], found[1]), (found[2], found[3])]
    every = np.array([*corners, *(corner for each in sections_of(connection, lot) for corner in each.outline)])
    return np.stack((every.min(axis=0), every.max(axis=0))) if len(every) else None


def context_of(connection: Connection, lot: str, asked: Operation) -> Context:
    """Return the facts that the draft of an operation needs besides the stalls."""
    usual: Mapping[str, float] = {}
    if isinstance(asked, AddRow) and asked.count is None and asked.pitch is None:
        name = "length" if asked.parallel else "width"
        median = connection.execute(_MEDIANS[name], {"lot": lot}).scalar()
        usual = {} if median is None else {name: float(median)}
    width, length = usual.get("width", USUAL_M[0]), usual.get("length", USUAL_M[1])
    named = named_zones(connection, lot) if isinstance(asked, DrawZone | EraseZone) else ()
    is_section = isinstance(asked, DrawSection | ChangeSection | RemoveSection)
    sections = sections_of(connection, lot) if is_section else ()
    return Context(width, length, zones_of(connection, lot), new_id, named, sections)


def labelled(connection: Connection, lot: str, labels: Sequence[str]) -> list[LayoutStall]:
    """Return the stalls of the plan that have one of some labels."""
    return _stalls(connection, _LABELLED, lot=lot, among=json.dumps(labels))


def of_row(connection: Connection, lot: str, row: str) -> list[LayoutStall]:
    """Return the stalls of a row of the plan, by its name."""
    return _stalls(connection, _OF_ROW, lot=lot, row=row)


def labels_beside(connection: Connection, lot: str, without: Collection[int]) -> set[str]:
    """Return the labels of the stalls of a plan, without those of some keys."""
    return set(connection.execute(_LABELS, {"lot": lot, "among": json.dumps([*without])}).scalars())


def _stalls(connection: Connection, asked: Select[Any], **values: object) -> list[LayoutStall]:
    return [LayoutStall(*row) for row in connection.execute(asked, values)]


def _in_box(connection: Connection, lot: str, places: Floats, margin: float) -> list[LayoutStall]:
    """Return the stalls of the plan whose middle is in the box around places (N, 2), or nearer than a margin."""
    (south, west), (north, east) = (places.min(axis=0) - margin).tolist(), (places.max(axis=0) + margin).tolist()
    return _stalls(connection, _IN_BOX, lot=lot, south=south, north=north, west=west, east=east)


def _touching(connection: Connection, lot: str, places: Floats, reach: float) -> list[LayoutStall]:
    """Return the stalls of the plan that may touch stalls at places (N, 2) which reach so far from their middles."""
    low_north, low_east = (places.min(axis=0) - reach).tolist()
    high_north, high_east = (places.max(axis=0) + reach).tolist()
    box = {"low_north": low_north, "high_north": high_north, "low_east": low_east, "high_east": high_east}
    coarse = {"south": low_north - _LARGEST_M, "north": high_north + _LARGEST_M}
    coarse |= {"west": low_east - _LARGEST_M, "east": high_east + _LARGEST_M}
    return _stalls(connection, _TOUCHING, lot=lot, **box, **coarse)


def _by_ids(connection: Connection, lot: str, ids: Sequence[str], field: str) -> list[LayoutStall]:
    found = {stall.id: stall for stall in _stalls(connection, _OF_IDS, lot=lot, among=json.dumps(ids))}
    for number, each in enumerate(ids):
        if each not in found:
            place = field if field == "stall" else f"{field}[{number}]"
            raise LotInputError(place, say("is no stall of this plan: read the plan again"))
    return [found[each] for each in ids]
