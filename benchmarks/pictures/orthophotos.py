"""Places as GeoTIFFs: whatever system of coordinates, bands and orientation they come in, the stalls are the same."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import pyproj
import rasterio
from numpy.typing import NDArray

from benchmarks.figures import BenchmarkError, Figure, Limit, share
from benchmarks.perception.places import Place, read_lots
from hawk.picture.city.run import map_orthophoto
from hawk.picture.orthophoto.tile_detector import TileDetector
from hawk.picture.values import PictureSurvey
from hawk.survey.accuracy import FloatArray, match

SYSTEMS: Final = {
    "UTM": ("EPSG:32631", 5.0, 52.0),
    "Dutch grid": ("EPSG:28992", 5.4, 52.15),
    "feet": ("EPSG:2236", -80.5, 26.0),
    "degrees": ("EPSG:4326", 5.0, 52.0),
    "Web Mercator": ("EPSG:3857", 5.0, 52.0),
}
"""Systems by name, with longitude and latitude of a place in each."""
BANDS: Final = ("RGB", "RGBA", "RGB+NIR")
STEP_M: Final = 0.05
"""Coordinates are compared after rounding to this."""


@dataclass(frozen=True, slots=True)
class _Variant:
    """A form in which a picture is delivered."""

    system: str
    bands: str
    is_south_up: bool


def orthophoto_figures(folder: Path | None) -> list[Figure]:
    """Return how alike the stalls of each place's forms are, and against the detector that the benchmark judges."""
    if folder is None:
        raise BenchmarkError("--orthophoto: needs --places DIR, with PLACE.jpg and PLACE.json")
    detector = TileDetector.load()
    total = same = rounded = coordinates = found = missed = extra = 0
    for place in read_lots(folder):
        looked = detector.detect(place.image, place.metres_per_pixel).stalls
        first: FloatArray | None = None
        for variant in _variants():
            corners = _in_picture(place, variant)
            if first is None:
                first = corners
                pairs = match(corners, looked)
                found, missed = found + len(pairs.true), missed + len(looked) - len(pairs.true)
                extra += len(corners) - len(pairs.found)
            total += 1
            is_same = corners.shape == first.shape
            same += is_same and bool(np.allclose(corners, first, atol=STEP_M / 2))
            if is_same:
                rounded += int((np.round(corners / STEP_M) == np.round(first / STEP_M)).sum())
            coordinates += first.size
    return [
        Figure("orthophoto_same", "forms with the stalls of the first", share(same, total), limit=Limit(lowest=1.0)),
        Figure("orthophoto_rounded", "coordinates equal after rounding to .05 m", share(rounded, coordinates)),
        Figure("orthophoto_found", "stalls of the benchmark's detector that were mapped", share(found, found + missed)),
        Figure("orthophoto_extra", "stalls that the benchmark's detector does not have", float(extra)),
        Figure("orthophoto_forms", "forms that were mapped", float(total)),
    ]  # fmt: skip


def _variants() -> Iterator[_Variant]:
    for system in SYSTEMS:
        yield _Variant(system, BANDS[0], is_south_up=False)
    for bands in BANDS[1:]:
        yield _Variant("UTM", bands, is_south_up=False)
    yield _Variant("Dutch grid", BANDS[0], is_south_up=True)


def _in_picture(place: Place, variant: _Variant) -> FloatArray:
    """Return the stalls (N, 4, 2), metres from the upper left corner of the picture, mapped in a form of it."""
    with tempfile.TemporaryDirectory(prefix="hawk-orthophoto-") as folder:
        path = Path(folder) / f"{place.name}.tif"
        to_picture = _write(path, place.image, place.metres_per_pixel, variant)
        mapped = map_orthophoto(path)
    return _pixels(mapped, variant, to_picture) * place.metres_per_pixel


def _write(path: Path, image: NDArray[np.uint8], metres: float, variant: _Variant) -> rasterio.Affine:
    """Write a picture in a form; return the transform from the system to its pixels as they were given.

    Its pixels are ``metres`` a side on the ellipsoid, whatever the system's units are.
    """
    code, longitude, latitude = SYSTEMS[variant.system]
    onto = pyproj.Transformer.from_crs("EPSG:4326", code, always_xy=True)
    x, y = onto.transform(longitude, latitude)
    back = pyproj.Transformer.from_crs(code, "EPSG:4326", always_xy=True)
    geod = pyproj.Geod(ellps="WGS84")
    step = 1e-4 if variant.system == "degrees" else 10.0
    wide, high = (
        geod.inv(*back.transform(x, y), *back.transform(x + dx, y + dy))[2] / step for dx, dy in ((step, 0), (0, step))
    )
    transform = rasterio.Affine(metres / wide, 0.0, x, 0.0, -metres / high, y)
    bands = image[..., ::-1]
    if variant.bands == "RGBA":
        bands = np.dstack([bands, np.full(image.shape[:2], 255, np.uint8)])
    elif variant.bands == "RGB+NIR":
        bands = np.dstack([bands, image[..., 1]])
    stored = transform
    if variant.is_south_up:
        bands = bands[::-1]
        stored = transform * rasterio.Affine(1.0, 0.0, 0.0, 0.0, -1.0, image.shape[0])
    interpretation = [rasterio.enums.ColorInterp.red, rasterio.enums.ColorInterp.green, rasterio.enums.ColorInterp.blue]
    if variant.bands == "RGBA":
        interpretation.append(rasterio.enums.ColorInterp.alpha)
    elif variant.bands == "RGB+NIR":
        interpretation.append(rasterio.enums.ColorInterp.undefined)
    with rasterio.open(
        path, "w", driver="GTiff", width=image.shape[1], height=image.shape[0], count=bands.shape[2], dtype="uint8",
        crs=code, transform=stored,
    ) as file:  # fmt: skip
        file.colorinterp = interpretation
        file.write(np.moveaxis(bands, -1, 0))
    return ~transform


def _pixels(mapped: PictureSurvey, variant: _Variant, to_picture: rasterio.Affine) -> FloatArray:
    """Return the stalls (N, 4, 2) in pixels of the picture as it was given."""
    onto = pyproj.Transformer.from_crs("EPSG:4326", SYSTEMS[variant.system][0], always_xy=True)
    corners = np.array([stall.corners for stall in mapped.survey.stalls], float).reshape(-1, 2)
    x, y = onto.transform(corners[:, 1], corners[:, 0])
    a, b, c, d, e, f = to_picture[:6]
    return np.column_stack([a * x + b * y + c, d * x + e * y + f]).reshape(-1, 4, 2)
