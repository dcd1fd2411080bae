"""One erasure: the files first, and the rows that name them last.

So an error or an interrupt leaves rows by which the same command finds the rest.
"""

from __future__ import annotations

import contextlib
import glob
import shutil
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from hawk.config.sections import StoreSettings
from hawk.lots.storage.database import check, make
from hawk.lots.storage.erasure import (
    Found,
    counted,
    emptied,
    erase_rows,
    found_lot,
    found_survey,
    ids_in,
    note_erased,
)
from hawk.lots.storage.schema import VERSION
from hawk.lots.store import lots_file
from hawk.lots.survey.pictures import pictures_of
from hawk.lots.values import LotStoreError
from hawk.store.recording_request import RecordingRequest
from hawk.store.recording_requests import RecordingRequests
from hawk.store.recordings import MARK, SUFFIX, Recordings, survey_of
from hawk.store.store_lock import StoreInUseError, held_store

JOURNALS: Final = "journal"
_COPIES: Final = ("{}.version-*", "{}.before-restore*", "{}.damaged*", ".{}.*", "..{}.*")
"""Names of earlier copies of the store, which the program itself keeps, and of copies that are half written."""


@dataclass(frozen=True, slots=True)
class Report:
    """Numbers of what was erased. ``copies``: earlier copies of the store, which hold everything."""

    surveys: int
    pictures: int
    recordings: int
    journals: int
    copies: int


def erase(settings: StoreSettings, *, lot: str | None, survey: str | None) -> Report:
    """Erase a lot or a survey; both None: everything. Raises NotFoundError and LotStoreError.

    After an error of the disk the same command erases the rest. Nothing is erased while a daemon uses the store: it
    would write what it holds again.
    """
    path = lots_file(settings.directory, settings.lots)
    _check_is_store(settings, path, is_everything=lot is None and survey is None)
    try:
        with held_store(settings.directory, {"doing": "erase"}):
            if lot is None and survey is None:
                return _everything(settings, path)
            return _one(settings, path, lot, survey)
    except StoreInUseError as error:
        raise LotStoreError(f"{error}: stop it first (systemctl stop hawk-drone)") from error


def _check_is_store(settings: StoreSettings, path: Path, *, is_everything: bool) -> None:
    """Refuse a folder that holds nothing to erase: a name with a mistake would be said to be erased.

    Raises LotStoreError.
    """
    parts = (pictures_of(path).folder, Recordings(settings).folder, settings.directory / JOURNALS)
    if path.is_file() or (is_everything and any(each.is_dir() for each in parts)):
        return
    if settings.lots is not None:
        raise LotStoreError(f"store.lots: {path} is no store; name the file that holds the lots")
    raise LotStoreError(f"--store: {settings.directory} is no store; name the folder that holds {path.name}")


def _one(settings: StoreSettings, path: Path, lot: str | None, survey: str | None) -> Report:
    if check(path) != VERSION:
        raise LotStoreError(f"{path} is of another version: start this hawk-drone once, and erase then")
    with emptied(path) as store:
        found = found_lot(store, lot) if lot is not None else found_survey(store, survey or "")
        report = _files_of(settings, path, found)
        erase_rows(store, found)
    return report


def _files_of(settings: StoreSettings, path: Path, found: Found) -> Report:
    """Remove the files of surveys: pictures, recordings, journals and copies of the store."""
    pictures = pictures_of(path)
    with _repeatable(pictures.folder):
        shown = sum(pictures.remove(each) for each in found.ids)
    folder = Recordings(settings)
    with _repeatable(folder.folder):
        asked = RecordingRequests(folder, settings)
        came, requests = asked.origins(), asked.folders_of(found.ids)
    recordings = [each for each in _recordings(settings) if _is_of(found, each, came.get(each.name, ()))]
    journals = [each for each in _journals(settings) if each.name in found.journals]
    _remove(_with_marks(recordings))
    _remove([*requests, *journals])
    return Report(len(found.surveys), shown, len(recordings), len(journals), _without_copies(path))


def _is_of(found: Found, recording: Path, requests: Sequence[RecordingRequest]) -> bool:
    """Return whether a recording may hold one of the surveys. ``requests``: those for which it came.

    One that came is of the surveys of its requests alone: journals of two drones may have one name.
    """
    if requests:
        return any(each.survey in found.ids for each in requests)
    return survey_of(recording) in {"", *found.journals}


def _everything(settings: StoreSettings, path: Path) -> Report:
    surveys, erased = counted(path) if path.is_file() else 0, ids_in(path)
    pictures, recordings, journals = pictures_of(path), _recordings(settings), _journals(settings)
    report = Report(surveys, len(pictures.surveys()), len(recordings), len(journals), _without_copies(path))
    _remove([pictures.folder, Recordings(settings).folder, settings.directory / JOURNALS])
    beside = [path.with_name(path.name + end) for end in ("-wal", "-shm", "-journal")]
    if erased:
        _remove(beside)
        make(path, lambda store: note_erased(store, erased))
    else:
        _remove([*beside, path])
    return report


def _recordings(settings: StoreSettings) -> list[Path]:
    """Return every recording, whatever its name: one that a person renamed holds the same pictures."""
    folder = Recordings(settings).folder
    with _repeatable(folder):
        return sorted(each for each in folder.glob(f"*{SUFFIX}") if each.is_file())


def _journals(settings: StoreSettings) -> list[Path]:
    folder = settings.directory / JOURNALS
    with _repeatable(folder):
        return sorted(each for each in folder.glob("*") if each.is_dir())


def _with_marks(recordings: Iterable[Path]) -> Iterator[Path]:
    """Yield each recording behind its mark: a mark that an interrupt left alone would stay."""
    for each in recordings:
        yield each.with_suffix(MARK)
        yield each


def _without_copies(path: Path) -> int:
    """Remove the copies of a store, and return the number of those that were whole."""
    name = glob.escape(path.name)
    with _repeatable(path.parent):
        found = [each for pattern in _COPIES for each in path.parent.glob(pattern.format(name)) if not each.is_dir()]
    _remove(found)
    return sum(not each.name.startswith(".") for each in found)


def _remove(paths: Iterable[Path]) -> None:
    """Remove files and folders, those that are there. Raises LotStoreError."""
    for path in paths:
        with _repeatable(path):
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path)
            else:
                path.unlink(missing_ok=True)


@contextlib.contextmanager
def _repeatable(path: Path) -> Iterator[None]:
    """Turn an error of the disk into LotStoreError: the file, what stays, and the remedy."""
    try:
        yield
    except OSError as error:
        named = Path(str(error.filename))
        words = "It stays, with every row of the store. Look at disk and rights of the folder, and run this again"
        raise LotStoreError(f"{named if named.is_absolute() else path}: {error.strerror or error}. {words}") from error
