"""The drone's flight state (may it fly?) in a file that the daemon writes and other programs of this computer read.

The daemon locks the file (flock(2)) while it runs and writes that state several times a second. The kernel releases the
lock when the process ends, however it ends. So a reader can distinguish a daemon that runs, one that hangs and one that
ended, without a port, a token or a certificate. The folder is in memory (tmpfs): writing takes microseconds.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import logging
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

_LOG = logging.getLogger(__name__)

FILE: Final = "flight"
_LENGTH: Final = 128
"""Bytes of the file: a fixed length, so that a shorter text leaves nothing of a longer one."""


@dataclass(frozen=True, slots=True)
class FlightState:
    """``may_fly``: the motors are on, or nobody knows. ``at_s``: clock CLOCK_MONOTONIC, which all programs share."""

    may_fly: bool
    at_s: float


@dataclass(frozen=True, slots=True)
class FoundState:
    """The file as it was found: the state in it, None when there is none, and whether a daemon that runs holds it."""

    state: FlightState | None
    is_held: bool


class FlightStateFile:
    """The writing side. A fault of the file is logged and stops nothing: readers then take the drone for flying."""

    def __init__(self, folder: Path | None, monotonic: Callable[[], float] = time.monotonic) -> None:
        """``folder``: the folder that systemd made for this service (RuntimeDirectory), None without systemd."""
        self._path = None if folder is None else folder / FILE
        self._monotonic = monotonic
        self._descriptor: int | None = None
        self._is_reported = False

    def write(self, *, may_fly: bool) -> None:
        """Write the state, with the time. The first call that finds the file free makes and locks it."""
        if self._path is None or not self._holds(self._path):
            return
        assert self._descriptor is not None  # noqa: S101 - it holds the file
        text = json.dumps({"may_fly": may_fly, "at_s": self._monotonic()})
        with contextlib.suppress(OSError):  # the state grows old then, and counts for nothing
            os.pwrite(self._descriptor, text.encode().ljust(_LENGTH), 0)

    def _holds(self, path: Path) -> bool:
        """Make and lock the file unless it is held; a reader may have it locked for a moment."""
        if self._descriptor is not None:
            return True
        try:
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
            try:
                os.fchmod(descriptor, 0o644)  # everybody may read it, whatever the umask
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                os.close(descriptor)
                raise
        except OSError as error:
            if not self._is_reported:
                _LOG.warning("%s cannot be held, so no other version is switched to now: %s", path, error)
            self._is_reported = True
            return False
        self._descriptor = descriptor
        return True

    def close(self) -> None:
        """Release the file; the last state stays in it."""
        if self._descriptor is not None:
            os.close(self._descriptor)
            self._descriptor = None


def read_flight_state(folder: Path) -> FoundState:
    """Read the state in a folder, and look whether a daemon holds it. Raises OSError for a file that cannot be read."""
    try:
        descriptor = os.open(folder / FILE, os.O_RDONLY | os.O_CLOEXEC)
    except FileNotFoundError:
        return FoundState(None, is_held=False)
    try:
        is_held = _is_locked(descriptor)
        return FoundState(_parse(os.pread(descriptor, _LENGTH, 0)), is_held)
    finally:
        os.close(descriptor)


def _is_locked(descriptor: int) -> bool:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    return False


def _parse(data: bytes) -> FlightState | None:
    """Return the state, None for anything else. By hand: pydantic is not installed for Debian's Python."""
    try:
        found = json.loads(data)
    except ValueError:
        return None
    if not isinstance(found, dict):
        return None
    may_fly, at_s = found.get("may_fly"), found.get("at_s")
    if not isinstance(may_fly, bool) or not isinstance(at_s, float):
        return None
    return FlightState(may_fly, at_s)
