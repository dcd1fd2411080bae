"""Rows of the lots' store that hold something of a survey or of a lot, and their removal.

Changes and messages repeat rows as text: those that name what is erased go, too, and can be undone no more.
"""

from __future__ import annotations

import contextlib
import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from hawk.lots.choosing import chosen_survey
from hawk.lots.values import LotStoreError, NotFoundError

_LOT_TABLES: Final = ("former", "label", "zone", "dropped", "pin", "plan", "share")
"""Tables whose column ``lot`` is the lot's id."""


@dataclass(frozen=True, slots=True)
class Erased:
    """``surveys``: ids; ``journals``: names of their folders, which their recordings name, too."""

    surveys: tuple[str, ...]
    journals: tuple[str, ...]


def erase_survey(store: sqlite3.Connection, survey: str) -> Erased:
    """Remove a survey by its id, or by the beginning of it. Stalls that it found stay: they are the lot's.

    Raises NotFoundError.
    """
    chosen = chosen_survey(store.execute("SELECT id, ended FROM survey ORDER BY ended, seq").fetchall(), survey)
    found = store.execute("SELECT seq, id, origin FROM survey WHERE id = ?", (chosen,)).fetchall()
    return _erase_surveys(store, found)


def erase_lot(store: sqlite3.Connection, lot: str) -> Erased:
    """Remove a lot by its id or name, with stalls, plan, links and surveys. Raises NotFoundError, LotStoreError."""
    rows = store.execute("SELECT id, name FROM lot WHERE id = ?1 OR name = ?1", (lot,)).fetchall()
    if not rows:
        names = ", ".join(name for (name,) in store.execute("SELECT name FROM lot ORDER BY name"))
        raise NotFoundError(f"--lot: there is no lot {lot!r}; there are: {names or 'none'}")
    if len(rows) > 1:
        known = ", ".join(found for found, _ in rows)
        raise LotStoreError(f"--lot: {len(rows)} lots are called {lot!r}: give the id of one ({known})")
    ids = _with_merged(store, rows[0][0])
    erased = [_erase_surveys(store, _surveys(store, each)) for each in ids]
    _forget_texts(store, [text for each in ids for text in _words_of(store, each)])
    for each in ids:
        _erase_ground(store, each)
    for each in ids[::-1]:
        store.execute("DELETE FROM lot WHERE id = ?", (each,))
    return Erased(tuple(one for each in erased for one in each.surveys), tuple(n for e in erased for n in e.journals))


def _with_merged(store: sqlite3.Connection, lot: str) -> list[str]:
    """Return a lot and those that were merged into it, the lot first."""
    found = [lot]
    for each in found:
        found += [one for (one,) in store.execute("SELECT id FROM lot WHERE merged_into = ?", (each,))]
    return found


def _surveys(store: sqlite3.Connection, lot: str) -> list[tuple[int, str, str]]:
    return store.execute("SELECT seq, id, origin FROM survey WHERE lot = ?", (lot,)).fetchall()


def _words_of(store: sqlite3.Connection, lot: str) -> list[str]:
    """Return the ids that changes and messages may name: the lot and its stalls."""
    return [lot, *(stall for (stall,) in store.execute("SELECT id FROM stall WHERE lot = ?", (lot,)))]


def _erase_ground(store: sqlite3.Connection, lot: str) -> None:
    edits = "SELECT id FROM edit WHERE lot = ?"
    store.execute(f"DELETE FROM step WHERE edit IN ({edits})", (lot,))  # noqa: S608 - our own words
    store.execute("DELETE FROM edit WHERE lot = ?", (lot,))
    stalls = "SELECT key FROM stall WHERE lot = ?"
    for table in ("observation", "former"):
        store.execute(f"DELETE FROM {table} WHERE stall IN ({stalls})", (lot,))  # noqa: S608 - our own words
    for table in _LOT_TABLES:
        store.execute(f"DELETE FROM {table} WHERE lot = ?", (lot,))  # noqa: S608 - our own words
    store.execute("DELETE FROM stall WHERE lot = ?", (lot,))
    store.execute("DELETE FROM layout WHERE lot = ?", (lot,))


def _erase_surveys(store: sqlite3.Connection, found: Sequence[tuple[int, str, str]]) -> Erased:
    for seq, _, _ in found:
        store.execute("UPDATE stall SET first_survey = NULL, first_id = NULL WHERE first_survey = ?", (seq,))
        for table in ("observation", "looks", "dropped"):
            store.execute(f"DELETE FROM {table} WHERE survey = ?", (seq,))  # noqa: S608 - our own words
        store.execute("DELETE FROM survey WHERE seq = ?", (seq,))
    _forget_texts(store, [text for _, survey, origin in found for text in (survey, origin)])
    return Erased(tuple(each for _, each, _ in found), tuple(origin.partition(" ")[0] for *_, origin in found))


def _forget_texts(store: sqlite3.Connection, texts: Iterable[str]) -> None:
    """Remove changes and messages that hold one of some texts."""
    wanted = set(texts)
    for table, columns in (("change", ("before", "after")), ("outbox", ("body",))):
        rows = store.execute(f"SELECT seq, {', '.join(columns)} FROM {table}").fetchall()  # noqa: S608 - our own words
        gone = [(row[0],) for row in rows if any(text in part for part in row[1:] for text in wanted)]
        store.executemany(f"DELETE FROM {table} WHERE seq = ?", gone)  # noqa: S608 - our own words


@contextlib.contextmanager
def emptied(path: Path) -> Iterator[sqlite3.Connection]:
    """Give the store in a transaction; write the file again at its end, so that nothing of removed rows is left."""
    with contextlib.closing(sqlite3.connect(path, timeout=10, isolation_level=None)) as store:
        store.execute("PRAGMA trusted_schema = OFF")
        store.execute("PRAGMA foreign_keys = ON")
        store.execute("PRAGMA secure_delete = ON")
        store.execute("BEGIN IMMEDIATE")
        try:
            yield store
        except BaseException:
            store.execute("ROLLBACK")
            raise
        store.execute("COMMIT")
        store.execute("VACUUM")
        store.execute("PRAGMA wal_checkpoint(TRUNCATE)")
