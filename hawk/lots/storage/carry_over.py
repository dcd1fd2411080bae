"""Knowledge that a restore carries over from the store that was there: links that were taken back, what was erased, and
what has come from drones since the backup.

A backup knows nothing of what was done after it. A link opens after a restore only where the store before had it open.
Every survey and lot of the backup gets a new state: a desk that has later ones follows the restored store.
"""

from __future__ import annotations

import contextlib
import math
import mmap
import re
import sqlite3
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, cast

from hawk.lots.storage import states
from hawk.lots.storage.damage_search import DamageSearch, damaged_parts
from hawk.lots.storage.database import check, read_only
from hawk.lots.storage.digests import Part, forget, seal
from hawk.lots.storage.erasure import all_erased, erase_again, note_erased
from hawk.lots.storage.schema import ARRIVAL, VERSION
from hawk.lots.values import LotStoreError

_ARRIVAL: Final = ", ".join(ARRIVAL.c.keys())
_WITH_ARRIVALS: Final = 8
"""Version of the store that has a log of arrivals first."""
_HASH: Final = re.compile(rb"(?=([0-9a-f]{64}))")
"""A SHA-256 as text, wherever it begins."""


@dataclass(frozen=True, slots=True)
class Former:
    """The store before a restore.

    ``is_whole``: it can be read, and nothing in it is damaged. ``open_until``: id of each link that was not taken back
    -> its end, Unix seconds. ``erased``: as of `hawk.lots.storage.erasure.erased_id`. ``last_state``: greatest number
    that a survey, a lot or a message had. ``arrivals``: rows of the log of arrivals, the oldest first.
    """

    is_whole: bool = False
    open_until: Mapping[str, float] = field(default_factory=dict, repr=False)
    erased: frozenset[str] = frozenset()
    last_state: int = 0
    arrivals: tuple[tuple[object, ...], ...] = field(default=(), repr=False)


def former_of(path: Path) -> Former:
    """Return what is known of a store; of one that is not there or cannot be read nothing."""
    try:
        version = check(path)
    except LotStoreError:
        return Former(erased=_erased_in(path))
    if version > VERSION:
        return Former(is_whole=True, open_until=_links_of(path, ()))
    with contextlib.closing(read_only(path)) as store:
        store.execute("BEGIN")
        damaged = damaged_parts(store)
        erased = frozenset(all_erased(store))
        last_state = states.last(store)
        is_older = version < _WITH_ARRIVALS
        arrivals = () if is_older else tuple(store.execute(f"SELECT {_ARRIVAL} FROM arrival ORDER BY seq"))  # noqa: S608
    return Former(not damaged, _links_of(path, damaged), erased, last_state, arrivals)


def _links_of(path: Path, damaged: tuple[Part, ...]) -> dict[str, float]:
    """Return the links that were not taken back, without those of lots that are damaged."""
    try:
        with contextlib.closing(read_only(path)) as store:
            rows = store.execute("SELECT id, lot, ends FROM share WHERE taken_back IS NULL").fetchall()
    except (sqlite3.Error, UnicodeError):  # of a version without links
        return {}
    return {str(each): float(ends) for each, lot, ends in rows if Part("lot", lot) not in damaged}


def _erased_in(path: Path) -> frozenset[str]:
    """Return what a store says of erasures that SQLite cannot read: every text of the file that may be a hash.

    One too many brings nothing back. The file is not touched, and an erasure never waits in the WAL.
    """
    if not path.is_file() or not path.stat().st_size:
        return frozenset()
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        return frozenset(found[1].decode() for found in _HASH.finditer(data))


def carry_over(prepared: Path, former: Former, now: float) -> tuple[str, ...]:
    """Take back links in a store that is to be restored, and erase again what was erased; return what was done.

    Raises sqlite3.Error.
    """
    with contextlib.closing(sqlite3.connect(prepared, isolation_level=None)) as store:
        for pragma in ("foreign_keys = ON", "trusted_schema = OFF", "secure_delete = ON"):
            store.execute(f"PRAGMA {pragma}")
        store.execute("BEGIN IMMEDIATE")
        search = DamageSearch(looks_at_pages=False)
        search.go_on(store, lambda: False)
        forget(store, search.stale)
        note_erased(store, former.erased)
        gone = erase_again(store)
        links = _take_back(store, former, now)
        states.renumber_all(store, former.last_state)
        _add_arrivals(store, former)
        seal(store, search.found)
        store.execute("COMMIT")
        if gone.surveys or gone.lots:
            store.execute("VACUUM")
    notes = []
    if gone.surveys or gone.lots:
        notes.append(f"Erased again, as before this restore: lots {len(gone.lots)}, surveys {len(gone.surveys)}")
    if links:
        words = "they were taken back after the backup, or the store before did not know them. Make new ones"
        notes.append(f"Links taken back: {links}; {words}")
    return tuple(notes)


def _add_arrivals(store: sqlite3.Connection, former: Former) -> None:
    """Add what has come since the backup: whose number is greater than that of the last arrival in it."""
    last = store.execute("SELECT coalesce(max(seq), 0) FROM arrival").fetchone()[0]
    marks = ", ".join("?" * len(ARRIVAL.c))
    later = [row for row in former.arrivals if cast("int", row[0]) > last]
    store.executemany(f"INSERT INTO arrival ({_ARRIVAL}) VALUES ({marks})", later)  # noqa: S608 - our own words


def _take_back(store: sqlite3.Connection, former: Former, now: float) -> int:
    """Close the links that were not open before, let none last longer than before; return how many were closed."""
    closed = 0
    for each, ends in store.execute("SELECT id, ends FROM share WHERE taken_back IS NULL").fetchall():
        until = former.open_until.get(each, -math.inf)
        if until > -math.inf:
            store.execute("UPDATE share SET ends = min(ends, ?) WHERE id = ?", (until, each))
        else:
            store.execute("UPDATE share SET taken_back = ? WHERE id = ?", (now, each))
            closed += ends > now
    return closed
