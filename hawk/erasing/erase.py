"""One erasure: the rows, and the files beside them."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from hawk.config.sections import StoreSettings
from hawk.erasing.rows import Erased, emptied, erase_lot, erase_survey
from hawk.lots.database import check
from hawk.lots.pictures import pictures_of
from hawk.lots.store import lots_file
from hawk.lots.tables import VERSION
from hawk.lots.values import LotStoreError
from hawk.store.recordings import MARK, Recordings
from hawk.store.store_lock import StoreInUseError, held_store

JOURNALS: Final = "journal"
_COPIES: Final = ("version-*", "before-restore*", "damaged*")
"""Ends of the names of earlier copies of the store, which the program itself keeps."""


@dataclass(frozen=True, slots=True)
class Report:
    """Numbers of what was erased. ``copies``: earlier copies of the store, which hold everything."""

    surveys: int
    pictures: int
    recordings: int
    journals: int
    copies: int


def erase(settings: StoreSettings, *, lot: str | None, survey: str | None) -> Report:
    """Erase a lot or a survey; both None: everything. Raises NotFoundError, LotStoreError and OSError.

    Nothing is erased while a daemon uses the store: it would write what it holds again.
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
    parts = (pictures_of(path).folder, settings.directory / "recordings", settings.directory / JOURNALS)
    if path.is_file() or (is_everything and any(each.is_dir() for each in parts)):
        return
    if settings.lots is not None:
        raise LotStoreError(f"store.lots: {path} is no store; name the file that holds the lots")
    raise LotStoreError(f"--store: {settings.directory} is no store; name the folder that holds {path.name}")


def _one(settings: StoreSettings, path: Path, lot: str | None, survey: str | None) -> Report:
    if check(path) != VERSION:
        raise LotStoreError(f"{path} is of another version: start this hawk-drone once, and erase then")
    with emptied(path) as store:
        erased = erase_lot(store, lot) if lot is not None else erase_survey(store, survey or "")
    pictures = pictures_of(path)
    return Report(
        len(erased.surveys),
        sum(pictures.remove(each) for each in erased.surveys),
        _recordings(settings, erased),
        sum(_removed(settings.directory / JOURNALS / name) for name in erased.journals),
        _copies(path),
    )


def _everything(settings: StoreSettings, path: Path) -> Report:
    surveys = 0
    if path.is_file():
        with emptied(path) as store:
            surveys = int(store.execute("SELECT count(*) FROM survey").fetchone()[0])
    recordings = _files(settings.directory / "recordings", "*.mcap")
    journals = [each for each in (settings.directory / JOURNALS).glob("*") if each.is_dir()]
    report = Report(surveys, len(pictures_of(path).surveys()), len(recordings), len(journals), _copies(path))
    for end in ("", "-wal", "-shm", "-journal"):
        path.with_name(path.name + end).unlink(missing_ok=True)
    for folder in (pictures_of(path).folder, settings.directory / "recordings", settings.directory / JOURNALS):
        _removed(folder)
    return report


def _files(folder: Path, pattern: str) -> list[Path]:
    return [each for each in folder.glob(pattern) if each.is_file()] if folder.is_dir() else []


def _recordings(settings: StoreSettings, erased: Erased) -> int:
    """Remove the recordings of surveys, kept ones too, and those that name no survey: they may hold one of them."""
    folder = Recordings(settings)
    count = 0
    for one in folder.listed():
        named = folder.contents(one.name).survey
        if named in erased.journals or not named:
            (folder.folder / one.name).unlink()
            (folder.folder / one.name).with_suffix(MARK).unlink(missing_ok=True)
            count += 1
    return count


def _copies(path: Path) -> int:
    found = [each for pattern in _COPIES for each in path.parent.glob(f"{path.name}.{pattern}")]
    for each in found:
        each.unlink()
    return len(found)


def _removed(folder: Path) -> int:
    if not folder.is_dir():
        return 0
    shutil.rmtree(folder)
    return 1
