"""Digests of what the store holds, part by part: a survey, a lot with its plan, a change, a message.

A disk that changes a bit is no error to SQLite. Each transaction stores the digests of the parts that it changed, which
triggers have noted. They are compared when the file is opened (`hawk.lots.storage.damage_search`), at a backup, by
`hawk-drone verify`, and where one survey or lot is read or changed. A part that is damaged is passed over by every
reader and named; it stays damaged when something is written into it. A newest survey follows from other parts: one that
is damaged is passed over until it is made again, and no damage.
"""

from __future__ import annotations

import hashlib
import sqlite3
import struct
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Final, cast

from sqlalchemy import Connection

from hawk.lots.storage.schema import METADATA, PARTS
from hawk.lots.storage.states import renumber
from hawk.lots.values import LotStoreError, utc

BYTES: Final = 16
"""Of a digest."""
DAMAGED: Final = b""
"""In place of the digest of a part that was damaged before it was changed."""
REMEDY: Final = "Restore a backup that has it whole: hawk-drone restore FILE"
_KNOWN: Final = "hawk.lots.damaged"
_CHECKED: Final = "hawk.lots.checked"
_CODES: Final[Mapping[type, str]] = {float: "d", int: "q"}
"""Codes of `struct`."""
_NUMBERED: Final = ("survey", "change", "outbox")
LAST: Final = "last"
"""Kind of the parts that follow from others (`hawk.lots.survey.last_surveys`)."""
_DAMAGED_SURVEYS: Final = "(SELECT CAST(key AS INTEGER) FROM temp.damaged WHERE part = 'survey')"
_OF_DAMAGED: Final = (
    "lot IN (SELECT key FROM temp.damaged WHERE part IN ('lot', 'last'))"  # noqa: S608 - our own words
    f" OR lot IN (SELECT lot FROM main.survey WHERE seq IN {_DAMAGED_SURVEYS})"
    " OR surveys != (SELECT count(*) FROM main.survey AS one"
    f" WHERE one.lot = last_survey.lot AND one.seq NOT IN {_DAMAGED_SURVEYS})"
)
"""Newest surveys that may follow from what is damaged. Of a damaged survey the row may say another lot than its own,
or be gone: the lot that it was counted to has fewer surveys now."""


@dataclass(frozen=True, slots=True, order=True)
class Part:
    """A part of the store: its kind, of `PARTS`, and its key as text."""

    kind: str
    key: str


@lru_cache
def _selection(table: str, key: str, columns: tuple[str, ...]) -> str:
    names = ", ".join(f'"{name}"' for name in sorted(columns))
    order = ", ".join(f'"{column.name}"' for column in METADATA.tables[table].primary_key)
    return f"SELECT {names} FROM main.{table} WHERE {key} = ? ORDER BY {order}"  # noqa: S608 - our own words


def columns_of(store: sqlite3.Connection, table: str) -> tuple[str, ...]:
    """Return the columns that a table has in this file: an earlier version has fewer, or has no such table."""
    return tuple(row[1] for row in store.execute(f"PRAGMA main.table_info({table})"))


def selections(store: sqlite3.Connection, kind: str) -> list[str]:
    """Return the statements that read the rows of a part of a kind, with its key as their parameter."""
    found = ((table, name, columns_of(store, table)) for table, name in PARTS[kind].items())
    return [_selection(*each) for each in found if each[2]]


def digest_of(store: sqlite3.Connection, part: Part, asked: Sequence[str] | None = None) -> bytes | None:
    """Return the digest of a part as it is, `DAMAGED` for one that cannot be read; None for one without rows.

    ``asked``: the `selections` of its kind, where they are known.
    """
    key = int(part.key) if part.kind in _NUMBERED else part.key
    try:
        asked = selections(store, part.kind) if asked is None else asked
        rows = [store.execute(selection, (key,)).fetchall() for selection in asked]
    except (sqlite3.OperationalError, UnicodeError):  # text that is none
        return DAMAGED
    if not any(rows):
        return None
    return hashlib.blake2b(b"".join(map(_packed, rows)), digest_size=BYTES).digest()


