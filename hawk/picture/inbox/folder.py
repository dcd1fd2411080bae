"""The folder that others fill: drops in it that have stopped growing.

A drop is a sub-folder, or all files that lie in the folder itself. It has stopped growing when names, sizes and times
of change of its files were the same at two looks, ``settle_s`` apart at least. The time between looks is monotonic: a
clock that is set changes nothing. Nothing is asked of the system but to list folders, so that a disk behind NFS, SMB
or FUSE, which reports no events, does too.
"""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from hawk.store.inbox import PLACES, is_temporary

SURVEY: Final = "survey"
REPORT: Final = "report.txt"
"""Names in the folder of a flight: of the folder for the survey's files, and of the report in words."""
HEADING: Final = "hawk-drone inbox: "
"""Beginning of a report's first line, by which the folder of a flight that a person moved back is known."""
LOOSE: Final = ""
"""Name of the drop of all files that lie in the folder itself."""
SETTLE_S: Final = 120.0
"""Seconds without a change, by default: phones and docks pause between two pictures, and try again after a minute."""
ABANDONED_S: Final = 3600.0
"""Seconds without any change after which the others of a drop no longer wait for an unfinished file."""
_HIDDEN_COPY: Final = re.compile(r"^\.(?!_).*\.(jpe?g|tiff?|jp2|png|mp4|mov|mcap|srt|bin|tlog)(\.|$)", re.IGNORECASE)
"""Names under which rsync writes a picture; a name that begins with ``._`` is macOS's own."""

_JPEGS: Final = (".jpg", ".jpeg")
_BEGIN: Final = b"\xff\xd8"
_END: Final = b"\xff\xd9"
"""Markers of a JPEG's begin and end (ITU-T T.81, table B.1); neither occurs in the data of a picture."""
_TAIL_BYTES: Final = 65_536
"""Bytes at a file's end with the marker; some cameras write previews behind the picture, each with its own."""
_OF_SYSTEM: Final = frozenset(("Thumbs.db", "desktop.ini"))


@dataclass(frozen=True, slots=True, order=True)
class FileFacts:
    """A file by its path below the folder, its size in bytes and its time of change, ns."""

    path: str
    size: int
    changed: int


@dataclass(frozen=True, slots=True)
class Drop:
    """Files that arrived together. ``name``: of their sub-folder, `LOOSE` without one."""

    name: str
    files: tuple[FileFacts, ...] = field(repr=False)


@dataclass(slots=True)
class _Growth:
    """A drop as it was seen first like this. ``looks``: at which it was the same. ``is_cut``: a JPEG has no end; None:
    nobody looked.
    """

    files: tuple[FileFacts, ...]
    is_whole: bool
    since: float
    looks: int = 1
    is_cut: bool | None = None

    def has_settled(self, now: float, settle_s: float, root: Path) -> bool:
        """Return whether nothing of it was changed for long enough, at ``now``."""
        quiet_s = now - self.since
        if self.looks < 2 or quiet_s < settle_s:
            return False
        if self.is_cut is None:
            self.is_cut = any(_is_cut(root / file.path) for file in self.files)
        return (self.is_whole and not self.is_cut) or quiet_s >= ABANDONED_S


class Folder:
    """Looks at a folder again and again."""

    def __init__(self, path: Path, settle_s: float) -> None:
        """``settle_s``: real seconds without a change after which a drop is whole."""
        self.path = path
        self._settle_s = settle_s
        self._growing: dict[str, _Growth] = {}

    def settled(self, now: float) -> list[Drop]:
        """Return the drops that have stopped growing, the oldest first. ``now``: monotonic seconds. Raises OSError."""
        found = self._look()
        settled = []
        for name, (files, is_whole) in found.items():
            growth = self._growing.get(name)
            if growth is None or growth.files != files or growth.is_whole != is_whole:
                self._growing[name] = growth = _Growth(files, is_whole, now)
            else:
                growth.looks += 1
            if growth.has_settled(now, self._settle_s, self.path):
                settled.append((growth.since, Drop(name, tuple(file for file in files if not is_temporary(file.path)))))
        for name in self._growing.keys() - found.keys():
            del self._growing[name]
        return [drop for _, drop in sorted(settled, key=lambda one: (one[0], one[1].name)) if drop.files]

    def forget(self, name: str) -> None:
        """Take a drop as one that was just seen: what is in it waits for the whole time again."""
        self._growing.pop(name, None)

    def _look(self) -> dict[str, tuple[tuple[FileFacts, ...], bool]]:
        """Return the files of each drop, and whether none of them is being written. Raises OSError."""
        found: dict[str, list[FileFacts]] = {}
        for entry in _entries(self.path):
            if entry.is_dir(follow_symlinks=False):
                if entry.name not in PLACES and not entry.name.startswith("."):
                    files = _files(Path(entry.path), self.path)
                    own = is_returned(Path(entry.path))
                    found[entry.name] = [file for file in files if not (own and _is_own(file.path))]
            elif facts := _facts(entry, self.path):
                found.setdefault(LOOSE, []).append(facts)
        return {
            name: (tuple(sorted(files)), not any(is_temporary(file.path) for file in files))
            for name, files in found.items()
            if files
        }


def is_returned(folder: Path) -> bool:
    """Return whether a folder is a flight's that a person moved back: it has a report of the inbox."""
    try:
        with (folder / REPORT).open("rb") as file:
            return file.read(len(HEADING)) == HEADING.encode()
    except OSError:
        return False


def _is_own(path: str) -> bool:
    """Return whether a path is that of a report, or of a survey's file, in the folder of a flight."""
    _, name, *inner = path.split(os.sep)
    return name == SURVEY if inner else name == REPORT


def _files(folder: Path, root: Path) -> Iterator[FileFacts]:
    """Yield the files of a folder and of the folders in it; one that vanishes meanwhile is passed over."""
    try:
        entries = list(_entries(folder))
    except OSError:
        return
    for entry in entries:
        if entry.is_dir(follow_symlinks=False):
            if not entry.name.startswith("."):
                yield from _files(Path(entry.path), root)
        elif facts := _facts(entry, root):
            yield facts


def _entries(folder: Path) -> list[os.DirEntry[str]]:
    with os.scandir(folder) as entries:
        return list(entries)


def _facts(entry: os.DirEntry[str], root: Path) -> FileFacts | None:
    """Return the facts of a file; None for a hidden one, a link, a device, and a file that has vanished."""
    is_hidden = entry.name.startswith(".") or entry.name in _OF_SYSTEM
    if is_hidden and not _HIDDEN_COPY.search(entry.name):
        return None
    try:
        facts = entry.stat(follow_symlinks=False)
    except OSError:
        return None
    if not stat.S_ISREG(facts.st_mode):
        return None
    return FileFacts(os.path.relpath(entry.path, root), facts.st_size, facts.st_mtime_ns)


def _is_cut(path: Path) -> bool:
    """Return whether a file is a JPEG without its end: the copy of it has not ended, or was cut off."""
    if path.suffix.lower() not in _JPEGS:
        return False
    try:
        with path.open("rb") as file:
            if file.read(2) != _BEGIN:
                return False
            file.seek(max(2, file.seek(0, os.SEEK_END) - _TAIL_BYTES))
            return _END not in file.read(_TAIL_BYTES)
    except OSError:  # mapping it says why it cannot be read
        return False
