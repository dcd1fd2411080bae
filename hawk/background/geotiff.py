"""Reads a picture of the ground that says where it lies, a GeoTIFF above all, in the squares of map tiles.

GDAL does the work, by rasterio: it knows every compression and every coordinate reference system of the field. It is
an extra (`hawk-drone[background]`), for a desk; a drone shows tiles without it.
"""

from __future__ import annotations

import contextlib
import math
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hawk.background.tiling import HALF_M, TILE_PX, Bounds, Tile
from hawk.runtime.extras import remedy

MERCATOR: Final = "EPSG:3857"
MISSING: Final = f"rasterio is not installed, which reads GeoTIFF files: {remedy('background')}"
OPAQUE: Final = 255
_SAVE: Final = "save it in a system of the Earth, EPSG:3857 or a UTM zone for example (QGIS: Export, Save as)"
_BAND_NAMES: Final = (
    frozenset({"red", "r", "rouge", "rot"}),
    frozenset({"green", "g", "vert", "grün"}),
    frozenset({"blue", "b", "bleu", "blau"}),
)
"""Names of the bands red, green and blue in a file's descriptions, small letters."""


class PictureError(Exception):
    """The picture cannot become a background; the text says why, and what to do."""


class GroundPicture:
    """An open picture. Made by `open_picture`."""

    def __init__(self, rasterio: Any, dataset: Any) -> None:
        self._rasterio = rasterio
        self._dataset = dataset
        self._has_alpha = rasterio.enums.ColorInterp.alpha in dataset.colorinterp
        self._bands = (*_colour_bands(rasterio, dataset), _alpha_band(rasterio, dataset))
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
            bands = np.asarray(warped.read(list(self._bands)), np.uint8)
        return np.ascontiguousarray(bands.transpose(1, 2, 0)) if bands[3].any() else None

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
            picture = GroundPicture(rasterio, dataset)
            _check_bounds(path, picture.bounds)
            yield picture
        except (rasterio.errors.RasterioError, rasterio.errors.CRSError, rasterio._err.CPLE_BaseError) as error:
            raise PictureError(f"{path}: cannot be brought onto the map: {error}; {_SAVE}") from error


def _check(path: Path, rasterio: Any, dataset: Any) -> None:
    if dataset.crs is None or dataset.transform.is_identity:
        raise PictureError(f"{path} does not say where it lies: georeference it, in QGIS for example")
    if not (dataset.crs.is_geographic or dataset.crs.is_projected):
        raise PictureError(f"{path} is in local coordinates, which have no place on Earth: {_SAVE}")
    if rasterio.enums.ColorInterp.palette in dataset.colorinterp:
        raise PictureError(f"{path} has a palette of colours: gdal_translate -expand rgb {path} new.tif")
    if set(dataset.dtypes) != {"uint8"}:
        found = ", ".join(sorted(set(dataset.dtypes)))
        raise PictureError(f"{path} has {found} pixels, not 8 bits: gdal_translate -ot Byte -scale {path} new.tif")


def _check_bounds(path: Path, bounds: Bounds) -> None:
    edges = (bounds.west, bounds.south, bounds.east, bounds.north)
    if not all(math.isfinite(edge) and abs(edge) <= HALF_M * 1.001 for edge in edges):
        raise PictureError(f"{path} lies beyond the map (85 degrees north or south): check its coordinates; {_SAVE}")


def _colour_bands(rasterio: Any, dataset: Any) -> tuple[int, int, int]:
    """Return the numbers of the bands that are red, green and blue, from 1, as the file says; one grey for all three.

    Raises PictureError when it does not say.
    """
    kinds = rasterio.enums.ColorInterp
    alpha = kinds.alpha
    told = list(dataset.colorinterp)
    if all(each in told for each in (kinds.red, kinds.green, kinds.blue)):
        red, green, blue = (told.index(each) + 1 for each in (kinds.red, kinds.green, kinds.blue))
        return red, green, blue
    named = [(text or "").strip().lower() for text in dataset.descriptions]
    found = [[number for number, name in enumerate(named, start=1) if name in names] for names in _BAND_NAMES]
    if all(len(numbers) == 1 for numbers in found):
        return found[0][0], found[1][0], found[2][0]
    colours = [number for number, each in enumerate(told, start=1) if each is not alpha]
    if len(colours) == 1:
        return colours[0], colours[0], colours[0]
    words = ", ".join(name or each.name for name, each in zip(named, told, strict=True))
    raise PictureError(
        f"{dataset.name} does not say which of its bands are red, green and blue ({words}): "
        f"gdal_translate -b RED -b GREEN -b BLUE -colorinterp red,green,blue {dataset.name} new.tif, with their numbers"
    )


def _alpha_band(rasterio: Any, dataset: Any) -> int:
    """Return the number of the band of opacity: its own, else the one that is added behind all others."""
    told = list(dataset.colorinterp)
    alpha = rasterio.enums.ColorInterp.alpha
    return told.index(alpha) + 1 if alpha in told else int(dataset.count) + 1


def _rasterio() -> Any:
    try:
        import rasterio
        import rasterio._err
        import rasterio.enums
        import rasterio.errors
        import rasterio.transform
        import rasterio.vrt
    except ImportError as error:
        raise PictureError(MISSING) from error
    return rasterio
