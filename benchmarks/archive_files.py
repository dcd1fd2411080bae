"""Time of the files of other programs: a Cloud Optimised GeoTIFF of 3 ha, and a GeoPackage of a hundred surveys."""

from __future__ import annotations

import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from sqlalchemy import Connection, select

from hawk.exports.files import export, export_all
from hawk.lots.storage.schema import SURVEY
from hawk.lots.survey.pictures import pictures_of
from hawk.model.lot_map import TILE_CELLS, EncodedTile, TileKey
from hawk.model.tile_picture import encode_picture

TILES: Final = 7
"""Tiles on a side: 179 m, 3.2 ha."""
PACKED: Final = 100
"""Surveys of the GeoPackage."""


@dataclass(frozen=True, slots=True)
class FileTimes:
    """Seconds, processor time: ``cog_s`` with occupancy and STAC item; ``gpkg_s`` with the stalls of each survey."""

    cog_s: float
    gpkg_s: float


def ground() -> dict[TileKey, EncodedTile]:
    """Return the mosaic of a lot of 3 ha: grain like asphalt's, with lines."""
    rng = np.random.default_rng(3)
    seen = np.full((TILE_CELLS, TILE_CELLS), 255, np.uint8)
    found = {}
    for row in range(-TILES // 2, TILES - TILES // 2 - 1):
        for column in range(-TILES // 2, TILES - TILES // 2 - 1):
            grain = rng.normal(90, 9, (TILE_CELLS, TILE_CELLS, 3))
            pixels = cv2.GaussianBlur(grain, (0, 0), 0.8).clip(0, 255).astype(np.uint8)
            pixels[::25, :] = 220
            found[row, column] = EncodedTile(1, encode_picture(pixels, seen))
    return found


def measure_files(connection: Connection, lot: str, store: Path) -> FileTimes:
    """Write both files of a lot of a store, and time them."""
    surveys = select(SURVEY.c.id).where(SURVEY.c.lot == lot).order_by(SURVEY.c.seq.desc())
    newest = [str(each) for each in connection.execute(surveys.limit(PACKED)).scalars()]
    pictures = pictures_of(store)
    pictures.write(newest[0], ground())
    with tempfile.TemporaryDirectory() as folder:
        began = time.process_time()
        export(connection, newest[0], pictures, Path(folder) / "lot.tif")
        cog = time.process_time() - began
        began = time.process_time()
        export_all(connection, newest, Path(folder) / "lot.gpkg")
        return FileTimes(cog, time.process_time() - began)
