"""The files of a survey by the ends of their names."""

from __future__ import annotations

import contextlib
import errno
import io
import os
import tempfile
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final

import cv2
from sqlalchemy import Connection

from hawk.exports.formats import (
    ARCHIVE,
    CONTENT_TYPES,
    DATABASE,
    PICTURE,
    RASTER,
    SECTIONS_MAP,
    SECTIONS_TABLE,
    WRITTEN,
    kind_of,
)
from hawk.exports.geopackage import surveys_gpkg
from hawk.exports.ground import Ground, ground_of, lot_picture
from hawk.exports.kmz import survey_kmz
from hawk.exports.rasters import write_rasters
from hawk.exports.records import read_survey, read_surveys, survey_frame
from hawk.exports.section_files import sections_csv, sections_geojson
from hawk.exports.text_files import survey_csv, survey_geojson
from hawk.exports.values import ExportRecord
from hawk.lots.answers import SurveyGround, SurveyPlace
from hawk.lots.survey.pictures import PictureFolder
from hawk.lots.survey.private_ground import hidden_in
from hawk.lots.values import LotInputError, LotStoreError
from hawk.model.lot_map import CELL_M, TILE_CELLS
from hawk.runtime.files import replace_whole

TABLES: Final[Mapping[str, Callable[[ExportRecord], bytes]]] = {
    ".csv": survey_csv,
    ".geojson": survey_geojson,
    SECTIONS_TABLE: sections_csv,
    SECTIONS_MAP: sections_geojson,
    DATABASE: lambda survey: surveys_gpkg([survey]),
    ".kmz": survey_kmz,
}
"""Kinds of files, with the maker of those that need a survey alone."""


def shown_ground(connection: Connection, survey: ExportRecord, pictures: PictureFolder) -> Ground:
    """Return a survey's ground in the frame of its lot. Raises LotStoreError."""
    tiles = pictures.read(survey.survey, hidden_in(connection, survey.survey))
    return ground_of(survey, tiles, survey_frame(connection, survey.survey)[1])


def tiles_of(connection: Connection, survey_id: str, pictures: PictureFolder) -> SurveyGround:
    """Return where the tiles of a survey's picture lie. Raises NotFoundError, LotStoreError for a broken picture."""
    datum, move = survey_frame(connection, survey_id)
    return SurveyGround(
        datum=list(datum),
        place=SurveyPlace(north=move.north, east=move.east, turn=move.turn),
        cells=TILE_CELLS,
        cell_m=CELL_M,
        tiles=[list(key) for key in pictures.keys(survey_id)],
    )


def made(connection: Connection, survey_id: str, pictures: PictureFolder, suffix: str) -> tuple[str, bytes]:
    """Return a survey as a file, the type of its content first; the rasters come in one archive.

    Args:
        connection: The store.
        survey_id: Id of the survey.
        pictures: Pictures of the store's surveys.
        suffix: One of `CONTENT_TYPES`.

    Raises:
        NotFoundError: There is no such survey.
        LotStoreError: A picture is broken, there is nothing to draw, or rasterio is missing.
    """
    survey = read_survey(connection, survey_id)
    if suffix in TABLES:
        return CONTENT_TYPES[suffix], TABLES[suffix](survey)
    ground = shown_ground(connection, survey, pictures)
    if suffix == PICTURE:
        _, data = cv2.imencode(PICTURE, lot_picture(survey, ground))
        return CONTENT_TYPES[PICTURE], data.tobytes()
    if suffix != ARCHIVE:
        raise LotStoreError(f"kind: {suffix} must be one of {', '.join(WRITTEN)}")
    with tempfile.TemporaryDirectory(prefix="hawk-export-") as folder:
        written = write_rasters(survey, ground, Path(folder) / f"survey-{survey.survey[:8]}{RASTER}")
        out = io.BytesIO()
        with zipfile.ZipFile(out, "w") as archive:  # the rasters are compressed already
            for path in written:
                archive.write(path, path.name)
        return CONTENT_TYPES[ARCHIVE], out.getvalue()


def export(connection: Connection, survey_id: str, pictures: PictureFolder, path: Path) -> tuple[Path, ...]:
    """Write a survey as the file that the end of a name says; return the paths of all files written.

    A file that is there is replaced as a whole, or stays. Raises as `made`, and LotStoreError where it cannot be
    written.
    """
    suffix = kind_of(path.name)
    if suffix == RASTER:
        survey = read_survey(connection, survey_id)
        ground = shown_ground(connection, survey, pictures)
        with written_to(path), tempfile.TemporaryDirectory(prefix=".hawk-export-", dir=path.parent) as folder:
            written = write_rasters(survey, ground, Path(folder) / path.name)
            for each in written:
                os.replace(each, path.with_name(each.name))
            return tuple(path.with_name(each.name) for each in written)
    _, data = made(connection, survey_id, pictures, suffix)
    with written_to(path):
        return (replace_whole(path, data),)


def export_all(connection: Connection, surveys: Sequence[str], path: Path) -> tuple[Path, ...]:
    """Write several surveys as one GeoPackage; return its path.

    A file that is there is replaced as a whole, or stays. Raises NotFoundError, LotInputError for another kind of file,
    and LotStoreError where it cannot be written.
    """
    if path.suffix.lower() != DATABASE:
        raise LotInputError("--out", f"{path.name} holds one survey; several go into a {DATABASE}")
    data = surveys_gpkg(read_surveys(connection, surveys))
    with written_to(path):
        return (replace_whole(path, data),)


@contextlib.contextmanager
def written_to(path: Path, option: str = "--out") -> Iterator[None]:
    """Turn an error of the disk, while a file of a person's choice is written, into LotStoreError with the option.

    The store is open meanwhile: its own handler would blame the store's file.
    """
    try:
        yield
    except OSError as error:
        if error.errno in _FULL:
            words = f"{path}: no room is left on its disk; make room there, or name a file on another disk"
        else:
            reason = error.strerror or error
            words = f"{path} cannot be written: {reason}; name a file in a folder that this user may write"
        raise LotStoreError(f"{option}: {words}") from error


_FULL: Final = (errno.ENOSPC, errno.EDQUOT)
