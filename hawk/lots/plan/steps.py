"""Drafts of a plan written into the store, as one step of an edit each (`hawk.lots.change_log`).

A step is done, undone and done again by writing columns: an added stall, zone or section is a row that is no
more part of the plan after an undo (``ends`` is its first version), and never deleted. Ids and observations stay valid
so.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any, Final

from sqlalchemy import Connection, Table, bindparam, func, insert, select, text, update

from hawk.lots.change_log import Group, apply, grouped
from hawk.lots.plan.values import LASTING, Draft, LayoutSection, LayoutStall
from hawk.lots.storage.rows import is_among
from hawk.lots.storage.schema import FORMER, SECTION, STALL, ZONE

_OF_SECTION: Final = ("id", "name", "kind", "length_m", "capacity", "is_capacity_given", "note")


def store(connection: Connection, lot: str, version: int, draft: Draft) -> tuple[Group, ...]:
    """Write a draft into a version of the layout, and return its groups.

    Stalls that the version before had are kept as it had them.
    """
    keys = _add_stalls(connection, lot, version, draft.added)
    zones = [
        {"id": zone.id, "lot": lot, "name": zone.name, "kind": zone.kind, "outline": json.dumps(zone.outline)}
        | {"begins": version, "ends": version}
        for zone in draft.begun_zones
    ]
    if zones:
        connection.execute(insert(ZONE), zones)
    begun = _add_sections(connection, lot, version, draft.begun_sections)
    in_plan, out_of_plan = {"ends": None}, {"ends": version}
    groups = (
        *grouped(("stall", (old.key,), *_differing(old, new)) for old, new in draft.changed),
        *_together("stall", keys, out_of_plan, in_plan),
        *_together("stall", [stall.key for stall in draft.ended], in_plan, out_of_plan),
        *_together("zone", [zone.id for zone in draft.begun_zones], out_of_plan, in_plan),
        *_together("zone", [zone.id for zone in draft.ended_zones], in_plan, out_of_plan),
        *_together("section", [section.key for section in draft.ended_sections], in_plan, out_of_plan),
        *_together("section", begun, out_of_plan, in_plan),
    )
    _keep_former(connection, version, [old.key for old, _ in draft.changed if old.begins < version])
    apply(connection, groups)
    return groups


def _together(table: str, keys: Sequence[object], before: Mapping[str, Any], after: Mapping[str, Any]) -> list[Group]:
    return [Group(table, tuple((key,) for key in keys), before, after)] if keys else []


def _differing(old: LayoutStall, new: LayoutStall) -> tuple[dict[str, Any], dict[str, Any]]:
    names = [name for name in LASTING if getattr(old, name) != getattr(new, name)]
    return {name: getattr(old, name) for name in names}, {name: getattr(new, name) for name in names}


def _add_stalls(connection: Connection, lot: str, version: int, added: Sequence[LayoutStall]) -> list[int]:
    """Store stalls that are no part of the plan yet, and return their keys. One that no version had gets its row again,
    with the looks at it.
    """
    if not added:
        return []
    there = select(STALL.c.id, STALL.c.key).where(is_among(STALL.c.id))
    known = {row.id: row.key for row in connection.execute(there, {"among": json.dumps([each.id for each in added])})}
    first = next_key(connection, STALL)
    new = iter(range(first, first + len(added)))
    keys = [known[stall.id] if stall.id in known else next(new) for stall in added]
    rows = [
        {"key": key, "id": stall.id, "lot": lot, **{name: getattr(stall, name) for name in LASTING}}
        | {"begins": version, "ends": version, "first_survey": None, "first_id": None}
        for key, stall in zip(keys, added, strict=True)
    ]
    if again := [{**row, "again": row["key"]} for row in rows if row["id"] in known]:
        columns: dict[str, Any] = {name: bindparam(name) for name in ("lot", *LASTING, "begins", "ends")}
        connection.execute(update(STALL).where(STALL.c.key == bindparam("again")).values(**columns), again)
    if fresh := [row for row in rows if row["id"] not in known]:
        connection.execute(insert(STALL), fresh)
    return keys


def _add_sections(connection: Connection, lot: str, version: int, begun: Sequence[LayoutSection]) -> list[int]:
    """Insert sections that are no part of the plan yet, and return their keys."""
    if not begun:
        return []
    first = next_key(connection, SECTION)
    keys = list(range(first, first + len(begun)))
    rows = [section_values(key, lot, section, version, version) for key, section in zip(keys, begun, strict=True)]
    connection.execute(insert(SECTION), rows)
    return keys


def section_values(key: int, lot: str, section: LayoutSection, begins: int, ends: int | None) -> dict[str, Any]:
    """Return a section as the columns of its row; ``begins`` and ``ends`` are versions of the layout."""
    said = {name: getattr(section, name) for name in _OF_SECTION}
    return {"key": key, "lot": lot, **said, "outline": json.dumps(section.outline), "begins": begins, "ends": ends}


def next_key(connection: Connection, table: Table) -> int:
    """Return the next key of a stall or section that SQLite would give: no key is given twice."""
    highest = connection.execute(select(func.max(table.c.key))).scalar() or 0
    given = connection.execute(_GIVEN, {"table": table.name}).scalar() or 0
    return 1 + max(int(highest), int(given))


_GIVEN: Final = text("SELECT seq FROM sqlite_sequence WHERE name = :table")


def _keep_former(connection: Connection, version: int, keys: Sequence[int]) -> None:
    """Keep stalls as the version before has them, unless they are kept already."""
    if not keys:
        return
    connection.execute(_FORMER, {"version": version, "among": json.dumps(keys)})


_FORMER: Final = insert(FORMER).prefix_with("OR IGNORE").from_select(
    ["lot", "stall", "ends", *LASTING],
    select(STALL.c.lot, STALL.c.key, bindparam("version", type_=FORMER.c.ends.type).label("ends"))
    .add_columns(*(STALL.c[name] for name in LASTING))
    .where(STALL.c.begins < bindparam("version"), is_among(STALL.c.key)),
)  # fmt: skip
