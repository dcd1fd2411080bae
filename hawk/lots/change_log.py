"""The log of what persons change in the store: each change with the columns that it set, as they were and as they are.

A change is undone once, as long as nobody changed these columns since. Steps of the edit of a plan are changes, too:
they are undone and done again while the edit is open, and its end makes one change of them.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from itertools import groupby
from typing import Any, Final

from sqlalchemy import Connection, bindparam, delete, insert, select, update
from sqlalchemy.exc import IntegrityError

from hawk.lots.answers import Done
from hawk.lots.plan.values import PRIVATE
from hawk.lots.plan.versions import check_not_edited, newest_layout, read_again
from hawk.lots.storage.digests import check_whole
from hawk.lots.storage.rows import Key, Row, is_among, read_rows
from hawk.lots.storage.schema import CHANGE, EDIT, FORMER, LABEL, LAYOUT, LOT, METADATA, SECTION, STALL, SURVEY, ZONE
from hawk.lots.survey import section_looks
from hawk.lots.values import LotStoreError, NotFoundError


class State(StrEnum):
    """State of a change."""

    DONE = "done"
    UNDONE = "undone"
    """A step can be done again."""
    DROPPED = "dropped"
    """A step was undone, and another one followed."""


@dataclass(frozen=True, slots=True)
class Change:
    """A change as it is to be written. ``lot``: the lot that it is about."""

    kind: str
    lot: str
    rows: tuple[Row, ...]


@dataclass(frozen=True, slots=True)
class Group:
    """Rows of a table whose columns change alike: ``before`` and ``after`` are the columns that are set.

    None stands for no such row: it is new, or goes.
    """

    table: str
    keys: tuple[Key, ...] = field(repr=False)
    before: Mapping[str, Any] | None
    after: Mapping[str, Any] | None

    def back(self) -> Group:
        """Return the change that takes this one back."""
        return Group(self.table, self.keys, self.after, self.before)

    @property
    def does(self) -> str:
        """The statement that writes it: insert, update or delete."""
        return "insert" if self.before is None else "delete" if self.after is None else "update"


def packed(groups: Iterable[Group]) -> str:
    """Return groups as the log keeps them."""
    rows = [
        {"table": each.table, "keys": [key[0] if len(key) == 1 else key for key in each.keys]}
        | {"before": each.before, "after": each.after}
        for each in groups
    ]
    return _text(rows)


def unpacked(body: str) -> tuple[Group, ...]:
    """Return the groups of `packed`."""
    return tuple(
        Group(
            each["table"],
            tuple(tuple(key) if isinstance(key, list) else (key,) for key in each["keys"]),
            each["before"],
            each["after"],
        )
        for each in json.loads(body)
    )


def net(steps: Iterable[Sequence[Group]]) -> tuple[Group, ...]:
    """Return several steps that set columns as one: the first values before and the last ones after."""
    before: dict[tuple[str, Key], dict[str, Any]] = defaultdict(dict)
    after: dict[tuple[str, Key], dict[str, Any]] = defaultdict(dict)
    for group in (group for groups in steps for group in groups):
        for key in group.keys:
            row = (group.table, key)
            before[row] = {**(group.before or {}), **before[row]}
            after[row].update(group.after or {})
    return grouped((table, key, before[table, key], after[table, key]) for table, key in before)


def grouped(rows: Iterable[tuple[str, Key, Mapping[str, Any], Mapping[str, Any]]]) -> tuple[Group, ...]:
    """Return changes of columns with the rows that change alike together: table, key, columns before and after."""
    alike: dict[Any, list[Key]] = defaultdict(list)
    values: dict[Any, tuple[Mapping[str, Any], Mapping[str, Any]]] = {}
    for table, key, before, after in rows:
        named = table, repr(before), repr(after)  # as text 0.0 and -0.0 differ
        alike[named].append(key)
        values.setdefault(named, (before, after))
    return tuple(Group(named[0], tuple(keys), *values[named]) for named, keys in alike.items())


_text: Final = json.JSONEncoder(allow_nan=False, separators=(",", ":")).encode
"""Made once: `json.dumps` makes another encoder for each value."""


def apply(connection: Connection, groups: Iterable[Group]) -> None:
    """Write groups in their order: a row that others name comes before them, and goes after them.

    What surveys saw of the sections that this is about follows.
    """
    every = tuple(groups)
    for (name, does), members in groupby(every, key=lambda group: (group.table, group.does)):
        if does == "insert":
            connection.execute(insert(METADATA.tables[name]), [dict(each.after or {}) for each in members])
        elif does == "delete":
            keys = [_named(name, key) for each in members for key in each.keys]
            connection.execute(delete(METADATA.tables[name]).where(*_is_row(name)), keys)
        else:
            _set(connection, name, list(members))
    sections = {*rows_touched(every, SECTION.name), *_sections_beside(connection, rows_touched(every, ZONE.name))}
    section_looks.renew(connection, rows_touched(every, SURVEY.name), sections)


def _set(connection: Connection, name: str, groups: Sequence[Group]) -> None:
    """Set columns of a table's rows: many rows that change alike at once, the others one after the other."""
    table, single = METADATA.tables[name], defaultdict[tuple[str, ...], list[dict[str, Any]]](list)
    for group in groups:
        after = group.after or {}
        if len(group.keys) > 1 and len(group.keys[0]) == 1:
            (key,) = table.primary_key
            among = json.dumps([each for (each,) in group.keys])
            connection.execute(update(table).where(is_among(key)).values(**after), {"among": among})
        else:
            values = {f"new_{column}": value for column, value in after.items()}
            single[tuple(sorted(after))] += [{**_named(name, each), **values} for each in group.keys]
    for columns, rows in single.items():
        new: dict[str, Any] = {each: bindparam(f"new_{each}") for each in columns}
        connection.execute(update(table).where(*_is_row(name)).values(**new), rows)


