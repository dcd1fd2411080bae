"""Backup and restore of the lots' store while a daemon runs, and the lock that keeps a restore away from a flight.

The lock is flock(2) on a file beside the store: the kernel releases it when its holder ends, however it ends.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import sqlite3
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from hawk.lots.database import BUSY_S, check, copy, explained, free_name, migrate_file, read_only
from hawk.lots.tables import VERSION
from hawk.lots.values import LotStoreError
from hawk.runtime.files import sync_folder

_BESIDE: Final = ("-wal", "-shm")
"""Ends of the names of SQLite's files beside a store."""


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


def backup(path: Path, target: Path) -> None:
    """Write a copy of the store as one file. A daemon may write the store meanwhile. Raises LotStoreError."""
    if target.exists():
        raise LotStoreError(f"{target} is there already. Name a new file")
    if not path.exists():
        raise LotStoreError(f"{path} is not there: no survey was stored yet. Name the daemon's folder: --store DIR")
    check(path)
    with explained(target):
        target.parent.mkdir(parents=True, exist_ok=True)
        copy(path, target)
    check(target)


def restore(path: Path, source: Path) -> Path | None:
    """Put a backup in the place of the store, in one step; return the file that keeps the former content.

    A daemon that has the store open goes on with the new content. Raises LotStoreError: while a survey is flown, for a
    backup that is damaged or of a newer version, and where the disk cannot take it; the store is as before then.
    """
    version = check(source)
    if version > VERSION:
        raise LotStoreError(
            f"{source} is of version {version}, of a newer hawk-drone; this one knows version {VERSION}. "
            f"Install that hawk-drone first"
        )
    with explained(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        with _no_flight(path):
            return _restore(path, source, version)


def _restore(path: Path, source: Path, version: int) -> Path | None:
    prepared = path.with_name(f".{path.name}.restored")
    try:
        copy(source, prepared)
        if version < VERSION:
            migrate_file(prepared)
        if not path.exists():
            _replace(path, prepared)
            return None
        kept = free_name(path, "before-restore")
        try:
            check(path)
        except LotStoreError:
            _keep_damaged(path, kept)
            _replace(path, prepared)
        else:
            copy(path, kept)
            _overwrite(path, prepared)
        return kept
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
