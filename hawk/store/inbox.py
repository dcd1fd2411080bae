"""The folder of an inbox: names in it that are its own, and files that programs write into it, within a quota.

A file is written under a temporary name, for which the inbox waits, and renamed once it is whole and on the disk: a cut
leaves no half file under its name. Nothing here follows a link out of the folder.
"""

from __future__ import annotations

import os
import re
import secrets
import shutil
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

MAPPING: Final = "mapping"
DONE: Final = "done"
FAILED: Final = "failed"
"""Folders for flights that are mapped now, that were, and that could not be."""
PLACES: Final = (MAPPING, DONE, FAILED)
LEAST_FREE: Final = 500_000_000
"""Bytes below which nothing is mapped or taken: the results of one flight's steps take some hundred megabytes."""
LONGEST_NAME: Final = 200
"""Bytes of a name: file systems take 255, with the end of a temporary name."""
COUNT_S: Final = 60.0
"""Real seconds for which a count of the folder holds, with what was written since: the inbox itself adds reports."""
_PARTIAL: Final = ".hawk.part"
_COMPARED: Final = 1024 * 1024
_TEMPORARY: Final = re.compile(
    r"\.(part|partial|filepart|tmp|temp|crdownload|download|incomplete|upload|uploading|swp|lock)$|~$|^~\$",
    re.IGNORECASE,
)
"""Names under which rclone, browsers, SFTP and WebDAV clients write a file before it is whole."""


class InboxFullError(Exception):
    """A file has no room in the inbox; the text names the limit and the remedy."""


class NameTakenError(Exception):
    """Another file of this name is in the flight."""


@dataclass(frozen=True, slots=True)
class InboxQuota:
    """Limits of a folder: bytes of one file, bytes and number of all files in it, mapped ones too."""

    largest: int
    most_bytes: int
    most_files: int


@dataclass(slots=True)
class _Count:
    """Bytes and number of files in a folder, at a monotonic time."""

    size: int
    files: int
    at: float


def is_temporary(path: str) -> bool:
    """Return True for the path of a file that another program is writing, by its name."""
    name = os.path.basename(path)
    return name.startswith(".") or _TEMPORARY.search(name) is not None


def name_fault(name: str) -> str:
    """Return why no file or flight in an inbox may be called so; "" for a name that may be used."""
    if not name.isprintable() or "/" in name or "\\" in name or not name.strip():
        return "must be a plain name: no folder, no / or \\, no control character"
    if len(name.encode()) > LONGEST_NAME:
        return f"is too long: {LONGEST_NAME} bytes at most"
    if name.casefold() in PLACES or is_temporary(name):
        return f"is taken: it may not be {', '.join(PLACES)}, begin with a full stop, or end as an unfinished file does"
    return ""