def _is_row(table: str) -> list[Any]:
    return [column == bindparam(f"key_{column.name}") for column in METADATA.tables[table].primary_key]


def _named(table: str, key: Key) -> dict[str, Any]:
    columns = METADATA.tables[table].primary_key
    return {f"key_{column.name}": value for column, value in zip(columns, key, strict=True)}


def _sections_beside(connection: Connection, zones: Sequence[str]) -> Sequence[int]:
    """Return the keys of the sections of lots in whose plans private ground begins or ends, by ids of zones."""
    if not zones:
        return ()
    lots = select(ZONE.c.lot).where(is_among(ZONE.c.id), ZONE.c.kind == PRIVATE)
    asked = select(SECTION.c.key).where(SECTION.c.lot.in_(lots), SECTION.c.ends.is_(None))
    return connection.execute(asked, {"among": json.dumps(zones)}).scalars().all()


def rows_touched(groups: Iterable[Group], table: str) -> list[Any]:
    """Return the keys of the rows that groups change, of a table whose key is one column, each once."""
    return list(dict.fromkeys(key for group in groups if group.table == table for (key,) in group.keys))


def write(connection: Connection, change: Change, who: str, now: float) -> Done:
    """Write a change. Raises LotStoreError for rows that do not fit the others."""
    groups = _differences(connection, change.rows)
    plans = _plans_of(connection, groups)
    apply(connection, groups)
    for lot in plans | _plans_of(connection, groups):
        read_again(connection, lot)
    seq = record(connection, change.kind, change.lot, who, now, groups)
    return Done(seq=seq, kind=change.kind, lot=change.lot)


def record(
    connection: Connection, kind: str, lot: str, who: str, now: float, groups: Sequence[Group], **step: object
) -> int:
    """Note a change that was made, and return its number. ``step``: the columns of a step of an edit."""
    values = {"kind": kind, "lot": lot, "who": who, "made": now, "body": packed(groups), "state": State.DONE.value}
    seq = connection.execute(insert(CHANGE).values(**values, **step)).inserted_primary_key
    assert seq is not None  # noqa: S101 - a row was inserted
    return int(seq[0])


def _differences(connection: Connection, rows: Sequence[Row]) -> tuple[Group, ...]:
    """Return what rows change, in their order."""
    found: list[Group] = []
    for table, members in groupby(rows, key=lambda row: row.table):
        pairs = [(row, before) for row, before in _with_former(connection, table, list(members))]
        for is_set, run in groupby(pairs, key=lambda pair: None not in (pair[0].values, pair[1])):
            if is_set:
                changing = ((row, before) for row, before in run if _text(before) != _text(row.values))
                found += grouped((table, row.key, before or {}, row.values or {}) for row, before in changing)
            else:
                found += [Group(table, (row.key,), before, row.values) for row, before in run if before or row.values]
    return tuple(found)


def _with_former(
    connection: Connection, table: str, rows: Sequence[Row]
) -> Iterable[tuple[Row, Mapping[str, Any] | None]]:
    """Yield rows of a table with the same columns as they are now, None for a row that is not there."""
    for columns, members in groupby(rows, key=lambda row: _columns(row.values)):
        run = list(members)
        former = read_rows(connection, table, [row.key for row in run], columns)
        yield from ((row, former.get(row.key)) for row in run)


def undo(connection: Connection, seq: int, now: float) -> str:
    """Bring back what a change changed; return its kind.

    Raises NotFoundError, and LotStoreError for a change that was undone already, or of which something changed since.
    """
    named = select(CHANGE.c.kind, CHANGE.c.state).where(CHANGE.c.seq == seq, CHANGE.c.edit.is_(None))
    found = connection.execute(named).first()
    if found is None:
        raise NotFoundError(f"change: there is none with the number {seq}")
    groups = _to_undo(connection, seq, found.state)
    begun = _begun(groups)
    plans = _plans_of(connection, groups)
    try:
        for lot, version in begun:
            connection.execute(delete(FORMER).where(FORMER.c.lot == lot, FORMER.c.ends == version))
        apply(connection, [group.back() for group in reversed(groups)])
    except IntegrityError as error:
        raise LotStoreError(f"change: {seq} cannot be undone: {_STORED_SINCE}") from error
    for lot in plans | _plans_of(connection, groups):
        read_again(connection, lot)
    connection.execute(update(CHANGE).where(CHANGE.c.seq == seq).values(state=State.UNDONE.value, undone=now))
    return str(found.kind)


