"""One daemon a store: a lock (flock(2)) on the store's folder, and a file that names who holds it.

The kernel releases the lock when the process ends, however it ends. The folder itself is locked: that needs no file, so
a full or read-only disk does not matter. The file is for words only.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import json
import logging
import os
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

_LOG = logging.getLogger(__name__)

FILE: Final = "running.json"
WAIT_S: Final = 1.0
"""Real seconds for which a start waits for the run before to end."""
_AGAIN_S: Final = 0.05
_HELD: Final = (errno.EWOULDBLOCK, errno.EACCES)


class StoreInUseError(Exception):
    """Another program works on this store; the text names it."""


@contextlib.contextmanager
def held_store(folder: Path, about: Mapping[str, str], wait_s: float = WAIT_S) -> Iterator[None]:
    """Hold a store's lock; its folder is made. Raises StoreInUseError.

    A folder that cannot be made or locked (a file system without locks) is logged and stops nothing.

    Args:
        folder: The store.
        about: What the next one says about this program.
        wait_s: Real seconds to wait for another one to end.
    """
    descriptor = _lock(folder, wait_s)
    try:
        if descriptor is not None:
            with contextlib.suppress(OSError):
                (folder / FILE).write_text(json.dumps({**about, "pid": os.getpid()}))
        yield
    finally:
        if descriptor is not None:
            with contextlib.suppress(OSError):
                (folder / FILE).unlink()
            os.close(descriptor)


def _lock(folder: Path, wait_s: float) -> int | None:
    """Return a descriptor that holds the lock; None where there can be none. Raises StoreInUseError."""
    descriptor = None
    try:
        folder.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        deadline = time.monotonic() + wait_s
        while not _try(descriptor):
            if time.monotonic() >= deadline:
                raise StoreInUseError(f"{folder} is in use by {holder(folder)}")
            time.sleep(_AGAIN_S)
    except BaseException as error:
        if descriptor is not None:
            os.close(descriptor)
        if not isinstance(error, OSError):
            raise
        _LOG.warning("%s cannot be locked: %s. Start no second daemon on it", folder, error.strerror or error)
        return None
    return descriptor


def _try(descriptor: int) -> bool:
    """Return False while another program holds the lock. Raises OSError where there are no locks."""
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno in _HELD:
            return False
        raise
    return True


def holder(folder: Path) -> str:
    """Return words for the program that holds a store."""
    try:
        found: Any = json.loads((folder / FILE).read_text())
        process = int(found["pid"])
    except (OSError, ValueError, KeyError, TypeError):
        return "another hawk-drone"
    known = ", ".join(f"{name} {value}" for name, value in sorted(found.items()) if name != "pid")
    return f"another hawk-drone (process {process}{', ' if known else ''}{known})"
