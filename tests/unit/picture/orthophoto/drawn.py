"""Orthophotos for tests: a drawn lot, written with a place on Earth in any system of coordinates."""

from __future__ import annotations

import functools
import os
from pathlib import Path
from typing import Any

import numpy as np
import pyproj
import rasterio
from numpy.typing import NDArray
from rasterio.transform import Affine

from hawk.lots.registration.georeference import about
from hawk.picture.orthophoto.source import Orthophoto, open_orthophoto
from hawk.picture.orthophoto.tile_detector import TileDetector
from hawk.picture.values import PictureSurvey
from hawk.worlds.generate import WorldOptions, generate_world

Image = NDArray[np.uint8]
UTM = "EPSG:32631"
HERE = (52.1, 5.2)
"""Latitude and longitude of the pictures' middle."""
METRES = 0.1


@functools.cache
def lot_picture() -> Image:
    """Return a drawn lot of 70 by 60 m at `METRES` a pixel, BGR."""
    options = WorldOptions((70, 70), (60, 60), METRES, stalls=(20, 90), difficult=0)
    return generate_world(2, options).ground


@functools.cache
def detector() -> TileDetector:
    return TileDetector.load()


def placed(crs: str, columns: int, rows: int, *, metres: float = METRES, turn: float = 0.0) -> Affine:
    """Return the georeference of a picture about `HERE`, turned (degrees), that is fitted to the ground."""
    latitude, longitude = HERE
    plane = f"+proj=aeqd +lat_0={latitude} +lon_0={longitude} +datum=WGS84"
    to_crs = pyproj.Transformer.from_crs(plane, crs, always_xy=True)
    x, y = (each.reshape(-1) for each in np.meshgrid(np.linspace(-0.5, 0.5, 5), np.linspace(-0.5, 0.5, 5)))
    east, north, angle = x * columns * metres, -y * rows * metres, np.radians(turn)
    moved = np.column_stack(
        to_crs.transform(
            east * np.cos(angle) - north * np.sin(angle),
            east * np.sin(angle) + north * np.cos(angle),
        )
    )
    middle = moved.mean(axis=0)
    fit = np.linalg.lstsq(np.column_stack([x * columns, y * rows]), moved - middle, rcond=None)[0]
    (a, d), (b, e) = fit
    c, f = middle - (a * columns / 2 + b * rows / 2, d * columns / 2 + e * rows / 2)
    return Affine(a, b, c, d, e, f)


def write(
    path: Path,
    bands: NDArray[Any],
    transform: Affine | None = None,
    crs: str | None = UTM,
    **profile: Any,
) -> Path:
    """Write bands (N, H, W) as a GeoTIFF; ``transform`` None: about `HERE`."""
    count, rows, columns = bands.shape
    options = {"driver": "GTiff", "tiled": True, "blockxsize": 256, "blockysize": 256, "crs": crs, **profile}
    options["transform"] = transform or placed(crs or UTM, columns, rows)
    with rasterio.open(path, "w", count=count, height=rows, width=columns, dtype=bands.dtype, **options) as file:
        file.write(bands)
    os.utime(path, (1_700_000_000, 1_700_000_000))
    return path


def rgb(image: Image) -> Image:
    """Return a BGR picture as bands (3, H, W)."""
    return np.ascontiguousarray(np.moveaxis(image[..., ::-1], -1, 0))


def lot_file(folder: Path, **profile: Any) -> Path:
    return write(folder / "lot.tif", rgb(lot_picture()), **profile)


def blank(folder: Path, rows: int = 40, columns: int = 60, **options: Any) -> Path:
    """Write a small grey picture."""
    return write(folder / "blank.tif", np.full((3, rows, columns), 120, np.uint8), **options)


def opened_blank(folder: Path, rows: int = 40, columns: int = 60, **options: Any) -> Orthophoto:
    return open_orthophoto(blank(folder, rows, columns, **options))


def corners_m(mapped: PictureSurvey) -> NDArray[np.float64]:
    """Return the stalls' corners (N, 4, 2) as (north, east) metres about `HERE`."""
    corners = np.array([stall.corners for stall in mapped.survey.stalls], np.float64).reshape(-1, 2)
    return about(HERE, corners)[:, :2].reshape(-1, 4, 2)