def why_kept(connection: Connection, seq: int, state: str) -> str:
    """Return why a change cannot be undone now; "" for one that can. ``state``: of the change."""
    try:
        _to_undo(connection, seq, state)
    except LotStoreError as refusal:
        return str(refusal)
    return ""


def _to_undo(connection: Connection, seq: int, state: str) -> tuple[Group, ...]:
    """Return what the undo of a change takes back. Raises LotStoreError."""
    if state != State.DONE:
        raise LotStoreError(f"change: {seq} was undone already; make the change again to have it back")
    every = (*read(connection, seq), *_steps_of(connection, seq))
    groups = tuple(group for group in every if group.table != LABEL.name)  # of a version that kept them apart
    _check_unchanged(connection, seq, groups, _begun(groups))
    return groups


def _begun(groups: Sequence[Group]) -> list[Key]:
    """Return the versions of layouts that groups begin."""
    return [key for group in groups if group.table == LAYOUT.name and group.before is None for key in group.keys]


def _steps_of(connection: Connection, seq: int) -> tuple[Group, ...]:
    """Return the steps of the edit that a change ended, as one; none for another change."""
    steps = select(CHANGE.c.seq).join(EDIT, EDIT.c.id == CHANGE.c.edit)
    done = steps.where(EDIT.c.change == seq, CHANGE.c.state == State.DONE.value).order_by(CHANGE.c.seq)
    return net([read(connection, step) for step in connection.execute(done).scalars().all()])


def read(connection: Connection, seq: int) -> tuple[Group, ...]:
    """Return what a change of the log changed. Raises LotStoreError for one that is damaged on the disk."""
    check_whole(connection, CHANGE.name, seq, "change")
    return unpacked(connection.execute(select(CHANGE.c.body).where(CHANGE.c.seq == seq)).scalar_one())


_STORED_SINCE: Final = "surveys or stalls were stored since in the lot that it made; move them to another lot first"


def _check_unchanged(connection: Connection, seq: int, groups: Sequence[Group], begun: Sequence[Key]) -> None:
    """Refuse an undo where something was built upon the change. ``begun``: versions of layouts that it made."""
    is_other = not _stand(connection, groups)
    for lot, version in begun if not is_other else ():
        check_not_edited(connection, lot)
        merged = connection.execute(select(LOT.c.merged_into).where(LOT.c.id == lot)).scalar()
        is_other = is_other or merged is not None or newest_layout(connection, lot) != version
    if is_other:
        raise LotStoreError(f"change: lots of {seq} were changed since; undo the later changes first")
    own = {seq for group in groups if group.table == SURVEY.name for (seq,) in group.keys}
    for lot, version in begun:
        asked = select(SURVEY.c.seq).where(SURVEY.c.lot == lot, SURVEY.c.layout == version)
        if {*connection.execute(asked).scalars()} - own:
            words = "surveys were registered since with the layout it made"
            raise LotStoreError(f"change: {seq} cannot be undone: {words}")
    made = [key for group in groups if group.table == LOT.name and group.before is None for (key,) in group.keys]
    stored = select(SURVEY.c.seq).where(SURVEY.c.lot.in_(made))
    if made and {*connection.execute(stored).scalars()} - own:
        raise LotStoreError(f"change: {seq} cannot be undone: {_STORED_SINCE}")


def _stand(connection: Connection, groups: Sequence[Group]) -> bool:
    """Return whether rows are as groups made them, by the columns that these set."""
    for (table, columns), members in groupby(groups, key=lambda group: (group.table, _columns(group.after))):
        after = {key: _text(group.after) for group in members for key in group.keys}
        there = read_rows(connection, table, after, columns)
        if any(_text(there.get(key)) != text for key, text in after.items()):
            return False
    return True


def _columns(values: Mapping[str, Any] | None) -> tuple[str, ...] | None:
    return None if values is None else tuple(values)


def _plans_of(connection: Connection, groups: Sequence[Group]) -> set[str]:
    """Return the lots whose plans have stalls, zones or sections that groups change, as they are now."""
    found: set[str] = set()
    for table in (STALL, ZONE, SECTION):
        if keys := rows_touched(groups, table.name):
            (key,) = table.primary_key
            asked = select(table.c.lot).distinct().where(is_among(key))
            found.update(connection.execute(asked, {"among": json.dumps(keys)}).scalars())
    return found
