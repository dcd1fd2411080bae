"""An orthophoto as a source: opened once, described by values, and read part by part.

GDAL reads GeoTIFF, Cloud Optimised and Big ones, VRT, and JPEG or PNG with a world file; the extra ``pictures`` brings
it. The description holds no open file, so that another process or computer can read the same picture.
"""

from __future__ import annotations

import contextlib
import json
import math
import time
import warnings
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np

from hawk.formats import gdal
from hawk.formats.remote_raster import (
    Door,
    Hosts,
    RemoteError,
    RemoteFacts,
    RemoteRaster,
    check_part,
    door,
    facts_of,
    without_secrets,
)
from hawk.lots.survey.moments import CaptureTime, MomentSource
from hawk.picture.orthophoto import bands as band_choice
from hawk.picture.orthophoto.bands import Bands, Pixels
from hawk.picture.orthophoto.grid import Box, PixelGrid, measure_grid, system
from hawk.picture.values import COARSE_M, COARSEST_M, PictureError, is_coarser, list_names
from hawk.runtime.late import load
from hawk.runtime.programs import remedy

LEAST_M: Final = 2.0
"""A picture of less ground shows no stall."""
_MEASURED: Final = (
    "17 labelled places were made coarser: at 20 cm 92 % of the stalls of Canadian lots are found, at 9 cm 93 %; of "
    "Dutch streets and lots 66 % and 67 %, where 79 % and 82 % of what is found is labelled. Blur and haze cost more."
)
"""By `benchmarks.perception` with ``--metres``, over the places and regions of docs/results/perception.md."""
_CACHE_MIB: Final = 64
"""Memory of GDAL for blocks that were read."""
_STRIP_PIXELS: Final = 8_000_000
"""Pixels that are read at once."""
_MOST_BLOCK_BYTES: Final = 256_000_000
"""Of a part that GDAL reads as a whole: a strip or tile."""
_FEW_PIXELS: Final = 1_000_000_000
_PIXELS_A_BYTE: Final = 300
"""Pixels of larger pictures by the bytes of their files: ground as JPEG has 3 to 20, a city of which 5 % is mapped up
to 200, and Deflate makes 340 of nothing."""
_LONGEST_SIDE: Final = 4_000_000
"""Pixels: 400 km at 10 cm."""
_LEAST_MASK_STEP: Final = 8
"""An overview this much smaller shows at little cost where ground is."""


