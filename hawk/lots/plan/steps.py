"""Steps of an edit: the columns of stalls and zones that an operation changes, as they were and as they are.

A step is done, undone and done again by writing columns: an added stall or zone is a row that is no more part of the
plan after an undo (``ends`` is its first version), and never deleted. Ids, labels and observations stay valid so.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, Final

from sqlalchemy import Connection, bindparam, func, insert, select, text, update

from hawk.lots.plan.values import LASTING, Draft, PlanStall
from hawk.lots.tables import FORMER, LABEL, METADATA, STALL, ZONE

Key = int | str


class State(StrEnum):
    """State of a step."""

    DONE = "done"
    UNDONE = "undone"
    """It can be done again."""
    DROPPED = "dropped"
    """It was undone, and another operation followed."""


@dataclass(frozen=True, slots=True)
class Group:
    """Rows of a table whose columns change alike: ``before`` and ``after`` are the columns that change."""

    table: str
    keys: tuple[Key, ...] = field(repr=False)
    before: Mapping[str, Any]
    after: Mapping[str, Any]

    def back(self) -> Group:
        """Return the change that takes this one back."""
        return Group(self.table, self.keys, self.after, self.before)


def step_json(groups: Sequence[Group]) -> str:
    """Return the groups of a step as the store keeps them."""
    rows = [{"table": each.table, "keys": each.keys, "before": each.before, "after": each.after} for each in groups]
    return json.dumps(rows, allow_nan=False, separators=(",", ":"))


def step_of(body: str) -> tuple[Group, ...]:
    """Return the groups of `step_json`."""
    return tuple(Group(each["table"], tuple(each["keys"]), each["before"], each["after"]) for each in json.loads(body))


def net(steps: Iterable[Sequence[Group]]) -> tuple[Group, ...]:
    """Return several steps in their order as one: the first values before and the last ones after."""
    before: dict[tuple[str, Key], dict[str, Any]] = defaultdict(dict)
    after: dict[tuple[str, Key], dict[str, Any]] = defaultdict(dict)
    for groups in steps:
        for group in groups:
            for key in group.keys:
                row = (group.table, key)
                before[row] = {**group.before, **before[row]}
                after[row].update(group.after)
    return _grouped([(table, key, before[table, key], after[table, key]) for table, key in before])


def _grouped(rows: Iterable[tuple[str, Key, Mapping[str, Any], Mapping[str, Any]]]) -> tuple[Group, ...]:
    alike: dict[Any, list[Key]] = defaultdict(list)
    for table, key, before, after in rows:
        alike[table, tuple(sorted(before.items())), tuple(sorted(after.items()))].append(key)
    return tuple(Group(table, tuple(keys), dict(old), dict(new)) for (table, old, new), keys in alike.items())


def store(connection: Connection, lot: str, version: int, draft: Draft) -> tuple[Group, ...]:
    """Write a draft into a version of the layout, and return its groups.

    Stalls that the version before had are kept as it had them. Labels that are given are given for ever.
    """
    keys = _add_stalls(connection, lot, version, draft.added)
    zones = [
        {"id": zone.id, "lot": lot, "name": zone.name, "kind": zone.kind, "outline": json.dumps(zone.outline)}
        | {"begins": version, "ends": version}
        for zone in draft.begun_zones
    ]
    if zones:
        connection.execute(insert(ZONE), zones)
    labels = [(stall.label, stall.id) for stall in draft.added]
    labels += [(new.label, new.id) for old, new in draft.changed if old.label != new.label]
    if labels:
        rows = [{"lot": lot, "label": label, "stall": stall} for label, stall in labels]
        connection.execute(insert(LABEL).prefix_with("OR IGNORE"), rows)
    in_plan, out_of_plan = {"ends": None}, {"ends": version}
    groups = (
        *_grouped(("stall", old.key, *_differing(old, new)) for old, new in draft.changed),
        *_together("stall", keys, out_of_plan, in_plan),
        *_together("stall", [stall.key for stall in draft.ended], in_plan, out_of_plan),
        *_together("zone", [zone.id for zone in draft.begun_zones], out_of_plan, in_plan),
        *_together("zone", [zone.id for zone in draft.ended_zones], in_plan, out_of_plan),
    )
    _keep_former(connection, version, [old.key for old, _ in draft.changed if old.begins < version])
    apply(connection, groups)
    return groups


def _together(table: str, keys: Sequence[Key], before: Mapping[str, Any], after: Mapping[str, Any]) -> list[Group]:
    return [Group(table, tuple(keys), before, after)] if keys else []


def _differing(old: PlanStall, new: PlanStall) -> tuple[dict[str, Any], dict[str, Any]]:
    names = [name for name in LASTING if getattr(old, name) != getattr(new, name)]
    return {name: getattr(old, name) for name in names}, {name: getattr(new, name) for name in names}


def _add_stalls(connection: Connection, lot: str, version: int, added: Sequence[PlanStall]) -> list[int]:
    """Insert stalls that are no part of the plan yet, and return their keys."""
    if not added:
        return []
    first = next_key(connection)
    keys = list(range(first, first + len(added)))
    rows = [
        {"key": key, "id": stall.id, "lot": lot, **{name: getattr(stall, name) for name in LASTING}}
        | {"begins": version, "ends": version, "first_survey": None, "first_id": None}
        for key, stall in zip(keys, added, strict=True)
    ]
    connection.execute(insert(STALL), rows)
    return keys


def next_key(connection: Connection) -> int:
    """Return the next key of a stall that SQLite would give: no key is given twice."""
    return int(connection.execute(_NEXT_KEY).scalar_one())


_NEXT_KEY: Final = text("SELECT 1 + max(coalesce((SELECT max(key) FROM stall), 0),"
                        " coalesce((SELECT seq FROM sqlite_sequence WHERE name = 'stall'), 0))")  # fmt: skip


def _keep_former(connection: Connection, version: int, keys: Sequence[int]) -> None:
    """Keep stalls as the version before has them, unless they are kept already."""
    if not keys:
        return
    connection.execute(_FORMER, {"version": version, "among": json.dumps(keys)})


def is_among(column: Any) -> Any:
    """Return the condition that a column is one of any number of values: those in ``among``, a JSON list."""
    found = func.json_each(bindparam("among")).table_valued("value")
    return column.in_(select(found.c.value))


_FORMER: Final = insert(FORMER).prefix_with("OR IGNORE").from_select(
    ["lot", "stall", "ends", *LASTING],
    select(STALL.c.lot, STALL.c.key, bindparam("version", type_=FORMER.c.ends.type).label("ends"))
    .add_columns(*(STALL.c[name] for name in LASTING))
    .where(STALL.c.begins < bindparam("version"), is_among(STALL.c.key)),
)  # fmt: skip


def apply(connection: Connection, groups: Sequence[Group]) -> None:
    """Write the columns of groups: many rows that change alike at once, the others one after the other."""
    single: dict[tuple[str, tuple[str, ...]], list[dict[str, Any]]] = defaultdict(list)
    for group in groups:
        table = METADATA.tables[group.table]
        (key,) = table.primary_key
        if len(group.keys) > 1:
            changed = update(table).where(is_among(key)).values(**group.after)
            connection.execute(changed, {"among": json.dumps(group.keys)})
        else:
            names = tuple(sorted(group.after))
            single[group.table, names].append({"row": group.keys[0], **{f"new_{n}": group.after[n] for n in names}})
    for (name, names), rows in single.items():
        table = METADATA.tables[name]
        (key,) = table.primary_key
        values: dict[str, Any] = {each: bindparam(f"new_{each}") for each in names}
        connection.execute(update(table).where(key == bindparam("row")).values(**values), rows)


def rows_touched(groups: Iterable[Group], table: str) -> list[Key]:
    """Return the keys of a table's rows that groups change, each once."""
    return list(dict.fromkeys(key for group in groups if group.table == table for key in group.keys))
