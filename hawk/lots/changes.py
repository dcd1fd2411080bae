"""Changes of lots by persons: name, merge, split, move. Each is a pure operation on rows, and is undone once.

An operation returns the rows that it changes as they are to be. The transaction that writes them stores the rows as
they were, so that `undo` brings them back, as long as nobody changed one of them since. Labels that were given stay
given.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from typing import Any, TypeVar

from sqlalchemy import Connection, Table, delete, insert, select, update
from sqlalchemy.exc import IntegrityError

from hawk.lots.plan.follow import read_again
from hawk.lots.plan.steps import is_among
from hawk.lots.plan.versions import check_not_edited, newest_layout
from hawk.lots.tables import CHANGE, LABEL, LAYOUT, METADATA, STALL, SURVEY, ZONE
from hawk.lots.values import LONGEST_NAME, LotInputError, LotStoreError, NotFoundError

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Row:
    """A row of a table by its key; ``values`` are all its columns, None for no such row."""

    table: str
    key: tuple[Any, ...]
    values: Mapping[str, Any] | None = field(repr=False)


@dataclass(frozen=True, slots=True)
class Change:
    """A change as it is to be written. ``lot``: the lot that it is about."""

    kind: str
    lot: str
    rows: tuple[Row, ...]


@dataclass(frozen=True, slots=True)
class Done:
    """A change that was written; ``seq`` undoes it."""

    seq: int
    kind: str
    lot: str


def checked_name(name: object, field: str = "name") -> str:
    """Return a name without space around it. Any text is one; nothing of it is read. Raises LotInputError."""
    if not isinstance(name, str):
        raise LotInputError(field, "must be text")
    tidy = " ".join(name.split())
    if not tidy:
        raise LotInputError(field, "is empty: write one or more letters")
    if len(tidy) > LONGEST_NAME:
        raise LotInputError(field, f"has {len(tidy)} characters: write {LONGEST_NAME} or fewer")
    if not tidy.isprintable():
        raise LotInputError(field, "holds characters that cannot be shown: write it without")
    return tidy


def named(lot: Row, name: object) -> Change:
    """Return the change of a lot's name. Raises LotInputError."""
    return Change("name", lot.key[0], (changed(lot, name=checked_name(name)),))


def changed(row: Row, **values: object) -> Row:
    """Return a row with other values in some columns."""
    assert row.values is not None  # noqa: S101 - rows that are not there are not changed
    return Row(row.table, row.key, {**row.values, **values})


def write(connection: Connection, change: Change, who: str, now: float) -> Done:
    """Write a change, and the rows as they were. Raises LotStoreError for rows that do not fit the others."""
    before = _as_they_are(connection, change.rows)
    _put(connection, change.rows, before)
    _read_again(connection, (*before, *change.rows))
    made = connection.execute(
        insert(CHANGE).values(kind=change.kind, who=who, made=now, before=_json(before), after=_json(change.rows))
    )
    seq = made.inserted_primary_key
    assert seq is not None  # noqa: S101 - a row was inserted
    return Done(int(seq[0]), change.kind, change.lot)


def undo(connection: Connection, seq: int, now: float) -> str:
    """Bring back the rows as they were before a change; return its kind.

    Raises NotFoundError, and LotStoreError for a change that was undone already, or of which something changed since.
    """
    found = connection.execute(select(CHANGE).where(CHANGE.c.seq == seq)).mappings().first()
    if found is None:
        raise NotFoundError(f"change: there is none with the number {seq}")
    if found["undone"] is not None:
        raise LotStoreError(f"change: {seq} was undone already; make the change again to have it back")
    after = [row for row in _rows(found["after"]) if row.table != LABEL.name]
    if any(_differs(now_, row) for now_, row in zip(_as_they_are(connection, after), after, strict=True)):
        raise LotStoreError(f"change: lots of {seq} were changed since; undo the later changes first")
    before = [row for row in _rows(found["before"]) if row.table != LABEL.name]
    ended = [row.key for row in before if row.table == LAYOUT.name and row.values is None]
    for lot, version in ended:
        check_not_edited(connection, lot)
        if newest_layout(connection, lot) != version:
            raise LotStoreError(f"change: lots of {seq} were changed since; undo the later changes first")
    own = {row.key for row in before if row.table == SURVEY.name}
    later = (row for lot, version in ended for row in rows_where(connection, SURVEY, lot=lot, layout=version))
    if any(row.key not in own for row in later):
        raise LotStoreError(f"change: {seq} cannot be undone: surveys were registered since with the layout it made")
    try:
        backwards = before[::-1]
        _put(connection, backwards, _as_they_are(connection, backwards))
    except IntegrityError as error:
        words = "surveys or stalls were stored since in the lot that it made; move them to another lot first"
        raise LotStoreError(f"change: {seq} cannot be undone: {words}") from error
    _read_again(connection, (*before, *after))
    connection.execute(update(CHANGE).where(CHANGE.c.seq == seq).values(undone=now))
    return str(found["kind"])