class InboxFolder:
    """A folder that files are written into. One thread uses it."""

    def __init__(
        self,
        path: Path,
        quota: InboxQuota,
        free: Callable[[Path], int] = lambda folder: shutil.disk_usage(folder).free,
        monotonic: Callable[[], float] = time.monotonic,
    ) -> None:
        """``free``: bytes left on the disk of a folder."""
        self.path = path
        self.quota = quota
        self._free = free
        self._monotonic = monotonic
        self._count: _Count | None = None
        self._open: dict[FileWriter, int] = {}

    def clear(self) -> None:
        """Remove files that a former program did not finish. Raises OSError."""
        for folder in (self.path, *(each for each in self.path.iterdir() if each.is_dir() and not each.is_symlink())):
            if folder.name not in PLACES:
                for part in folder.glob(f"*{_PARTIAL}"):
                    part.unlink(missing_ok=True)

    def begin(self, flight: str, name: str, size: int) -> FileWriter:
        """Return a new file of a flight, "" for the folder itself; its names have no `name_fault`.

        Raises InboxFullError, OSError: ELOOP or ENOTDIR where the flight is no folder of this one.
        """
        self._check_room(size)
        root = os.open(self.path, os.O_RDONLY | os.O_DIRECTORY)
        try:
            if flight:
                with suppress(FileExistsError):
                    os.mkdir(flight, 0o770, dir_fd=root)
            folder = os.open(flight or ".", os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW, dir_fd=root)
        finally:
            os.close(root)
        try:
            incoming = FileWriter(folder, name, size, self._ended)
        except OSError:
            os.close(folder)
            raise
        self._open[incoming] = size
        return incoming

    def _check_room(self, size: int) -> None:
        quota, count = self.quota, self._counted()
        waiting = sum(self._open.values())
        if count.files + len(self._open) >= quota.most_files:
            raise InboxFullError(
                f"The inbox holds {count.files} files, its limit is {quota.most_files} (inbox.most_files): "
                f"empty the folder {DONE}, or raise the limit."
            )
        if count.size + waiting + size > quota.most_bytes:
            raise InboxFullError(
                f"The inbox holds {_gb(count.size + waiting)} GB, its limit is {_gb(quota.most_bytes)} GB "
                f"(inbox.most_gb): empty the folder {DONE}, or raise the limit."
            )
        if self._free(self.path) - waiting - size < LEAST_FREE:
            raise InboxFullError("The disk of the inbox is full: make room there, then send the file again.")

    def _counted(self) -> _Count:
        """Return what lies in the folder, but for files that are being written."""
        now = self._monotonic()
        if self._count is None or now - self._count.at > COUNT_S:
            size = files = 0
            for parent, _, names in os.walk(self.path):
                for name in names:
                    with suppress(OSError):  # it went meanwhile
                        facts = os.lstat(os.path.join(parent, name))
                        if not name.endswith(_PARTIAL):
                            size, files = size + facts.st_size, files + 1
            self._count = _Count(size, files, now)
        return self._count

    def _ended(self, incoming: FileWriter, size: int) -> None:
        """Count a file that was written; ``size`` 0: it was dropped."""
        self._open.pop(incoming, None)
        if self._count is not None and size:
            self._count.size += size
            self._count.files += 1


class FileWriter:
    """A file of ``size`` bytes that is being written; `finish` or `drop` ends it."""

    def __init__(self, folder: int, name: str, size: int, ended: Callable[[FileWriter, int], None]) -> None:
        """``folder``: descriptor, which this closes. Raises OSError; the descriptor is then left open."""
        self._folder = folder
        self._name = name
        self._partial = f"{name}.{secrets.token_hex(4)}{_PARTIAL}"
        self._size = size
        self._ended = ended
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW
        self._file = os.fdopen(os.open(self._partial, flags, 0o660, dir_fd=folder), "wb")

    def write(self, data: bytes) -> None:
        """Add the next bytes. Raises OSError."""
        self._file.write(data)

    def finish(self) -> bool:
        """Give the file its name; one that is there with the same bytes stays, and the answer is False.

        Raises NameTakenError where it has other bytes, OSError; this one is then dropped.
        """
        try:
            self._file.flush()
            os.fsync(self._file.fileno())
            if self._is_there():
                self.drop()
                return False
            os.rename(self._partial, self._name, src_dir_fd=self._folder, dst_dir_fd=self._folder)
            os.fsync(self._folder)
        except (OSError, NameTakenError):
            self.drop()
            raise
        self._close(self._size)
        return True

    def _is_there(self) -> bool:
        """Return whether the same file has come before. Raises NameTakenError."""
        try:
            former = os.fdopen(os.open(self._name, os.O_RDONLY | os.O_NOFOLLOW, dir_fd=self._folder), "rb")
        except FileNotFoundError:
            return False
        except OSError as error:  # a folder, or a link
            raise NameTakenError(self._name) from error
        with former, os.fdopen(os.open(self._partial, os.O_RDONLY, dir_fd=self._folder), "rb") as own:
            while chunk := own.read(_COMPARED):
                if former.read(_COMPARED) != chunk:
                    raise NameTakenError(self._name)
            if former.read(1):
                raise NameTakenError(self._name)
        return True

    def drop(self) -> None:
        """Remove it; nothing happens to one that has ended."""
        if self._file.closed:
            return
        with suppress(OSError):
            os.unlink(self._partial, dir_fd=self._folder)
        self._close(0)

    def _close(self, size: int) -> None:
        with suppress(OSError):  # what a full disk did not take is dropped
            self._file.close()
        os.close(self._folder)
        self._ended(self, size)


def _gb(size: int) -> str:
    return f"{size / 1e9:.3g}"