def _packed(rows: Sequence[tuple[object, ...]]) -> bytes:
    """Return rows as bytes that differ where a value or its type does, alike on every computer.

    Column by column: to write 300,000 numbers of an archive as text takes longer than to read them.
    """
    packed = [str(len(rows)).encode()]
    for column in zip(*rows, strict=True):
        kinds = set(map(type, column))
        code = _CODES.get(next(iter(kinds))) if len(kinds) == 1 else None
        packed.append(ascii(column).encode() if code is None else struct.pack(f"<{len(column)}{code}", *column))
    return b"|".join(packed)


def seal(store: sqlite3.Connection, damaged: Collection[Part] = ()) -> None:
    """Store the digests of the parts that the transaction under way has changed, and give them their next states.

    Args:
        store: Within the transaction.
        damaged: Parts that were damaged before: they stay so.
    """
    changed = store.execute("SELECT part, key FROM digest WHERE digest IS NULL").fetchall()
    renumber(store, changed)
    for kind, key in store.execute("SELECT part, key FROM digest WHERE digest IS NULL").fetchall():
        part = Part(kind, key)
        found = digest_of(store, part)
        if found is None:
            store.execute("DELETE FROM digest WHERE part = ? AND key = ?", (kind, key))
        else:
            kept = DAMAGED if part in damaged else found
            store.execute("UPDATE digest SET digest = ? WHERE part = ? AND key = ?", (kept, kind, key))


def seal_everything(store: sqlite3.Connection, damaged: Collection[Part] = ()) -> None:
    """Store the digest of every part: of a store that an earlier version made. ``damaged``: as of `seal`."""
    for kind, tables in PARTS.items():
        for table, key in tables.items():
            store.execute(
                f"INSERT INTO digest (part, key) SELECT DISTINCT '{kind}', CAST({key} AS TEXT) FROM {table} "  # noqa: S608
                "WHERE true ON CONFLICT (part, key) DO UPDATE SET digest = NULL"
            )
    store.execute("DELETE FROM last_survey")  # else a damaged one had a digest from now on
    store.execute("INSERT INTO last_survey (lot) SELECT id FROM lot")
    seal(store, damaged)


def forget(store: sqlite3.Connection, lots: Collection[str]) -> None:
    """Forget the newest surveys of lots: the ends of transactions make them again. Rows of no lot go."""
    if lots:
        store.execute("DELETE FROM last_survey WHERE lot NOT IN (SELECT id FROM lot)")
    for lot in lots:
        store.execute("DELETE FROM last_survey WHERE lot = ?", (lot,))
        store.execute("UPDATE digest SET digest = NULL WHERE part = ? AND key = ?", (LAST, lot))
        store.execute("INSERT INTO last_survey (lot) SELECT id FROM lot WHERE id = ?", (lot,))


def lots_of(store: sqlite3.Connection, damaged: Collection[Part]) -> list[str]:
    """Return the lots that damaged parts are of: no newest survey is made of them, which readers would not see."""
    found = {part.key for part in damaged if part.kind == "lot"}
    for part in damaged:
        if part.kind == "survey" and part.key.isdecimal():
            asked = "SELECT CAST(lot AS BLOB) FROM survey WHERE seq = CAST(? AS INTEGER)"
            found |= {bytes(lot or b"").decode(errors="replace") for (lot,) in store.execute(asked, (part.key,))}
    return sorted(found)


def differs(store: sqlite3.Connection, part: Part, digest: object, asked: Sequence[str] | None = None) -> bool:
    """Return True for a part whose rows are not those of its stored digest. ``asked``: as of `digest_of`."""
    if part.kind not in PARTS or (part.kind in _NUMBERED and not part.key.isdecimal()):
        return True
    return digest_of(store, part, asked) != digest or digest == DAMAGED


