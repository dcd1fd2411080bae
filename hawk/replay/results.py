"""Files of a recording: they appear whole, in a new folder, or not at all."""

from __future__ import annotations

import contextlib
import errno
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Final

from hawk.replay.flight import ReplayError
from hawk.results import stall_files
from hawk.results.survey_map import Made, SurveyMap

if TYPE_CHECKING:  # vision takes half a second to load
    from hawk.replay.process import Processed

SPARE_BYTES: Final = 50_000_000
"""Bytes that stay free on the disk."""
_MB: Final = 1_000_000


def free_of(folder: Path) -> int:
    """Return the bytes that are free on a folder's disk. Raises OSError."""
    return shutil.disk_usage(folder).free


@contextlib.contextmanager
def new_folder(folder: Path, size: int = 0, free_bytes: Callable[[Path], int] = free_of) -> Iterator[Path]:
    """Give a folder beside, which becomes ``folder`` at the end; on an error nothing is left of it.

    ``size``: bytes that will be written. Raises ReplayError: the folder is not empty, cannot be written, or the disk is
    full.
    """
    temporary = folder.with_name(f".{folder.name}.unfinished")
    try:
        if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            raise ReplayError(f"{folder} is there and not empty: name a new folder")
        free = free_bytes(folder.parent)
        if free < size + SPARE_BYTES:
            needed = (size + SPARE_BYTES) // _MB
            raise ReplayError(f"{folder.parent}: {free // _MB} MB are free, {needed} are needed: delete old files")
        shutil.rmtree(temporary, ignore_errors=True)
        temporary.mkdir()
        try:
            yield temporary
            temporary.replace(folder)
        finally:
            shutil.rmtree(temporary, ignore_errors=True)
    except OSError as error:
        full = error.errno in (errno.ENOSPC, errno.EDQUOT)
        remedy = "delete old files, or name a folder on another disk" if full else "name a folder that you may write"
        raise ReplayError(f"{folder}: {error.strerror or error}; {remedy}") from error


def write_map(folder: Path, processed: Processed, survey: str) -> None:
    """Write ``stalls.csv``, ``stalls.geojson`` and ``map.png`` of the map that was made, as a survey's results.

    Raises ReplayError.
    """
    if processed.datum is None:
        raise ReplayError("the recording holds no place of the map's origin: --out has nothing to write; leave it out")
    with new_folder(folder) as new:
        stall_files.write_map(new, SurveyMap.of(processed.datum, processed.final), Made.now(survey))
