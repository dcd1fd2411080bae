"""Pictures of surveys: the mosaic of each as it was at the landing, in a folder beside the lots' store.

A picture serves a person who corrects a plan, and a network that learns from it; nothing that is counted needs one. So
they are files, the newest of each lot are kept, and a backup has none.
"""

from __future__ import annotations

import json
import os
import re
import zipfile
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection, bindparam, select

from hawk.lots.storage.rows import is_among
from hawk.lots.storage.schema import SURVEY
from hawk.lots.survey.order import newest_first
from hawk.lots.values import LotStoreError
from hawk.model.lot_map import CELL_M, TILE_CELLS, TILE_M, EncodedTile, TileKey
from hawk.model.poses import Ring
from hawk.model.tile_picture import decode_picture, encode_picture

KEPT: Final = 12
"""Surveys of a lot whose pictures are kept: a lot of one hectare takes half a megabyte each."""
_LOTS: Final = select(SURVEY.c.id, SURVEY.c.lot).where(is_among(SURVEY.c.id))
_NEWEST: Final = (
    select(SURVEY.c.id).where(SURVEY.c.lot.is_not_distinct_from(bindparam("lot"))).order_by(*newest_first()).limit(KEPT)
)
_SUFFIX: Final = ".zip"
_UNFINISHED: Final = ".part"
_NAME: Final = re.compile(r"(-?\d{1,6})_(-?\d{1,6})\.jpg")
_WHOLE: Final = "whole.webp"
_WHOLE_PX: Final = 1280
"""Pixels of the longer side of the picture of the whole, at most: as many as a screen shows of a lot."""
_WHOLE_QUALITY: Final = (cv2.IMWRITE_WEBP_QUALITY, 80)
_LARGEST_TILE: Final = 1 << 20
"""Bytes; a tile of 256 x 256 pixels is never as large."""


@dataclass(frozen=True, slots=True)
class Shown:
    """A picture of ground, north up, `CELL_M` metres a pixel.

    ``image`` (H, W, 3) BGR; ``seen`` (H, W); ``north`` and ``east`` of its upper left corner, metres in the frame of
    the survey.
    """

    image: NDArray[np.uint8]
    seen: NDArray[np.bool_]
    north: float
    east: float


