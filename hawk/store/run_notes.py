"""Notes for the next start, in this computer's memory: the starts in the air, and the flight so far.

The second witness of the flight journal. It outlives the program and needs no disk, which may be full, read-only or
broken; a boot of the computer ends it. A write takes microseconds, so it is done before anything else goes on.
"""

from __future__ import annotations

import contextlib
import hashlib
import logging
import os
import stat
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from pydantic import TypeAdapter, ValidationError

from hawk.model.moment import Moment
from hawk.model.operation import FlightSoFar

_LOG = logging.getLogger(__name__)

SHARED_MEMORY: Final = Path("/dev/shm")  # noqa: S108 - a folder of our own in it is used, if it is ours
"""Every user's folder in memory (shm_overview(7))."""


@dataclass(frozen=True, slots=True)
class Notes:
    """``starts_in_air``: oldest first. ``flight``: the flight under way, of ``vehicle_id``; None on the ground."""

    starts_in_air: tuple[Moment, ...] = ()
    flight: FlightSoFar | None = None
    vehicle_id: int | None = None


_EMPTY: Final = Notes()
_NOTES: Final = TypeAdapter(Notes)


class RunNotes:
    """The notes of one store. A fault of the file is logged, shows in `works`, and stops nothing."""

    def __init__(self, path: Path | None) -> None:
        """Read the file. None: there is no folder in memory."""
        self._path = path
        self._is_reported = path is None
        self.works = path is not None
        """False: the notes could not be written, or not be read at the start: a start may be missing among them."""
        self.notes = _EMPTY if path is None else self._read(path)
        """The notes as read, then as last put."""
        self._was_read = self.works

    def put(self, notes: Notes) -> None:
        """Replace the notes. Notes that say nothing leave no file."""
        self.notes = notes
        if self._path is None:
            return
        try:
            _replace(self._path, notes)
        except OSError as error:
            self._fail(error.strerror or str(error))
        else:
            self.works = self._was_read  # what could not be read then is missing still

    def _read(self, path: Path) -> Notes:
        try:
            return _NOTES.validate_json(path.read_bytes())
        except FileNotFoundError:
            return _EMPTY
        except OSError as error:
            self._fail(error.strerror or str(error))
        except ValidationError as error:
            self._fail(f"{error.error_count()} errors in its text")
        return _EMPTY

    def _fail(self, reason: str) -> None:
        self.works = False
        if not self._is_reported:
            _LOG.warning(
                "%s cannot be used, so starts in the air are counted on the disk alone: %s", self._path, reason
            )
        self._is_reported = True


def notes_file(store: Path, environment: Mapping[str, str], shared: Path = SHARED_MEMORY) -> Path | None:
    """Return the file of a store's notes, in a folder in memory that only this user may write; None without one.

    The first that there is: the folder that systemd made for the service (RuntimeDirectory), that of the user's session
    (XDG_RUNTIME_DIR), one of our own in the shared memory.
    """
    name = f"starts-{hashlib.sha256(os.fsencode(store.resolve())).hexdigest()[:16]}.json"
    service = environment.get("RUNTIME_DIRECTORY", "").split(":")[0]
    if service:
        return Path(service) / name
    session = environment.get("XDG_RUNTIME_DIR", "")
    for folder in (Path(session) / "hawk-drone" if session else None, shared / f"hawk-drone-{os.getuid()}"):
        if folder is not None and _is_ours(folder):
            return folder / name
    return None


def _is_ours(folder: Path) -> bool:
    """Make the folder; return True when it is this user's and nobody else may write it."""
    try:
        with contextlib.suppress(FileExistsError):
            folder.mkdir(mode=0o700)
        found = folder.lstat()
    except OSError:
        return False
    return stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & 0o022


def _replace(path: Path, notes: Notes) -> None:
    """Replace the file in one step: a program that is killed meanwhile leaves the old one. Raises OSError."""
    if notes == _EMPTY:
        path.unlink(missing_ok=True)
        return
    partial = path.with_suffix(".partial")
    partial.write_bytes(_NOTES.dump_json(notes))
    partial.rename(path)
