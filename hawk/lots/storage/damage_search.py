"""Search for damage in a whole store, some parts at a time: a store of thousands of lots is open before all of it was
compared.
"""

from __future__ import annotations

import sqlite3
import threading
from collections.abc import Callable
from typing import Final

from hawk.lots.storage.digests import LAST, Part, columns_of, differs, selections
from hawk.lots.storage.schema import PARTS

_AT_ONCE: Final = 200
"""Parts whose digests are read together."""
_WATCH_S: Final = 0.02
"""Real seconds between two looks whether the search is over."""
_AFTER: Final = "SELECT part, key, digest FROM digest WHERE (part, key) > (?, ?) ORDER BY part, key LIMIT ?"
_WITHOUT: Final = (
    "SELECT CAST({key} AS BLOB) FROM {table} AS one"
    " WHERE NOT EXISTS (SELECT 1 FROM digest WHERE part = '{kind}' AND digest.key = CAST(one.{key} AS TEXT))"
)


def damaged_parts(store: sqlite3.Connection) -> tuple[Part, ...]:
    """Return the parts whose rows are not those that were stored, by kind and key.

    Raises sqlite3.Error for a file that cannot be read.
    """
    search = DamageSearch(looks_at_pages=False)
    search.go_on(store, lambda: False)
    return tuple(sorted(search.found))


def faults_of(store: sqlite3.Connection, is_over: Callable[[], bool] = lambda: False) -> str | None:
    """Return what is wrong with the pages of a file, in SQLite's words, "" for nothing; None where it was over."""
    found = _unless(store, is_over, "PRAGMA integrity_check(3)")
    if found is None:
        return None
    return "" if found == [("ok",)] else "; ".join(" ".join(str(row[0]).split()) for row in found)


class DamageSearch:
    """Reads all of a store once, and names the parts that are damaged.

    ``found``: these parts so far. ``stale``: lots whose newest survey is to be made again. ``faults``: what is
    wrong with the file itself, in SQLite's words; "" for nothing.
    """

    def __init__(self, *, looks_at_pages: bool = True) -> None:
        """Nothing is read yet. ``looks_at_pages``: the file's pages are checked before the parts."""
        self.found: set[Part] = set()
        self.stale: set[str] = set()
        self.faults = ""
        self._at = ("", "")
        self._steps = [self._pages, self._digests, self._unknown][not looks_at_pages :]

    def go_on(self, store: sqlite3.Connection, is_over: Callable[[], bool]) -> bool:
        """Search until all was read, which is True, or ``is_over``, which is asked again and again.

        Each call may have another view of the store: the digest of a part and its rows are read in one. Raises
        sqlite3.Error for a file that cannot be read.
        """
        while self._steps:
            if is_over() or not self._steps[0](store, is_over):
                return False
            self._steps.pop(0)
        return True

    def _pages(self, store: sqlite3.Connection, is_over: Callable[[], bool]) -> bool:
        """Look at the file's pages."""
        faults = faults_of(store, is_over)
        if faults is None:
            return False
        self.faults = faults
        if faults:
            del self._steps[1:]
        return True

    def _digests(self, store: sqlite3.Connection, is_over: Callable[[], bool]) -> bool:
        """Compare the parts with their digests."""
        asked = {kind: selections(store, kind) for kind in PARTS}
        while parts := self._next(store):
            for kind, key, digest in parts:
                if is_over():
                    return False
                part = Part(kind, str(key))
                if digest is not None and differs(store, part, digest, asked.get(kind)):
                    self._note(part)
                self._at = kind, key
        return True

    def _next(self, store: sqlite3.Connection) -> list[tuple[str, str, bytes | None]]:
        try:
            return store.execute(_AFTER, (*self._at, _AT_ONCE)).fetchall()
        except (sqlite3.OperationalError, UnicodeError) as error:  # text that is none
            raise sqlite3.DatabaseError(f"{error}: the digests cannot be read") from error

    def _unknown(self, store: sqlite3.Connection, is_over: Callable[[], bool]) -> bool:
        """Find the parts that have no digest."""
        for kind, tables in PARTS.items():
            table, key = next(iter(tables.items()))
            if not columns_of(store, table):
                continue
            rows = _unless(store, is_over, _WITHOUT.format(kind=kind, table=table, key=key))
            if rows is None:
                return False
            for (each,) in rows:
                if isinstance(each, bytes):
                    self._note(Part(kind, each.decode(errors="replace")))
        return True

    def _note(self, part: Part) -> None:
        if part.kind == LAST:  # nothing is lost
            self.stale.add(part.key)
        else:
            self.found.add(part)


def _unless(
    store: sqlite3.Connection, is_over: Callable[[], bool], asked: str
) -> list[tuple[object, ...]] | None:  # fmt: skip
    """Return what a statement finds; None where it was over before.

    A thread interrupts it: SQLite checks all pages of a table in one step, between which alone a progress handler is
    called, and 27 GB take minutes.
    """
    ended, was_over = threading.Event(), False

    def watch() -> None:
        nonlocal was_over
        while not ended.wait(_WATCH_S):
            if is_over():
                was_over = True
                store.interrupt()

    watcher = threading.Thread(target=watch, name="lots-search-end", daemon=True)
    watcher.start()
    try:
        return store.execute(asked).fetchall()
    except sqlite3.OperationalError:
        if was_over:
            return None
        raise
    finally:
        ended.set()
        watcher.join()