def _read_again(connection: Connection, rows: Sequence[Row]) -> None:
    """Let those who follow the plans of rows read them again."""
    of_plans = [row.values for row in rows if row.table in (STALL.name, ZONE.name) and row.values is not None]
    for lot in {str(values["lot"]) for values in of_plans}:
        read_again(connection, lot)


def row_of(connection: Connection, table: str, key: Sequence[Any]) -> Row:
    """Return a row as it is now."""
    shown = METADATA.tables[table]
    values = connection.execute(select(shown).where(*_is(shown, key))).mappings().first()
    return Row(table, tuple(key), None if values is None else dict(values))


def rows_where(connection: Connection, table: Table, **equal: object) -> list[Row]:
    """Return the rows of a table whose columns have these values, by their keys."""
    asked = select(table).where(*(table.c[name] == value for name, value in equal.items()))
    keys = [column.name for column in table.primary_key]
    found = connection.execute(asked.order_by(*(table.c[name] for name in keys))).mappings()
    return [Row(table.name, tuple(row[name] for name in keys), dict(row)) for row in found]


def _is(table: Table, key: Sequence[Any]) -> list[Any]:
    return [column == value for column, value in zip(table.primary_key, key, strict=True)]


def _as_they_are(connection: Connection, rows: Sequence[Row]) -> list[Row]:
    """Return rows as they are now, in their order; rows of a table that follow each other are read at once."""
    found: list[Row] = []
    for (name, first), members in _runs(rows, lambda row: (row.table, row.key[:-1])):
        if len(members) == 1:
            found.append(row_of(connection, name, members[0].key))
            continue
        table = METADATA.tables[name]
        *others, last = table.primary_key
        asked = select(table).where(*(column == value for column, value in zip(others, first, strict=True)))
        among = json.dumps([row.key[-1] for row in members])
        there = connection.execute(asked.where(is_among(last)), {"among": among}).mappings()
        values = {row[last.name]: dict(row) for row in there}
        found += [Row(name, row.key, values.get(row.key[-1])) for row in members]
    return found


def _put(connection: Connection, rows: Sequence[Row], before: Sequence[Row]) -> None:
    """Write rows in their order, which are ``before`` now. A row that others name comes before them, goes after them.

    Rows of a table that follow each other and are all new, or all go, are written at once.
    """
    pairs = list(zip(rows, before, strict=True))
    for (name, first, does), members in _runs(pairs, lambda pair: (pair[0].table, pair[0].key[:-1], _does(*pair))):
        table = METADATA.tables[name]
        *others, last = table.primary_key
        if does is insert:
            connection.execute(insert(table), [dict(row.values or {}) for row, _ in members])
        elif does is delete:
            is_first = [column == value for column, value in zip(others, first, strict=True)]
            among = json.dumps([row.key[-1] for row, _ in members])
            connection.execute(delete(table).where(*is_first, is_among(last)), {"among": among})
        else:
            for row, _ in members:
                connection.execute(update(table).where(*_is(table, row.key)).values(**(row.values or {})))


def _differs(now: Row, row: Row) -> bool:
    """Return whether a row is not as a change made it, by the columns that the store had then."""
    if now.values is not None and row.values is not None:
        now = Row(now.table, now.key, {name: value for name, value in now.values.items() if name in row.values})
    return _json([now]) != _json([row])


def _does(row: Row, before: Row) -> Any:
    """Return the statement that writes a row."""
    return delete if row.values is None else insert if before.values is None else update


def _runs(items: Sequence[T], of: Callable[[T], Any]) -> Iterator[tuple[Any, list[T]]]:
    """Yield items that follow each other and have the same key, with it."""
    for key, members in groupby(items, key=of):
        yield key, list(members)


def _json(rows: Sequence[Row]) -> str:
    packed = [[row.table, list(row.key), row.values] for row in rows]
    return json.dumps(packed, allow_nan=False, separators=(",", ":"), sort_keys=True, default=_packed)


def _packed(value: object) -> object:
    if isinstance(value, bytes):
        return {"bytes": base64.b64encode(value).decode()}
    raise TypeError(f"{type(value).__name__} is no value of a row")


def _rows(text: str) -> tuple[Row, ...]:
    def read(value: Any) -> Any:
        return base64.b64decode(value["bytes"]) if isinstance(value, dict) else value

    return tuple(
        Row(table, tuple(key), None if values is None else {name: read(value) for name, value in values.items()})
        for table, key, values in json.loads(text)
    )