class PictureFolder:
    """The files of a folder, one a survey. It is made with the first picture."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    @property
    def folder(self) -> Path:
        """The folder; it need not be there."""
        return self._folder

    def write(self, survey: str, mosaic: Mapping[TileKey, EncodedTile], hidden: Sequence[Ring] = ()) -> None:
        """Write the tiles of a survey's mosaic, in place of those before. Raises OSError; those before stay then.

        ``hidden``: rings in the survey's frame that no picture shows, here and below.
        """
        if not mosaic:
            return
        tiles = {key: without(tile.data, key, hidden) for key, tile in mosaic.items()}
        self._folder.mkdir(parents=True, exist_ok=True)
        target = self._path(survey)
        unfinished = target.with_suffix(_UNFINISHED)
        with zipfile.ZipFile(unfinished, "w") as file:
            for (row, column), data in sorted(tiles.items()):
                file.writestr(f"{row}_{column}.jpg", data)
            with suppress(ValueError):  # of a tile that is no picture: the others can be shown one by one
                file.writestr(_WHOLE, _whole(tiles))
        os.replace(unfinished, target)

    def surveys(self) -> set[str]:
        """Return the ids of the surveys that have a picture."""
        return {path.stem for path in self._folder.glob(f"*{_SUFFIX}")}

    def read(self, survey: str, hidden: Sequence[Ring] = ()) -> dict[TileKey, bytes]:
        """Return the tiles of a survey, none where there is no picture. Raises LotStoreError for a broken file."""
        with self._opened(self._path(survey)) as file:
            if file is None:
                return {}
            return {key: without(file.read(info), key, hidden) for key, info in _infos(file).items()}

    def keys(self, survey: str) -> list[TileKey]:
        """Return the keys of a survey's tiles; none without a picture. Raises LotStoreError for a broken file."""
        with self._opened(self._path(survey)) as file:
            return [] if file is None else sorted(_infos(file))

    def whole(self, survey: str, hidden: Sequence[Ring] = ()) -> bytes | None:
        """Return one picture of all tiles of a survey, None where there is none: WebP, transparent where nothing was
        seen, north up, over the rectangle of the tiles. Raises LotStoreError for a broken file.
        """
        with self._opened(self._path(survey)) as file:
            if file is None or _WHOLE not in file.NameToInfo:
                return None
            return _whole_without(file.read(_WHOLE), extent(dict.fromkeys(_infos(file), b"")), hidden)

    def tile(self, survey: str, key: TileKey, hidden: Sequence[Ring] = ()) -> bytes | None:
        """Return one tile of a survey, None where there is none. Raises LotStoreError for a broken file."""
        with self._opened(self._path(survey)) as file:
            info = None if file is None else _infos(file).get(key)
            return None if file is None or info is None else without(file.read(info), key, hidden)

    def keep(self, surveys: Collection[str]) -> None:
        """Remove the pictures of all other surveys. Raises OSError."""
        for survey in self.surveys() - set(surveys):
            self.remove(survey)

    def remove(self, survey: str) -> bool:
        """Remove the picture of a survey, a half-written one too; return False when there was none. Raises OSError."""
        path = self._path(survey)
        is_there = path.exists()
        path.with_suffix(_UNFINISHED).unlink(missing_ok=True)
        path.unlink(missing_ok=True)
        return is_there

    @contextmanager
    def _opened(self, path: Path) -> Iterator[zipfile.ZipFile | None]:
        if not path.exists():
            yield None
            return
        try:
            with zipfile.ZipFile(path) as file:
                yield file
        except (OSError, zipfile.BadZipFile) as error:
            raise LotStoreError(f"{path}: {error}; remove it: only the picture of that survey is lost") from error

    def _path(self, survey: str) -> Path:
        return self._folder / f"{survey}{_SUFFIX}"


def _infos(file: zipfile.ZipFile) -> dict[TileKey, zipfile.ZipInfo]:
    """Return the entries of a file that are tiles, by their keys."""
    named = ((_NAME.fullmatch(info.filename), info) for info in file.infolist())
    return {
        (int(name[1]), int(name[2])): info
        for name, info in named
        if name is not None and info.file_size <= _LARGEST_TILE
    }


def _whole(tiles: Mapping[TileKey, bytes]) -> bytes:
    """Return one picture of tiles, as fine as they are or coarser by a power of two. Raises ValueError for a tile that
    is no picture.
    """
    south, west, north, east = extent(tiles)
    across, down = round((east - west) / TILE_M), round((north - south) / TILE_M)
    side = TILE_CELLS
    while side > 1 and max(across, down) * side > _WHOLE_PX:
        side //= 2
    image = np.zeros((down * side, across * side, 4), np.uint8)
    top, left = round(-north / TILE_M), round(west / TILE_M)
    for (row, column), data in tiles.items():
        pixels, seen = decode_picture(data)
        shown = cv2.resize(np.dstack([pixels, seen]), (side, side), interpolation=cv2.INTER_AREA)
        at = (row - top) * side, (column - left) * side
        image[at[0] : at[0] + side, at[1] : at[1] + side] = shown
    return bytes(cv2.imencode(".webp", image, _WHOLE_QUALITY)[1])


def without(data: bytes, key: TileKey, hidden: Sequence[Ring]) -> bytes:
    """Return the picture of a tile without the ground of rings; the same where it shows none of it.

    A tile that cannot be read, and so cannot be masked, is returned empty where there are rings.
    """
    row, column = key
    origin = np.array([-row * TILE_M, column * TILE_M])
    mask = _mask_of(hidden, origin, CELL_M, (TILE_CELLS, TILE_CELLS))
    if not mask.any():
        return data
    try:
        pixels, seen = decode_picture(data)
    except ValueError:
        return b""
    seen = np.where(mask > 0, np.uint8(0), seen)
    return encode_picture(np.asarray(cv2.copyTo(pixels, seen), np.uint8), np.asarray(seen, np.uint8))