PixelRing = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class Orthophoto:
    """A picture with its place on Earth.

    ``crs``: name of its system as of `grid.system`, "" for WGS-84. ``identity``: changes with the file and with the
    files that it names. ``taken``: when it was taken, as far as its file says.
    ``has_overviews``: its ground can be seen as a whole at little cost. ``notes``: sentences for its reader.
    ``private``: rings (column, row) of ground that nobody may look at: it is read as ground that the picture lacks.
    ``hosts``: those that a person allows to ask for it, or for what it names.
    """

    path: Path | RemoteRaster
    grid: PixelGrid
    bands: Bands
    crs: str
    identity: str = field(repr=False)
    taken: CaptureTime
    has_overviews: bool = False
    notes: tuple[str, ...] = ()
    private: tuple[PixelRing, ...] = field(default=(), repr=False)
    hosts: Hosts = ()

    def private_in(self, box: Box) -> tuple[PixelRing, ...]:
        """Return the private rings whose bounds touch a box."""
        left, top, right, bottom = box
        ends = ((ring, *np.min(ring, axis=0), *np.max(ring, axis=0)) for ring in self.private)
        return tuple(
            ring for ring, x, y, far_x, far_y in ends if x < right and far_x > left and y < bottom and far_y > top
        )

    def read(self, box: Box, step: int = 1) -> Pixels:
        """Return a part of the picture, a pixel for each ``step`` by ``step`` ones; a rest at its ends is left out.

        Raises PictureError for a file that cannot be read there.
        """
        left, top, right, bottom = box
        columns, rows = (right - left) // step, (bottom - top) // step
        image, valid = np.empty((rows, columns, 3), np.uint8), np.empty((rows, columns), np.bool_)
        high = max(1, _STRIP_PIXELS // max(1, (right - left) * step))  # rows of the result at once
        with open_dataset(self.path, is_checked=True, hosts=self.hosts) as dataset:
            for row in range(0, rows, high):
                last = min(row + high, rows)
                part = self._strip(dataset, (left, top + row * step, left + columns * step, top + last * step))
                image[row:last], valid[row:last] = _thinned(part, step)
        for ring in self.private_in(box):
            hidden = np.zeros(valid.shape, np.uint8)
            cv2.fillPoly(hidden, [np.rint((np.array(ring) - (left, top)) / step).astype(np.int32)], 1)
            image[hidden > 0], valid[hidden > 0] = 0, False
        return Pixels(image, valid)

    def _strip(self, dataset: Any, box: Box) -> Pixels:
        if not self.grid.is_mirrored:
            return band_choice.read(dataset, self.bands, box)
        left, top, right, bottom = box
        part = band_choice.read(dataset, self.bands, (left, self.grid.rows - bottom, right, self.grid.rows - top))
        return Pixels(part.image[::-1], part.valid[::-1])

    def ground(self, most: int = 2048) -> np.ndarray[Any, np.dtype[np.bool_]] | None:
        """Return which parts of the picture (H, W), at most this many a side, show ground; None: it would cost much."""
        if not self.has_overviews:
            return None
        scale = max(1.0, max(self.grid.columns, self.grid.rows) / most)
        size = (max(1, round(self.grid.rows / scale)), max(1, round(self.grid.columns / scale)))
        with open_dataset(self.path, is_checked=True, hosts=self.hosts) as dataset:
            valid = band_choice.valid_pixels(dataset, self.bands, None, size)
        return valid[::-1] if self.grid.is_mirrored else valid


def open_orthophoto(path: Path | RemoteRaster, crs: str | None = None, hosts: Hosts = ()) -> Orthophoto:
    """Open a picture.

    Args:
        path: The file, or raster of a server.
        crs: Its system of coordinates, in place of what the file says; None: that of the file.
        hosts: Those that may be asked for it, or for what a VRT names.

    Raises:
        PictureError: It is no such file, has no place on Earth, is too coarse, or the extra ``pictures`` is missing.
    """
    if isinstance(path, Path) and not path.is_file():
        raise PictureError(f"{path}: is no file; name a GeoTIFF, a VRT, or a JPEG or PNG with a world file")
    parts = _parts(path)  # GDAL looks for them where it reads them, and not even there if it has kept them
    facts = _remote_facts(path, parts, hosts)
    with open_dataset(path, is_checked=bool(hosts), hosts=hosts) as dataset:  # `_remote_facts` has checked a VRT
        _check_work(dataset, path, parts, facts)
        grid, short = _placed(dataset, path, crs)
        chosen = band_choice.bands_of(dataset, path.name)
        notes = [*_scale_notes(grid, path.name), *_level_notes(chosen)]
        taken = _time_of(dataset, path, facts)
        files = [] if isinstance(path, RemoteRaster) else [str(path), *dataset.files, *map(str, parts)]
        factors = dataset.overviews(1)
        has_overviews = bool(factors) and max(factors) >= _LEAST_MASK_STEP
        identity = _identity(files, facts)
    return Orthophoto(path, grid, chosen, short, identity, taken, has_overviews, tuple(notes), hosts=hosts)


def _remote_facts(
    path: Path | RemoteRaster, parts: Iterable[Path], hosts: Hosts
) -> dict[RemoteRaster, RemoteFacts | None]:
    """Return the rasters of servers that a picture needs, with their facts, None of S3. Raises PictureError."""
    try:
        if isinstance(path, RemoteRaster):
            rasters = {path}
        elif hosts:
            if gdal.driver_of(path) == "VRT":
                gdal.check_vrt(path, hosts)
            names = {name for each in (path, *parts) for name, local in gdal.sources_of(each) if local is None}
            rasters = {part for name in names if (part := check_part(name, hosts)) is not None}
        else:
            return {}
        facts = facts_of(rasters, hosts)
    except (RemoteError, gdal.UnsafeError, OSError) as error:
        raise PictureError(f"{path.name}: {error}") from error
    for each, found in facts.items():
        if found.kind.name not in gdal.DRIVERS or found.kind.name == "VRT":
            remedy = "copy the VRT here" if found.kind.name == "VRT" else found.kind.remedy or "name a GeoTIFF"
            raise PictureError(f"{each}: {found.kind.words}: {remedy}")
    return {each: facts.get(each) for each in rasters}


@contextlib.contextmanager
def _outer_options(path: Path | RemoteRaster, hosts: Hosts) -> Iterator[tuple[Door | None, dict[str, str]]]:
    if not hosts:
        yield None, {}
        return
    with door(hosts) as opened:
        yield opened, gdal.remote_options(path, opened)


@contextlib.contextmanager
def open_dataset(path: Path | RemoteRaster, *, is_checked: bool = False, hosts: Hosts = ()) -> Iterator[Any]:
    """Open a picture as `hawk.formats.gdal` does. Raises PictureError for what cannot be opened or read."""
    try:
        load("pyproj")  # of the same extra
        rasterio = gdal.rasterio()
    except ImportError as error:
        words = f"rasterio and pyproj are not installed, which read orthophotos: {remedy('pictures')}"
        raise PictureError(words) from error
    with _outer_options(path, hosts) as (opened, options):
        try:
            with rasterio.Env(GDAL_CACHEMAX=_CACHE_MIB, **options), warnings.catch_warnings():
                warnings.simplefilter("ignore", rasterio.errors.NotGeoreferencedWarning)
                with gdal.open_picture(path, is_checked=is_checked, hosts=hosts) as dataset:
                    yield dataset
        except rasterio.errors.RasterioError as error:
            _parts(path)
            raise PictureError(f"{path.name}: {_unreadable(error, opened)}") from None if opened else error
        except (gdal.UnsafeError, OSError) as error:
            said = error.strerror if isinstance(error, OSError) else None
            raise PictureError(f"{path.name}: {said or error}") from error


def _unreadable(error: Exception, opened: Door | None) -> str:
    """Return why GDAL does not read a picture, and the remedy; no address has its secrets in it."""
    try:
        if opened is not None:
            opened.check()
    except RemoteError as closed:
        return str(closed)
    reason = without_secrets(str(error.__cause__ or error).splitlines()[0])[:160]
    remedy = "export it again" if opened is None else "try again later, or copy it here"
    return f"cannot be read as a picture ({reason}); {remedy}"


def _parts(path: Path | RemoteRaster) -> list[Path]:
    """Return the files that a VRT names. Raises PictureError where some are not there."""
    if isinstance(path, RemoteRaster):
        return []
    parts = parts_of(path)
    if missing := missing_parts(parts):
        raise PictureError(
            f"{path.name}: is made of files that are not there: {list_names(missing)}; put them back, or build it of "
            f"those that are there: gdalbuildvrt {path.name} FOLDER/*.tif"
        )
    return parts


def _check_work(
    dataset: Any, path: Path | RemoteRaster, parts: Iterable[Path], facts: dict[RemoteRaster, RemoteFacts | None]
) -> None:
    """Refuse a picture that would take more memory or time than its files can have ground. Raises PictureError."""
    wide, high = max(dataset.block_shapes, key=lambda shape: shape[0] * shape[1], default=(1, 1))
    deep = max((np.dtype(kind).itemsize for kind in dataset.dtypes if not kind.startswith("complex_int")), default=8)
    block = wide * high * deep * (dataset.count if dataset.interleaving is not None else 1)
    if block > _MOST_BLOCK_BYTES:
        raise PictureError(
            f"{path.name}: is stored in parts of {block / 1e6:,.0f} MB, each of which is read as a whole; store it in "
            f"tiles: gdal_translate -co TILED=YES {path.name} tiled.tif"
        )
    pixels, size = dataset.width * dataset.height, 0.0
    for known in facts.values():
        size += math.inf if known is None else known.size
    for each in {str(path), *dataset.files, *map(str, parts)}:
        with contextlib.suppress(OSError):
            size += Path(each).stat().st_size
    if max(dataset.width, dataset.height) > _LONGEST_SIDE or pixels > max(_FEW_PIXELS, _PIXELS_A_BYTE * size):
        raise PictureError(
            f"{path.name}: has {dataset.width:,} by {dataset.height:,} pixels in {size / 1e6:,.2f} MB: nearly all of "
            "it is empty; cut it to its ground: gdal_translate -projwin LEFT TOP RIGHT BOTTOM IN.tif ground.tif"
        )


def _placed(dataset: Any, path: Path | RemoteRaster, crs: str | None) -> tuple[PixelGrid, str]:
    """Return the grid of a file and the short name of its system."""
    if dataset.transform.is_identity:
        points, _ = dataset.gcps
        if points or dataset.rpcs:
            raise PictureError(
                f"{path.name}: is tied to the ground by control points, not by its pixels; resample it: "
                f"gdalwarp {path.name} ground.tif"
            )
        raise PictureError(
            f"{path.name}: has no place on Earth; put its world file beside it ({path.stem}.wld), or export a GeoTIFF"
        )
    said = crs or (dataset.crs.to_wkt() if dataset.crs else _projection_file(path))
    if not said:
        raise PictureError(
            f"{path.name}: does not say its system of coordinates; name it with --crs, as --crs EPSG:25832"
        )
    text, short = system(said, path.name)
    a, b, c, d, e, f = tuple(dataset.transform)[:6]
    return measure_grid(PixelGrid(dataset.width, dataset.height, text, (a, b, c, d, e, f)), path.name), short


def _projection_file(path: Path | RemoteRaster) -> str:
    """Return the system that ``NAME.prj`` beside a picture names, "" without one."""
    if isinstance(path, RemoteRaster):
        return ""
    beside = path.with_suffix(".prj")
    return beside.read_text(errors="replace").strip() if beside.is_file() else ""


def _scale_notes(grid: PixelGrid, name: str) -> list[str]:
    wide, high = grid.columns * grid.metres[0], grid.rows * grid.metres[1]
    if min(wide, high) < LEAST_M:
        raise PictureError(
            f"{name}: shows {wide:.1f} by {high:.1f} m of ground, less than a stall; take a larger picture"
        )
    coarse = max(grid.metres)
    if is_coarser(coarse, COARSEST_M):
        raise PictureError(
            f"{name}: has {coarse:.3g} m a pixel on the ground, {COARSEST_M:.2f} m is the coarsest that shows stalls; "
            "take a finer picture"
        )
    if not is_coarser(coarse, COARSE_M):
        return []
    return [f"The picture has {coarse * 100:.3g} cm a pixel, more than {COARSE_M * 100:.0f} cm. {_MEASURED}"]


def _level_notes(bands: Bands) -> list[str]:
    if bands.levels is None:
        return []
    low, high = bands.levels
    return [f"The picture has 16 bits: brightness {low:.0f} is shown as black and {high:.0f} as white."]


def _time_of(dataset: Any, path: Path | RemoteRaster, facts: dict[RemoteRaster, RemoteFacts | None]) -> CaptureTime:
    """Return when a picture was taken: its own tag (TIFF's DateTime has no zone: UTC is taken), else its file's
    or server's, else now.
    """
    with contextlib.suppress(ValueError):
        said = f"{dataset.tags().get('TIFFTAG_DATETIME', '')} +0000"
        moment = datetime.strptime(said, "%Y:%m:%d %H:%M:%S %z")
        return CaptureTime(moment.timestamp(), MomentSource.TAG, is_sure=False)
    if isinstance(path, RemoteRaster):
        known = facts.get(path)
        said_then = time.time() if known is None or known.modified is None else known.modified
        return CaptureTime(said_then, MomentSource.FILE, is_sure=False)
    return CaptureTime(path.stat().st_mtime, MomentSource.FILE, is_sure=False)


def _identity(files: Iterable[str], facts: dict[RemoteRaster, RemoteFacts | None]) -> str:
    """Return the place, size and time of change of each file that a picture consists of, as JSON."""
    found: list[list[str | int]] = [
        [str(each), 0, 0] if known is None else [str(each), known.size, known.version]
        for each, known in sorted(facts.items(), key=lambda pair: str(pair[0]))
    ]
    for name in sorted({str(Path(each).resolve()) for each in files}):
        try:
            status = Path(name).stat()
        except OSError:  # within an archive, or on another computer
            found.append([name, 0, 0])
        else:
            found.append([name, status.st_size, status.st_mtime_ns])
    return json.dumps(found)


def _thinned(part: Pixels, step: int) -> tuple[band_choice.Image, band_choice.Mask]:
    if step == 1:
        return part.image, part.valid
    size = (part.image.shape[1] // step, part.image.shape[0] // step)
    image = cv2.resize(part.image, size, interpolation=cv2.INTER_AREA)
    valid = cv2.resize(part.valid.astype(np.float32), size, interpolation=cv2.INTER_AREA)
    return np.asarray(image, np.uint8), np.asarray(valid > 0.5)


def parts_of(path: Path) -> list[Path]:
    """Return the files that a VRT names, sorted, with those of the VRTs among them; none for a file of another kind.

    What lies in an archive or on another computer is left out.
    """
    found: set[Path] = set()
    waiting = [path]
    while waiting:
        named = _named_by(waiting.pop()) - found
        found |= named
        waiting += named
    return sorted(found)


def missing_parts(parts: Iterable[Path]) -> list[str]:
    """Return those of `parts_of` that are not there, in their order."""
    return [str(part) for part in parts if not part.exists()]


def _named_by(path: Path) -> set[Path]:
    try:
        return {source for _, source in gdal.sources_of(path) if source is not None}
    except OSError:
        return set()
