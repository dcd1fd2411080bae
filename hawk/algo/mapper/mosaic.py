"""The picture of the lot from above, put together from the best part of every frame.

The secret is what "best" is (nearest to straight below, and lowest), and that only tiles near the drone are kept as
pixels: the others rest as JPEG.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.mapper.layout import outline, quality_mask, warp
from hawk.algo.mapper.recent import Recent
from hawk.algo.mapper.window import Slices, Window, shard_of_tile, tile_window
from hawk.algo.vision.seen import GroundImage
from hawk.model import CELL_M, TILE_CELLS, TILE_M, EncodedTile, TileKey
from hawk.sharded import Sharded

_QUALITY_M = 0.8
_QUALITY_CELLS = round(TILE_M / _QUALITY_M)
_BETTER = 6.0  # a new pixel must be so many metres nearer to straight below
_JPEG = (cv2.IMWRITE_JPEG_QUALITY, 82)
_AWAKE = 24  # tiles kept as pixels

Picture = NDArray[np.uint8]


@dataclass(slots=True)
class _Tile:
    """``offset`` is how far from straight below each part was seen, metres (infinite: never)."""

    offset: NDArray[np.float32] = field(
        default_factory=lambda: np.full((_QUALITY_CELLS, _QUALITY_CELLS), np.inf, np.float32)
    )


class Mosaic:
    """Picture tiles of `TILE_CELLS` pixels a side."""

    def __init__(self) -> None:
        self.encoded: Sharded[TileKey, EncodedTile] = Sharded(shard_of_tile)
        self.recent: Recent[TileKey] = Recent()
        self._tiles: dict[TileKey, _Tile] = {}
        self._pixels: dict[TileKey, Picture] = {}
        """Of the tiles that are awake, the least lately used first."""
        self._dirty: dict[TileKey, None] = {}

    def add(self, picture: GroundImage, below: tuple[float, float], height: float) -> None:
        """Lay a picture on the map. ``below`` is the place (north, east) straight below the camera."""
        mask = quality_mask(picture.valid, picture.metres_per_pixel, 0.5, 1.0)
        if not mask.any():
            return
        window = Window.around(outline(picture), CELL_M)
        pixels = warp(picture, picture.values, window, cv2.INTER_LINEAR)
        inside = warp(picture, mask, window, cv2.INTER_NEAREST) > 0
        for key, in_tile, in_window in window.tiles():
            self._add_to_tile(key, in_tile, pixels[in_window], inside[in_window], below, height)

    def encode(self, most: int, version: int) -> bool:
        """Encode the longest waiting tiles, at most so many; return whether there was one."""
        keys = list(itertools.islice(self._dirty, most))
        news: dict[TileKey, EncodedTile] = {}
        for key in keys:
            del self._dirty[key]
            ok, data = cv2.imencode(".jpg", self._awake(key), _JPEG)
            if ok:
                news[key] = EncodedTile(version, data.tobytes())
                self.recent.note(key, version)
        self.encoded = self.encoded.changed(news)
        self._rest()
        return bool(keys)

    @property
    def awake(self) -> int:
        """How many tiles are kept as pixels."""
        return len(self._pixels)

    def restore(self, key: TileKey, version: int, data: bytes) -> None:
        """Take up a tile of an earlier run. Raises ValueError when the picture cannot be read."""
        pixels = _decoded(data)
        if pixels is None:
            raise ValueError("mosaic tile: not a picture of the right size")
        self.encoded = self.encoded.changed({key: EncodedTile(version, data)})
        self.recent.note(key, version)
        tile = _Tile()
        seen = cv2.resize(pixels.max(2), (_QUALITY_CELLS, _QUALITY_CELLS), interpolation=cv2.INTER_AREA) > 0
        tile.offset[seen] = 1e3
        self._tiles[key] = tile

    def _add_to_tile(
        self,
        key: TileKey,
        part: Slices,
        pixels: Picture,
        inside: NDArray[np.bool_],
        below: tuple[float, float],
        height: float,
    ) -> None:
        if not inside.any():
            return
        better, offset = self._better(key, below, height)
        fine = np.repeat(np.repeat(better, TILE_CELLS // _QUALITY_CELLS, 0), TILE_CELLS // _QUALITY_CELLS, 1)
        use = inside & fine[part]
        if not use.any():
            return
        cv2.copyTo(pixels, use.astype(np.uint8), self._awake(key)[part])
        tile = self._tiles.setdefault(key, _Tile())
        whole = np.zeros((TILE_CELLS, TILE_CELLS), np.float32)
        whole[part] = use
        covered = cv2.resize(whole, (_QUALITY_CELLS, _QUALITY_CELLS), interpolation=cv2.INTER_AREA) > 0.99
        tile.offset = np.where(covered & better, offset, tile.offset).astype(np.float32)
        self._dirty.setdefault(key)

    def _better(self, key: TileKey, below: tuple[float, float], height: float) -> tuple[NDArray[np.bool_], Picture]:
        window = tile_window(key, _QUALITY_M)
        north = -(window.row + np.arange(_QUALITY_CELLS) + 0.5) * _QUALITY_M
        east = (window.column + np.arange(_QUALITY_CELLS) + 0.5) * _QUALITY_M
        offset = np.hypot(north[:, None] - below[0], east[None] - below[1]) + max(height, 0) * 0.2
        known = self._tiles.get(key)
        before = np.inf if known is None else known.offset
        return np.asarray(offset < before - _BETTER), offset

    def _awake(self, key: TileKey) -> Picture:
        pixels = self._pixels.pop(key, None)
        if pixels is None:
            known = self.encoded.get(key)
            pixels = None if known is None else _decoded(known.data)
        if pixels is None:
            pixels = np.zeros((TILE_CELLS, TILE_CELLS, 3), np.uint8)
        self._pixels[key] = pixels
        return pixels

    def _rest(self) -> None:
        for key in list(itertools.islice(self._pixels, max(len(self._pixels) - _AWAKE, 0))):
            if key not in self._dirty:
                del self._pixels[key]


def _decoded(data: bytes) -> Picture | None:
    try:
        pixels = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    except cv2.error:
        return None
    if pixels is None or pixels.shape != (TILE_CELLS, TILE_CELLS, 3):
        return None
    return pixels  # type: ignore[return-value]


def nearest_first(keys: list[TileKey], north: float, east: float) -> list[TileKey]:
    """Return tiles by the distance of their centres from a place."""
    return sorted(keys, key=lambda k: math.hypot(-(k[0] + 0.5) * TILE_M - north, (k[1] + 0.5) * TILE_M - east))
