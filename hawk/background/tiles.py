"""XYZ map tiles (Web Mercator, EPSG:3857, y from the north), cut from a GeoTIFF into a folder."""

from __future__ import annotations

import contextlib
import math
import shutil
import tempfile
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import track

from hawk.formats import gdal
from hawk.runtime.programs import remedy
from hawk.web.background import DEEPEST_ZOOM

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
            dataset = gdal.open_picture(path)
        except gdal.UnsafeError as error:
            raise PictureError(f"{path} {error}") from error
        except OSError as error:
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
    meanings = list(dataset.colorinterp)
    if all(each in meanings for each in (kinds.red, kinds.green, kinds.blue)):
        red, green, blue = (meanings.index(each) + 1 for each in (kinds.red, kinds.green, kinds.blue))
        return red, green, blue
    named = [(text or "").strip().lower() for text in dataset.descriptions]
    found = [[number for number, name in enumerate(named, start=1) if name in names] for names in _BAND_NAMES]
    if all(len(numbers) == 1 for numbers in found):
        return found[0][0], found[1][0], found[2][0]
    colours = [number for number, each in enumerate(meanings, start=1) if each is not alpha]
    if len(colours) == 1:
        return colours[0], colours[0], colours[0]
    words = ", ".join(name or each.name for name, each in zip(named, meanings, strict=True))
    raise PictureError(
        f"{dataset.name} does not say which of its bands are red, green and blue ({words}): "
        f"gdal_translate -b RED -b GREEN -b BLUE -colorinterp red,green,blue {dataset.name} new.tif, with their numbers"
    )


def _alpha_band(rasterio: Any, dataset: Any) -> int:
    """Return the number of the band of opacity: its own, else the one that is added behind all others."""
    meanings = list(dataset.colorinterp)
    alpha = rasterio.enums.ColorInterp.alpha
    return meanings.index(alpha) + 1 if alpha in meanings else int(dataset.count) + 1


def _rasterio() -> Any:
    try:
        return gdal.rasterio()
    except ImportError as error:
        raise PictureError(MISSING) from error


HALF_M: Final = math.pi * 6_378_137.0
"""Half the width of the world in Web Mercator, metres of the projection (EPSG:3857: a sphere with WGS-84's radius)."""
TILE_PX: Final = 256
_COARSER: Final = 1.15
"""Tiles may be coarser than the picture by this factor: one zoom more takes four times the room."""


@dataclass(frozen=True, slots=True)
class Bounds:
    """A rectangle in Web Mercator, metres of the projection."""

    west: float
    south: float
    east: float
    north: float


@dataclass(frozen=True, slots=True)
class Tile:
    """One tile by its number."""

    zoom: int
    x: int
    y: int

    @property
    def bounds(self) -> Bounds:
        """Its edges."""
        side = tile_side(self.zoom)
        west, north = self.x * side - HALF_M, HALF_M - self.y * side
        return Bounds(west, north - side, west + side, north)


def tile_side(zoom: int) -> float:
    """Return the side of a tile, metres of the projection."""
    return 2 * HALF_M / (1 << zoom)


def zooms_for(bounds: Bounds, metres_per_pixel: float) -> range:
    """Return the zooms of a picture: from the one at which it fits into a tile to that of its own pixels.

    ``metres_per_pixel`` is in metres of the projection.
    """
    deepest = math.ceil(math.log2(2 * HALF_M / TILE_PX / (metres_per_pixel * _COARSER)))
    deepest = min(max(deepest, 0), DEEPEST_ZOOM)
    widest = max(bounds.east - bounds.west, bounds.north - bounds.south)
    lowest = math.floor(math.log2(2 * HALF_M / widest))
    return range(min(max(lowest, 0), deepest), deepest + 1)


def tiles_of(bounds: Bounds, zooms: range) -> Iterator[Tile]:
    """Yield every tile that the rectangle touches."""
    for zoom in zooms:
        xs, ys = _span(bounds, zoom)
        for x in xs:
            for y in ys:
                yield Tile(zoom, x, y)


def count_tiles(bounds: Bounds, zooms: range) -> int:
    """Return the number of tiles that the rectangle touches."""
    return sum(len(xs) * len(ys) for xs, ys in (_span(bounds, zoom) for zoom in zooms))


def _span(bounds: Bounds, zoom: int) -> tuple[range, range]:
    side, last = tile_side(zoom), (1 << zoom) - 1
    first_x, last_x = math.floor((bounds.west + HALF_M) / side), math.ceil((bounds.east + HALF_M) / side) - 1
    first_y, last_y = math.floor((HALF_M - bounds.north) / side), math.ceil((HALF_M - bounds.south) / side) - 1
    return range(max(first_x, 0), min(last_x, last) + 1), range(max(first_y, 0), min(last_y, last) + 1)


MOST_TILES: Final = 200_000
"""At some 15 kB a tile these take 3 GB."""
_JPEG: Final = (cv2.IMWRITE_JPEG_QUALITY, 85)


@dataclass(frozen=True, slots=True)
class TileFolder:
    """A folder of tiles: their number and bytes."""

    tiles: int
    size: int


def write_tiles(picture: GroundPicture, folder: Path, zooms: range) -> TileFolder:
    """Write every tile on which the picture shows something, as JPEG, or as PNG where it ends on the tile.

    ``folder`` must be new or empty; it is there with all tiles, or not at all. Raises PictureError.
    """
    count = count_tiles(picture.bounds, zooms)
    if count > MOST_TILES:
        raise PictureError(f"--zooms: {count} tiles are too many, at most {MOST_TILES}: name lower zooms")
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise PictureError(f"--out: {folder} is not empty: name a new folder")
    folder.parent.mkdir(parents=True, exist_ok=True)
    part = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
    try:
        tiles = track(tiles_of(picture.bounds, zooms), "tiles", count, transient=True, console=Console(stderr=True))
        sizes = [size for tile in tiles if (size := _write(picture, part, tile))]
        if not sizes:
            raise PictureError("the picture shows nothing: all of it is transparent")
        part.chmod(0o755)
        part.replace(folder)
    finally:
        shutil.rmtree(part, ignore_errors=True)
    return TileFolder(len(sizes), sum(sizes))


def _write(picture: GroundPicture, folder: Path, tile: Tile) -> int:
    """Write one tile; return its bytes, none where the picture shows nothing."""
    pixels = picture.read(tile)
    if pixels is None:
        return 0
    if (pixels[..., 3] == OPAQUE).all():
        suffix, (_, data) = ".jpg", cv2.imencode(".jpg", cv2.cvtColor(pixels, cv2.COLOR_RGBA2BGR), _JPEG)
    else:
        suffix, (_, data) = ".png", cv2.imencode(".png", cv2.cvtColor(pixels, cv2.COLOR_RGBA2BGRA))
    path = folder / str(tile.zoom) / str(tile.x) / f"{tile.y}{suffix}"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data.tobytes())
    return len(data)
