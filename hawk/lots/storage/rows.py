"""Rows of the store by their keys: as they are, and as a change is to make them."""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from typing import Any, TypeVar

from pydantic import ValidationError
from sqlalchemy import Connection, Table, bindparam, func, select

from hawk.formats.validation import first_wrong
from hawk.lots.storage.schema import METADATA

_LOG = logging.getLogger(__name__)
G = TypeVar("G")
M = TypeVar("M")

Key = tuple[Any, ...]
"""Values of a table's primary key."""


@dataclass(frozen=True, slots=True)
class Row:
    """A row of a table by its key.

    ``values``: all columns of a row that was read, or that is new; the columns that a change sets; None: no such row.
    """

    table: str
    key: Key
    values: Mapping[str, Any] | None = field(repr=False)

    def __getitem__(self, column: str) -> Any:
        """Return a value of a row that is there."""
        assert self.values is not None  # noqa: S101 - it is there
        return self.values[column]

    def setting(self, **values: object) -> Row:
        """Return the change of some columns of this row."""
        return Row(self.table, self.key, values)

    def removed(self) -> Row:
        """Return the change that removes this row."""
        return Row(self.table, self.key, None)


def row_of(connection: Connection, table: str, key: Key) -> Row:
    """Return a row as it is now."""
    return Row(table, key, read_rows(connection, table, [key]).get(key))


def rows_where(connection: Connection, table: Table, **equal: object) -> list[Row]:
    """Return the rows of a table whose columns have these values, by their keys."""
    asked = select(table).where(*(table.c[name] == value for name, value in equal.items()))
    found = connection.execute(asked.order_by(*table.primary_key)).mappings()
    return [Row(table.name, tuple(row[column.name] for column in table.primary_key), dict(row)) for row in found]


def read_rows(
    connection: Connection, table: str, keys: Iterable[Key], columns: Sequence[str] | None = None
) -> dict[Key, dict[str, Any]]:
    """Return rows as they are now, those that are there, by their keys. ``columns``: None means all."""
    shown = METADATA.tables[table]
    *others, last = shown.primary_key
    names = shown.c.keys() if columns is None else columns
    asked = select(*shown.primary_key, *(shown.c[name].label(f"value_{name}") for name in names))
    found: dict[Key, dict[str, Any]] = {}
    for first, members in groupby(keys, key=lambda key: key[:-1]):
        is_first = (column == value for column, value in zip(others, first, strict=True))
        among = {"among": json.dumps([key[-1] for key in members])}
        for row in connection.execute(asked.where(*is_first, is_among(last)), among):
            count = len(first) + 1
            found[tuple(row[:count])] = dict(zip(names, row[count:], strict=True))
    return found


def is_among(column: Any, values: Iterable[object] | None = None) -> Any:
    """Return the condition that a column is one of any number of values; None: those in ``among``, a JSON list."""
    among: Any = bindparam("among") if values is None else bindparam("values", json.dumps([*values]), unique=True)
    found = func.json_each(among).table_valued("value")
    return column.in_(select(found.c.value))


def readable(made: Callable[[G], M], rows: Iterable[G]) -> list[M]:
    """Return what is made of rows of a list; one whose values cannot be is damaged: it is passed over, and logged."""
    found = []
    for row in rows:
        try:
            found.append(made(row))
        except (TypeError, ValueError, OverflowError) as error:
            words = first_wrong(error) if isinstance(error, ValidationError) else error
            _LOG.warning("a row in the store of lots is damaged: %s", words)
    return found
