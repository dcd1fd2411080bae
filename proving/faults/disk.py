"""A small disk for the daemon's store, which can be filled (Linux, as root or in a user namespace of one's own)."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import os
from pathlib import Path
from typing import Final

SIZE: Final = "8g"
"""Room for all that a daemon wants; a file system in memory takes what is written, no more."""
_ATTEMPTS: Final = 50


class DiskError(Exception):
    """There is no such disk; the text says what to do."""


class OwnDisk:
    """A file system in memory at a folder."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._filler = folder / "filler"

    async def begin(self) -> None:
        """Put it there. Raises DiskError."""
        self._folder.mkdir(parents=True, exist_ok=True)
        if await _run("mount", "-t", "tmpfs", "-o", f"size={SIZE}", "tmpfs", str(self._folder)):
            raise DiskError("the store cannot have a disk of its own: run as root, or below unshare -Urm")

    async def fill(self) -> None:
        """Leave no byte: it shrinks to what is used, and a file takes the last page. Raises DiskError."""
        for _ in range(_ATTEMPTS):  # a daemon that writes meanwhile needs more than it did
            found = os.statvfs(self._folder)
            used = max(1, found.f_blocks - found.f_bfree) * found.f_frsize  # 0 would be no limit
            if not await _run("mount", "-o", f"remount,size={used}", str(self._folder)):
                break
        else:
            raise DiskError("the disk of the store cannot be made smaller")
        with contextlib.suppress(OSError), self._filler.open("ab", buffering=0) as file:
            while file.write(b"0"):
                pass

    def takes_a_byte(self) -> bool:
        """Return False when nothing can be written. Raises OSError for other reasons than a full disk."""
        try:
            (self._folder / "probe").write_bytes(b"0")
        except OSError as error:
            if error.errno != errno.ENOSPC:
                raise
            return False
        (self._folder / "probe").unlink()
        return True

    async def empty(self) -> None:
        """Give the room back."""
        await _run("mount", "-o", f"remount,size={SIZE}", str(self._folder))
        self._filler.unlink(missing_ok=True)

    async def end(self) -> None:
        """Take it away, with all that is on it."""
        await _run("umount", "-l", str(self._folder))


async def _run(*command: str) -> int:
    """Run a program quietly; return its status, 127 where there is no such program."""
    try:
        process = await asyncio.create_subprocess_exec(
            *command, stdout=asyncio.subprocess.DEVNULL, stderr=asyncio.subprocess.DEVNULL
        )
    except OSError:
        return 127
    return await process.wait()
