"""The folder of a survey by pictures: whether what it holds is hawk's, and of which source, so that a run may go on.

`SOURCE` in it keeps the path of the source, and names, sizes and times of change of its pictures. The contents decide:
a source that shares a picture with the work is the same one, whether it grew or moved. The path alone does not: a
card's folder or film keeps its path when the card is emptied and flown with again. Only a picture file counts by its
path too, because an orthophoto that is exported again, and a VRT of more tiles, are other bytes of the same ground. A
copy whose files have other times counts as another source: the results that are kept are of no use to it either.

`SOURCE` keeps digests of the private areas, too, of a file and of a store: the pictures in the folder lack that ground,
or show it.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hawk.runtime.files import replace_whole
from hawk.runtime.late import late

if TYPE_CHECKING:
    from shapely import Polygon

    from hawk.formats.remote_raster import RemoteRaster
    from hawk.picture import values
else:  # the command line checks its options without numpy
    values = late("hawk.picture.values")

WORK: Final = "work"
"""Name of the folder of the results of each step, in the folder of a survey by photographs or a film."""
WINDOWS: Final = "windows"
FAILURES: Final = "failures"
"""Names of the folders of results, and of failures, in the folder of a survey by an orthophoto."""
REPORT: Final = "report.json"
SOURCE: Final = "source.json"
"""Names of the files that say what was found, and of which source the work is."""
_STORED: Final = "stored_private"
"""Key of the digest of private ground of a store's lots in `SOURCE`."""
_OURS: Final = {WORK, WINDOWS, FAILURES, SOURCE, "store"}
ORTHOPHOTOS: Final = (".tif", ".tiff", ".vrt", ".png", ".jpg", ".jpeg", ".jp2")
"""Endings of a source that is one picture."""
_PICTURES: Final = (".jpg", ".jpeg", ".tif", ".tiff")
_WITHIN: Final = (".", "images", "odm_orthophoto")
"""Folders in which a folder of photographs and a WebODM project hold their pictures."""
_MOST_KEPT: Final = 1000
"""Pictures by which a source is known again; one of them is enough."""
_KEPT: Final = re.compile(r"\.?[a-z]+-[0-9a-f]{40}(\.part)?")


def is_ours(folder: Path) -> bool:
    """Return whether a run may go on in a folder: it is not there, is empty, or holds work or a report of hawk."""
    if not folder.is_dir():
        return not folder.exists()
    names = {entry.name for entry in folder.iterdir() if not entry.name.startswith(".")}
    if names <= _OURS or {WINDOWS, FAILURES} <= names:
        return True
    return _reported(folder / REPORT, "program").startswith("hawk-drone ") or _holds_steps(folder / WORK)


@dataclass(frozen=True, slots=True)
class WorkSource:
    """Source of a folder's work: its path, and (name, bytes, ns of its change) of its pictures."""

    path: Path
    pictures: frozenset[tuple[str, int, int]]

    @classmethod
    def of(cls, source: Path | RemoteRaster) -> WorkSource:
        """Return that of a file, a folder or a raster of a server. Raises OSError where it cannot be read."""
        if not isinstance(source, Path):
            return cls(Path(str(source)), frozenset())
        if not source.is_dir():
            return cls(source.resolve(), frozenset([_facts(source)]))
        folders = [source / name for name in _WITHIN]
        entries = (entry for folder in folders if folder.is_dir() for entry in folder.iterdir())
        pictures = (entry for entry in entries if entry.suffix.lower() in _PICTURES and entry.is_file())
        return cls(source.resolve(), frozenset(_facts(each) for each in pictures))

    @classmethod
    def kept_in(cls, folder: Path) -> WorkSource | None:
        """Return that of a folder's work; None where the folder does not say it."""
        with _unreadable():
            values = json.loads((folder / SOURCE).read_bytes())
            pictures = frozenset((str(name), int(size), int(time)) for name, size, time in values["pictures"])
            return cls(Path(values["source"]), pictures)
        return None

    def is_same(self, other: WorkSource) -> bool:
        """Return whether both are one source, by what the module says of it."""
        if self.pictures & other.pictures:
            return True
        is_picture = self.path.suffix.lower() in ORTHOPHOTOS and not self.path.is_dir()
        return is_picture and self.path == other.path

    def values(self) -> dict[str, Any]:
        """Return it as JSON has it."""
        return {"source": str(self.path), "pictures": sorted(self.pictures)[:_MOST_KEPT]}


