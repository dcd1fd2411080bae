"""The schema of a store compared with that of a fresh one: tables, columns, indices and triggers, and nothing else.

A file from elsewhere may hold a view in the place of a table, or a trigger that undoes what is written. So its schema
is read, as text, before a row is.
"""

from __future__ import annotations

import hashlib
import re
import sqlite3
from collections.abc import Callable, Mapping
from typing import Final

_STATISTICS: Final = re.compile(r"sqlite_stat\d")
"""SQLite's own tables about its indices, which only somebody with another program makes."""
_MOST: Final = 3
"""Differences that are named."""

Schema = Mapping[str, frozenset[str]]
"""Kind and name of each object -> the parts of its definition, in no order."""


def schema_of(store: sqlite3.Connection) -> Schema:
    """Return the schema of an open file. Raises sqlite3.Error."""
    columns = ", ".join(f"CAST({name} AS BLOB)" for name in ("type", "name", "tbl_name", "sql"))
    found: dict[str, frozenset[str]] = {}
    for row in store.execute(f"SELECT {columns} FROM sqlite_master"):  # noqa: S608 - our own words
        kind, name, table, sql = (bytes(each or b"").decode(errors="replace") for each in row)
        if not sql or _STATISTICS.fullmatch(name):
            continue  # an index that a key of a table makes
        named = f"{kind} {name}"
        again = " again" * (named in found)
        found[f"{named}{again}"] = frozenset({f"of {table}", *_parts(" ".join(sql.replace('"', "").split()))})
    return found


def digest_of_schema(schema: Schema) -> str:
    """Return a digest by which a schema is recognised."""
    text = repr(sorted((name, sorted(parts)) for name, parts in schema.items()))
    return hashlib.blake2b(text.encode(errors="replace"), digest_size=16).hexdigest()


def difference(found: Schema, known: str, fresh: Callable[[], Schema]) -> str:
    """Return in words how a schema differs from that of a fresh store; "" where it does not.

    Args:
        found: The schema.
        known: `digest_of_schema` of a fresh one; "": not known.
        fresh: Makes a fresh one; asked only where ``known`` is another one.
    """
    if digest_of_schema(found) == known:
        return ""
    ours = fresh()
    strange = [f"{_shown(name)} is not one of this program" for name in sorted(found.keys() - ours.keys())]
    missing = [f"{name} is missing" for name in sorted(ours.keys() - found.keys())]
    changed = [
        f"{name} is another one ({_shown(', '.join(sorted(found[name] ^ ours[name])))})"
        for name in sorted(found.keys() & ours.keys())
        if found[name] != ours[name]
    ]
    every = [*missing, *strange, *changed]
    return "; ".join(every[:_MOST]) + (f"; and {len(every) - _MOST} more" if len(every) > _MOST else "")


def _parts(sql: str) -> list[str]:
    """Return a table's definition cut at the commas of its first level: a column that was added stands behind."""
    if not sql.upper().startswith("CREATE TABLE"):
        return [sql]
    found, depth = [""], 0
    for each in sql:
        depth += (each == "(") - (each == ")")
        if (each == "," and depth == 1) or (each == "(" and depth == 1) or (each == ")" and depth == 0):
            found.append("")
        else:
            found[-1] += each
    return [part.strip() for part in found if part.strip()]


def _shown(text: str) -> str:
    """Return a text of a strange file, cut, without what cannot be shown."""
    return "".join(each if each.isprintable() else "?" for each in text[:80])
