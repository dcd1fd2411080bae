"""Backup and restore of the lots' store while a daemon runs, and the lock that keeps a restore away from a flight.

A restore opens no link that was taken back, and brings nothing back that was erased (`hawk.lots.storage.carry_over`).

The lock is flock(2) on a file beside the store: the kernel releases it when its holder ends, however it ends.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import sqlite3
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from hawk.lots.storage.carry_over import carry_over, former_of
from hawk.lots.storage.damage_search import damaged_parts
from hawk.lots.storage.database import BUSY_S, check, copy, explained, free_name, migrate_file, read_only
from hawk.lots.storage.digests import words_of
from hawk.lots.storage.schema import LAST_SURVEY, VERSION
from hawk.lots.values import LotStoreError
from hawk.runtime.files import sync_folder

_BESIDE: Final = ("-wal", "-shm")
"""Ends of the names of SQLite's files beside a store."""
_COUNTED: Final = {"lots": "SELECT count(*) FROM lot", "surveys": "SELECT count(*) FROM survey"}
_ANOTHER: Final = "Nothing was written. Restore another backup"


class FlightLock:
    """Held by a daemon while a survey is flown; many may hold it. One that cannot be taken stops no flight."""

    def __init__(self, path: Path) -> None:
        """``path``: the store."""
        self._path = _lock_of(path)
        self._opened: int | None = None

    def hold(self) -> None:
        """Keep restores away. Raises OSError."""
        if self._opened is None:
            opened = os.open(self._path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
            try:
                fcntl.flock(opened, fcntl.LOCK_SH | fcntl.LOCK_NB)
            except OSError:
                os.close(opened)
                raise
            self._opened = opened

    def release(self) -> None:
        """Allow restores again."""
        if self._opened is not None:
            os.close(self._opened)
            self._opened = None


def backup(path: Path, target: Path) -> str:
    """Write a copy of the store as one file; return words that name what is damaged in it, "" where nothing is.

    A daemon may write the store meanwhile. Raises LotStoreError.
    """
    if target.exists():
        raise LotStoreError(f"{target} is there already. Name a new file")
    if not path.exists():
        raise LotStoreError(f"{path} is not there: no survey was stored yet. Name the daemon's folder: --store DIR")
    check(path)
    with explained(target):
        target.parent.mkdir(parents=True, exist_ok=True)
        copy(path, target)
    return damage_in(target) if check(target) <= VERSION else ""


def damage_in(path: Path) -> str:
    """Return words that name the damaged parts of a store; "" where none is. Raises LotStoreError."""
    with explained(path), contextlib.closing(read_only(path)) as opened:
        opened.execute("BEGIN")
        return words_of(opened, damaged_parts(opened))


def verify(path: Path) -> str:
    """Return what a store or backup holds, once all of it was checked. Raises LotStoreError for what is damaged."""
    version = check(path)
    if version > VERSION:
        return (
            f"{path}: its pages are whole; it is of version {version}, of a newer hawk-drone, which can check the rest"
        )
    with explained(path), contextlib.closing(read_only(path)) as opened:
        loose = {f"{table} names a {other} that is not there" for table, _, other, _ in _loose(opened)}
        held = [f"{name} {opened.execute(asked).fetchone()[0]}" for name, asked in _COUNTED.items()]
    damage = damage_in(path)
    if loose or damage:
        words = [*sorted(f"{each}. {_ANOTHER}" for each in loose), damage]
        raise LotStoreError(f"{path}: {' '.join(filter(None, words))}")
    return f"{path}: whole, {', '.join(held)}"


def _loose(opened: sqlite3.Connection) -> list[tuple[str, int, str, int]]:
    """Return the rows that name others that are not there, but for newest surveys: those are made again."""
    return [row for row in opened.execute("PRAGMA foreign_key_check") if row[0] != LAST_SURVEY.name]


@dataclass(frozen=True, slots=True)
class Restored:
    """A restore: ``kept`` is the file that keeps the former content, None where there was none.

    ``notes``: sentences about what differs from the backup.
    """

    kept: Path | None
    notes: tuple[str, ...] = ()


def restore(path: Path, source: Path, now: float | None = None) -> Restored:
    """Put a backup in the place of the store, in one step.

    A daemon that has the store open goes on with the new content. Links that are open only in the backup are taken
    back, and what was erased is erased again.

    Args:
        path: The store.
        source: The backup.
        now: UTC, Unix seconds; None: by the clock.

    Raises LotStoreError: while a survey is flown, for a backup that is damaged, of a newer version or not of this
    program, and where the disk cannot take it; the store is as before then.
    """
    version = check(source, _ANOTHER)
    if version > VERSION:
        raise LotStoreError(
            f"{source} is of version {version}, of a newer hawk-drone; this one knows version {VERSION}. "
            f"Install that hawk-drone first"
        )
    with explained(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        with _no_flight(path):
            return _restore(path, source, version, time.time() if now is None else now)


def _restore(path: Path, source: Path, version: int, now: float) -> Restored:
    prepared = path.with_name(f".{path.name}.restored")
    try:
        copy(source, prepared)
        if version < VERSION:
            migrate_file(prepared)
        former = former_of(path)
        notes = carry_over(prepared, former, now)
        if damage := damage_in(prepared):
            notes = (*notes, damage)
        if not path.exists():
            _replace(path, prepared)
            return Restored(None, notes)
        kept = free_name(path, "before-restore")
        if former.is_whole and not damage:
            copy(path, kept)
            _overwrite(path, prepared)
        else:  # by another file, so that a daemon opens it and finds what is damaged
            _keep_damaged(path, kept)
            _replace(path, prepared)
        return Restored(kept, notes)
    finally:
        prepared.unlink(missing_ok=True)


def _overwrite(path: Path, prepared: Path) -> None:
    """Replace the content of a store in one transaction, which others that have it open see."""
    with (
        contextlib.closing(read_only(prepared)) as opened,
        contextlib.closing(sqlite3.connect(path, timeout=BUSY_S)) as store,
    ):
        opened.backup(store)


def _keep_damaged(path: Path, kept: Path) -> None:
    """Keep a damaged store under another name. Its WAL goes first: SQLite would put it into the next file."""
    for end in _BESIDE:
        with contextlib.suppress(FileNotFoundError):
            path.with_name(path.name + end).replace(kept.with_name(kept.name + end))
    os.link(path, kept)
    sync_folder(path.parent)


def _replace(path: Path, prepared: Path) -> None:
    for end in _BESIDE:
        path.with_name(path.name + end).unlink(missing_ok=True)
    prepared.replace(path)
    sync_folder(path.parent)


@contextlib.contextmanager
def _no_flight(path: Path) -> Iterator[None]:
    """Hold the lock alone. Raises LotStoreError while a survey is flown."""
    opened = os.open(_lock_of(path), os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    try:
        try:
            fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            words = "a survey is flown, or another restore runs. Restore once the motors are off"
            raise LotStoreError(f"{path}: {words}") from None
        yield
    finally:
        os.close(opened)


def _lock_of(path: Path) -> Path:
    return path.with_name(f"{path.name}.lock")