def other_source(folder: Path, source: Path | RemoteRaster) -> str | None:
    """Return the name of the source whose work a folder holds where ``source`` is another one, else None."""
    kept = WorkSource.kept_in(folder)
    if kept is None:
        name = _reported(folder / REPORT, "survey_source").partition(" ")[2]
        return None if name in ("", name_of(source)) else name
    try:
        return None if kept.is_same(WorkSource.of(source)) else kept.path.name
    except OSError:  # mapping it says why it cannot be read
        return None


def name_of(source: Path | RemoteRaster) -> str:
    """Return the name of a source, that of the file itself where it is a link."""
    return source.resolve().name if isinstance(source, Path) else source.name


def other_private(folder: Path, private: Path | None) -> str:
    """Return why work in a folder cannot go on with private areas as of `kept_source`; "" where it can, or has none."""
    with _unreadable():
        kept = json.loads((folder / SOURCE).read_bytes()).get("private")
        digest = _digest_of(private)
        if kept == digest:
            return ""
        if digest is None:
            return f"{folder} leaves private ground out; name the same file again, or another folder by --out"
        if kept is None:
            return f"the pictures in {folder} show that ground; name another folder by --out"
        return f"{folder} leaves other ground out; name that file again, or another folder by --out"
    return ""


def keep_stored(folder: Path, areas: Iterable[Polygon]) -> None:
    """Keep which private ground of a store's lots the work in a folder leaves out, where `kept_source` is in charge.

    ``areas``: those that touch the pictures, in any order. Raises PictureError where the work that is there shows it,
    or left other ground out: nothing is changed then.
    """
    parts = sorted(area.wkb for area in areas)
    digest = hashlib.sha256(b"".join(parts)).hexdigest() if parts else None
    try:
        content = json.loads((folder / SOURCE).read_bytes())
    except FileNotFoundError:
        return
    kept = content.get(_STORED)
    if kept == digest:
        return
    if digest is None:
        raise values.PictureError(
            f"--store: {folder} leaves private ground of a store's lots out; name that store again, or another folder "
            "by --out"
        )
    if kept is not None or any((folder / name).is_dir() for name in (WORK, WINDOWS)):
        raise values.PictureError(
            f"--store: the pictures in {folder} were made with other private ground than the store's lots have there "
            "now; name another folder by --out"
        )
    try:
        replace_whole(folder / SOURCE, json.dumps({**content, _STORED: digest}, ensure_ascii=False).encode())
    except OSError as error:
        raise values.PictureError(f"--out: {values.cannot_write(folder / SOURCE, error)}") from error


@contextlib.contextmanager
def kept_source(folder: Path, source: Path | RemoteRaster, private: Path | None = None) -> Iterator[None]:
    """Keep in a folder what source its work is of, from before the work; where none was done, it goes again.

    ``private``: file of areas that no picture shows. Raises PictureError where the folder cannot be written.
    """
    made = [each for each in (folder, *folder.parents) if not each.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        content = {**WorkSource.of(source).values(), "private": _digest_of(private)}
        with _unreadable():
            content[_STORED] = json.loads((folder / SOURCE).read_bytes())[_STORED]
        replace_whole(folder / SOURCE, json.dumps(content, ensure_ascii=False).encode())
    except OSError as error:
        raise values.PictureError(f"--out: {values.cannot_write(Path(error.filename or folder), error)}") from error
    try:
        yield
    finally:
        if [entry.name for entry in folder.iterdir()] == [SOURCE]:
            (folder / SOURCE).unlink()
            with contextlib.suppress(OSError):  # another run works in one of them
                for each in made:
                    each.rmdir()


def _digest_of(file: Path | None) -> str | None:
    """Return the SHA-256 of a file, None without one. Raises OSError."""
    return None if file is None else hashlib.sha256(file.read_bytes()).hexdigest()


def _facts(path: Path) -> tuple[str, int, int]:
    facts = path.stat()
    return path.name, facts.st_size, facts.st_mtime_ns


def _reported(path: Path, key: str) -> str:
    """Return a text of a report, "" where it says none."""
    with _unreadable():
        return str(json.loads(path.read_bytes())[key])
    return ""


def _unreadable() -> contextlib.suppress:
    """Pass over a file that cannot be read, or holds something else."""
    return contextlib.suppress(OSError, ValueError, KeyError, TypeError)


def _holds_steps(folder: Path) -> bool:
    return folder.is_dir() and any(_KEPT.fullmatch(entry.name) for entry in folder.iterdir())
