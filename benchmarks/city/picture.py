"""A mosaic to be mapped: drawn lots, or places of a folder, side by side, written as a GeoTIFF strip by strip."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import cv2
import numpy as np
import rasterio
import rasterio.windows
from numpy.typing import NDArray
from rasterio.transform import from_origin

from benchmarks.perception.places import read_lots
from hawk.worlds.generate import WorldOptions, generate_world

Image = NDArray[np.uint8]
METRES: Final = 0.1
PIECE: Final = (600, 800)
"""Rows and columns of a piece, pixels."""
_DRAWN: Final = 6


def pieces(lots: Path | None) -> list[Image]:
    """Return pieces (H, W, 3), BGR: of the places of a folder, of drawn lots for None."""
    rows, columns = PIECE
    if lots is None:
        sides = (columns * METRES, columns * METRES), (rows * METRES, rows * METRES)
        options = WorldOptions(*sides, METRES, stalls=(20, 90), difficult=0)
        return [generate_world(seed, options).ground[:rows, :columns] for seed in range(1, _DRAWN + 1)]
    found = []
    for place in read_lots(lots):
        scale = place.metres_per_pixel / METRES
        image = np.asarray(cv2.resize(place.image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), np.uint8)
        high, wide = image.shape[:2]
        if high >= rows and wide >= columns:
            top, left = (high - rows) // 2, (wide - columns) // 2
            found.append(image[top : top + rows, left : left + columns])
    return found


def write_mosaic(path: Path, parts: Sequence[Image], side_m: float) -> Path:
    """Write a square mosaic of this side, metres, in UTM 31; return its path."""
    side = round(side_m / METRES)
    rows, columns = PIECE
    with rasterio.open(
        path, "w", driver="GTiff", width=side, height=side, count=3, dtype="uint8", crs="EPSG:32631",
        transform=from_origin(500_000, 5_770_000, METRES, METRES), tiled=True, compress="jpeg", photometric="YCBCR",
        jpeg_quality=90,
    ) as file:  # fmt: skip
        for k, top in enumerate(range(0, side, rows)):
            strip = np.concatenate([parts[(5 * k + j) % len(parts)] for j in range(-(-side // columns))], axis=1)
            strip = strip[: min(rows, side - top), :side, ::-1]
            window = rasterio.windows.Window(0, top, side, len(strip))
            file.write(np.moveaxis(strip, -1, 0), window=window)
    return path