def _whole_without(data: bytes, box: tuple[float, float, float, float], hidden: Sequence[Ring]) -> bytes:
    """Return the picture of all tiles of a box (south, west, north, east) without the ground of rings."""
    if not hidden:
        return data
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    if image is None or image.ndim != 3:
        return b""
    if image.shape[2] == 3:  # WebP leaves the opacity of a picture without a hole out
        image = cv2.cvtColor(image, cv2.COLOR_BGR2BGRA)
    _, west, north, east = box
    mask = _mask_of(hidden, np.array([north, west]), (east - west) / image.shape[1], image.shape[:2])
    image[mask > 0] = 0
    return bytes(cv2.imencode(".webp", image, _WHOLE_QUALITY)[1])


def _mask_of(
    hidden: Sequence[Ring], corner: NDArray[np.float64], metres: float, shape: tuple[int, ...]
) -> NDArray[np.uint8]:
    """Return a raster that is 1 on rings; ``corner``: (north, east) of its upper left one, ``metres`` a pixel."""
    mask = np.zeros(shape, np.uint8)
    for ring in hidden:
        away = (np.array(ring, np.float64) - corner) / metres
        cv2.fillPoly(mask, [np.rint(away[:, ::-1] * (1, -1)).astype(np.int32)], 1)
    return mask


def pictures_of(store: Path) -> PictureFolder:
    """Return the pictures of a store's surveys; ``store`` is its file."""
    return PictureFolder(store.with_name(f"{store.stem}-pictures"))


def worth_keeping(connection: Connection, pictured: Collection[str], stored: str) -> set[str]:
    """Return those of some surveys, by ids, that are among the `KEPT` newest of their lot, or of those without one.

    Lots that have no more pictures than that are not looked at, but for that of the survey ``stored``: no other one has
    another newest survey, and a store of a million is not read for each.
    """
    among = {"among": json.dumps([stored, *pictured])}
    lots = {row.id: row.lot for row in connection.execute(_LOTS, among)}
    numbers = Counter(lots[each] for each in pictured if each in lots)
    full = {lot for lot, number in numbers.items() if number > KEPT} | {lots.get(stored)}
    newest = {each for lot in full for each in connection.execute(_NEWEST, {"lot": lot}).scalars()}
    return {each for each in pictured if each in lots and (lots[each] not in full or each in newest)}


def drawn(tiles: Mapping[TileKey, bytes], box: tuple[float, float, float, float]) -> Shown | None:
    """Return the picture of a box (south, west, north, east), metres; None where none of it was seen.

    Raises ValueError for a tile that is no picture.
    """
    south, west, north, east = box
    top, left = round(-north / CELL_M), round(west / CELL_M)
    size = (round((north - south) / CELL_M), round((east - west) / CELL_M))
    image, seen = np.zeros((*size, 3), np.uint8), np.zeros(size, np.bool_)
    for (row, column), data in tiles.items():
        at = (row * TILE_CELLS - top, column * TILE_CELLS - left)
        to = tuple(slice(max(a, 0), min(a + TILE_CELLS, side)) for a, side in zip(at, size, strict=True))
        if any(part.start >= part.stop for part in to):
            continue
        pixels, mask = decode_picture(data)
        of = tuple(slice(part.start - a, part.stop - a) for part, a in zip(to, at, strict=True))
        image[to], seen[to] = pixels[of], mask[of] > 0
    return Shown(image, seen, -top * CELL_M, left * CELL_M) if seen.any() else None


def extent(tiles: Mapping[TileKey, bytes]) -> tuple[float, float, float, float]:
    """Return the box (south, west, north, east) of tiles, metres. Raises ValueError without any."""
    rows, columns = zip(*tiles, strict=True)
    return -(max(rows) + 1) * TILE_M, min(columns) * TILE_M, -min(rows) * TILE_M, (max(columns) + 1) * TILE_M
