"""Reads a picture of the ground that says where it lies, a GeoTIFF above all, in the squares of map tiles.

GDAL does the work, by rasterio: it knows every compression and every coordinate reference system of the field. It is
an extra (`hawk-drone[background]`), for a desk; a drone shows tiles without it.
"""

from __future__ import annotations

import contextlib
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hawk.background.tiling import TILE_PX, Bounds, Tile
from hawk.extras import remedy

MERCATOR: Final = "EPSG:3857"
MISSING: Final = f"rasterio is not installed, which reads GeoTIFF files: {remedy('background')}"
OPAQUE: Final = 255


class PictureError(Exception):
    """The picture cannot become a background; the text says why, and what to do."""


class GroundPicture:
    """An open picture. Made by `open_picture`."""

    def __init__(self, rasterio: Any, dataset: Any) -> None:
        self._rasterio = rasterio
        self._dataset = dataset
        self._has_alpha = rasterio.enums.ColorInterp.alpha in dataset.colorinterp
        with self._warped() as warped:
            self.bounds = Bounds(*warped.bounds)
            """Edges of the picture in Web Mercator."""
            self.metres_per_pixel = float(min(warped.res))
            """Of its own pixels, metres of the projection."""

    def read(self, tile: Tile) -> NDArray[np.uint8] | None:
        """Return a tile's pixels (256, 256, 4), red, green, blue and opacity; None where the picture shows nothing."""
        edges = tile.bounds
        transform = self._rasterio.transform.from_bounds(
            edges.west, edges.south, edges.east, edges.north, TILE_PX, TILE_PX
        )
        with self._warped(transform=transform, width=TILE_PX, height=TILE_PX) as warped:
            bands = np.asarray(warped.read(), np.uint8)
        colours, opacity = bands[:-1], bands[-1:]
        if not opacity.any():
            return None
        red_green_blue = np.repeat(colours[:1], 3, 0) if len(colours) < 3 else colours[:3]
        return np.ascontiguousarray(np.concatenate([red_green_blue, opacity]).transpose(1, 2, 0))

    def _warped(self, **place: Any) -> Any:
        return self._rasterio.vrt.WarpedVRT(
            self._dataset,
            crs=MERCATOR,
            resampling=self._rasterio.enums.Resampling.bilinear,
            add_alpha=not self._has_alpha,
            **place,
        )


@contextlib.contextmanager
def open_picture(path: Path) -> Iterator[GroundPicture]:
    """Open a picture. Raises PictureError when it is no picture, does not say where it lies, or has other pixels."""
    rasterio = _rasterio()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rasterio.errors.NotGeoreferencedWarning)
        try:
            dataset = rasterio.open(path)
        except rasterio.errors.RasterioIOError as error:
            raise PictureError(f"{path} cannot be read as a picture: {error}") from error
    with dataset:
        _check(path, rasterio, dataset)
        try:
            yield GroundPicture(rasterio, dataset)
        except rasterio.errors.RasterioError as error:
            raise PictureError(f"{path}: {error}") from error


def _check(path: Path, rasterio: Any, dataset: Any) -> None:
    if dataset.crs is None or dataset.transform.is_identity:
        raise PictureError(f"{path} does not say where it lies: georeference it, in QGIS for example")
    if rasterio.enums.ColorInterp.palette in dataset.colorinterp:
        raise PictureError(f"{path} has a palette of colours: gdal_translate -expand rgb {path} new.tif")
    if set(dataset.dtypes) != {"uint8"}:
        found = ", ".join(sorted(set(dataset.dtypes)))
        raise PictureError(f"{path} has {found} pixels, not 8 bits: gdal_translate -ot Byte -scale {path} new.tif")


def _rasterio() -> Any:
    try:
        import rasterio
        import rasterio.enums
        import rasterio.errors
        import rasterio.transform
        import rasterio.vrt
    except ImportError as error:
        raise PictureError(MISSING) from error
    return rasterio