def words_of(store: sqlite3.Connection, parts: Sequence[Part], most: int = 5) -> str:
    """Return a sentence that names damaged parts and the remedy; "" for none."""
    if not parts:
        return ""
    shown = ", ".join(_name(store, part) for part in parts[:most])
    more = f" and {len(parts) - most} more" if len(parts) > most else ""
    return f"Damaged on the disk, and passed over: {shown}{more}. {REMEDY}"


_NAMES: Final = {
    "survey": ("SELECT id, ended FROM main.survey WHERE seq = ?", "survey"),
    "lot": ("SELECT name, made FROM main.lot WHERE id = ?", "lot"),
}
_OTHERS: Final = {"change": "change", "outbox": "message to a receiver"}


def _name(store: sqlite3.Connection, part: Part) -> str:
    if part.kind not in _NAMES:
        return f"{_OTHERS.get(part.kind, 'part')} {part.key}"
    asked, kind = _NAMES[part.kind]
    try:
        found, moment = store.execute(asked, (part.key,)).fetchone()
        name = str(found)[:8] if kind == "survey" else ascii(str(found))
        return f"{kind} {name} of {utc(float(moment))}" if kind == "survey" else f"{kind} {name}"
    except (sqlite3.Error, UnicodeError, TypeError, ValueError, OverflowError, OSError):
        return f"{kind} {part.key}"


def pass_over(store: sqlite3.Connection, parts: Collection[Part]) -> None:
    """Let a connection that reads see nothing of some parts: views of the same names hide their rows."""
    store.execute("PRAGMA temp_store = MEMORY")
    store.execute("CREATE TEMP TABLE damaged (part TEXT, key TEXT, PRIMARY KEY (part, key)) WITHOUT ROWID")
    store.executemany("INSERT INTO temp.damaged VALUES (?, ?)", [(part.kind, part.key) for part in parts])
    kinds = {part.kind for part in parts} & PARTS.keys()
    for kind in kinds | {LAST}:
        is_damaged = f"CAST({{key}} AS TEXT) IN (SELECT key FROM temp.damaged WHERE part = '{kind}')"  # noqa: S608
        for table, key in PARTS[kind].items():
            hidden = f"coalesce({_OF_DAMAGED}, false)" if kind == LAST else is_damaged.format(key=key)
            store.execute(f"CREATE TEMP VIEW {table} AS SELECT * FROM main.{table} WHERE NOT {hidden}")  # noqa: S608


def note_damaged(connection: Connection, parts: Collection[Part]) -> None:
    """Let `check_whole` know what was damaged when the file was opened."""
    connection.info[_KNOWN] = parts


def is_damaged(connection: Connection, kind: str, key: object) -> bool:
    """Return True for a part that was damaged when the file was opened."""
    return Part(kind, str(key)) in connection.info.get(_KNOWN, ())


def check_whole(connection: Connection, kind: str, key: object, field: str, version: str = "") -> None:
    """Refuse a part that is damaged: when the file was opened, or now.

    Args:
        connection: One that reads or writes.
        kind: Of `PARTS`.
        key: Its key.
        field: What the refusal names.
        version: Of the store; a part is compared once in each. "": it is compared.

    Raises LotStoreError.
    """
    if _KNOWN not in connection.info:
        return  # a store of a newer version, whose digests may be others
    part = Part(kind, str(key))
    if is_damaged(connection, kind, key) or _is_changed(connection, part, version):
        raise LotStoreError(f"{field}: it is damaged on the disk. {REMEDY}")


def _is_changed(connection: Connection, part: Part, version: str) -> bool:
    checked: set[tuple[str, Part]] = connection.info.setdefault(_CHECKED, set())
    if version and (version, part) in checked:
        return False
    store = cast("sqlite3.Connection", connection.connection.dbapi_connection)
    asked = "SELECT digest FROM main.digest WHERE part = ? AND key = ?"
    found = store.execute(asked, (part.kind, part.key)).fetchone()
    if found is None or found[0] is None:  # there is none, or the transaction under way has changed it
        return False
    if differs(store, part, found[0]):
        return True
    if not any(each == version for each, _ in checked):
        checked.clear()
    checked.add((version, part))
    return False
