"""The picture of the lot: tiles of pixels, put together from the camera's pictures while the drone flies.

Each pixel is sampled once, from the camera's picture. Of each place the best view is shown: from nearest to straight
above, far from the picture's edge, from low. A better view replaces another one by areas
(`hawk.algo.mapper.blending`). Only tiles near the drone are kept as pixels, the others as JPEG
(`hawk.model.tile_picture`).
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.ground import Slices, Window, shard_of_tile
from hawk.algo.mapper.blending import (
    BLOCK,
    Alignment,
    Blend,
    Exposure,
    Patch,
    View,
    blend_of,
    blocks_of,
    enlarged,
    view_cost,
    view_of,
)
from hawk.algo.mapper.delta import Recent
from hawk.algo.mapper.evidence import outline, quality_mask, warp
from hawk.algo.vision.detection import GroundImage
from hawk.model.lot_map import CELL_M, TILE_CELLS, EncodedTile, TileKey
from hawk.model.shards import Sharded
from hawk.model.tile_picture import Mask, Picture, decode_picture, encode_picture, has_mask

EDGE_M: Final = 0.5
"""Border of a picture that is not used."""
_SIDE: Final = TILE_CELLS // BLOCK
_LOADED: Final = 24  # tiles kept as pixels
_EARLIER: Final = 1e3  # cost of a view of an earlier run: any other one is better

Watch = Callable[[TileKey, Slices, NDArray[np.float32]], None]
"""Gets a tile's key, the part of it and the weights (0..1) with which a picture was blended into it."""


@dataclass(slots=True)
class Pixels:
    """A loaded tile: BGR (256, 256, 3), and where it was seen."""

    values: Picture = field(default_factory=lambda: np.zeros((TILE_CELLS, TILE_CELLS, 3), np.uint8))
    seen: Mask = field(default_factory=lambda: np.zeros((TILE_CELLS, TILE_CELLS), np.uint8))


@dataclass(slots=True)
class Blocks:
    """Values that are kept of every tile, by blocks of `BLOCK` pixels a side, (32, 32).

    ``cost`` of the view shown, infinite where the block was not seen as a whole; ``covered`` share of it that was seen,
    0..255; ``colour`` mean BGR.
    """

    cost: NDArray[np.float16] = field(default_factory=lambda: np.full((_SIDE, _SIDE), np.inf, np.float16))
    covered: NDArray[np.uint8] = field(default_factory=lambda: np.zeros((_SIDE, _SIDE), np.uint8))
    colour: NDArray[np.uint8] = field(default_factory=lambda: np.zeros((_SIDE, _SIDE, 3), np.uint8))

    def renew(self, tile: Pixels) -> None:
        """Bring shares and colours up to date."""
        self.covered[:] = cv2.resize(tile.seen, (_SIDE, _SIDE), interpolation=cv2.INTER_AREA)
        self.colour[:] = cv2.resize(tile.values, (_SIDE, _SIDE), interpolation=cv2.INTER_AREA)


@dataclass(frozen=True, slots=True)
class Addition:
    """A picture that is blended into the mosaic, tile by tile.

    ``inside`` (255 where it may be used) covers the cells of the window of ``blocks``; ``change`` is added to its
    colours, ``cost`` is that of `view_cost`, both by blocks.
    """

    view: View
    blocks: Window
    inside: Mask
    blend: Blend
    change: NDArray[np.float32]
    cost: NDArray[np.float32]

    def pixels(self, part: Slices) -> Picture:
        """Return the picture on the cells of a part of the blocks."""
        rows, columns = part
        top, left = self.blocks.row + rows.start, self.blocks.column + columns.start
        size = ((rows.stop - rows.start) * BLOCK, (columns.stop - columns.start) * BLOCK)
        sampled = self.view.sampled(Window(top * BLOCK, left * BLOCK, *size, CELL_M))
        return np.asarray(cv2.add(sampled, enlarged(self.change, part), dtype=cv2.CV_8U), np.uint8)


class Mosaic:
    """Picture tiles of `TILE_CELLS` pixels a side."""

    def __init__(self, watch: Watch | None = None) -> None:
        """``watch`` gets the weights of every blending, for measurements."""
        self.encoded: Sharded[TileKey, EncodedTile] = Sharded(shard_of_tile)
        self.recent: Recent[TileKey] = Recent()
        self._watch = watch
        self._blocks: dict[TileKey, Blocks] = {}
        self._pixels: dict[TileKey, Pixels] = {}
        """Of the loaded tiles, the least recently used first."""
        self._dirty: dict[TileKey, None] = {}
        self._exposure = Exposure()
        self._alignment = Alignment()
        self._addition: Addition | None = None
        self._waiting: list[tuple[TileKey, Slices, Slices]] = []

    def add(self, picture: GroundImage, below: tuple[float, float], height: float, most: int | None = None) -> None:
        """Add a picture, taken ``height`` metres above the place ``below`` (north, east).

        ``most`` tiles are changed at once, all by default; `go_on` changes the others, and so does the next picture.
        """
        self.go_on(None)
        mask = quality_mask(picture.valid, picture.metres_per_pixel, EDGE_M, 1.0)
        if not mask.any():
            return
        window = Window.around(outline(picture), CELL_M).aligned(BLOCK).grown(2 * BLOCK)
        inside = np.asarray(warp(picture, np.where(mask > 0, 255, 0).astype(np.uint8), window, cv2.INTER_NEAREST))
        blocks = blocks_of(window)
        covered = np.asarray(cv2.resize(inside, blocks.shape[::-1], interpolation=cv2.INTER_AREA), np.uint8)
        known = self._known(blocks)
        view = view_of(picture)
        cost = view_cost(view, blocks, covered, below, height)
        blend = blend_of(known.cost, known.covered, cost, covered)
        if blend is None:
            return
        both = (known.covered == 255) & (covered == 255)
        view, colours = self._exposure.matched(view, blocks, both, known.colour)
        patch = self._patch(both, blocks, below)
        if patch is not None:
            view = self._alignment.aligned(view, patch)
        self._waiting = list(blocks.tiles())
        self._addition = Addition(view, blocks, inside, blend, blend.change(known.colour, colours, both), cost)
        self.go_on(most)

    def go_on(self, most: int | None) -> bool:
        """Blend the picture that was added last into the next ``most`` of its tiles; return True when there was one."""
        changed = 0
        while self._addition is not None and self._waiting and (most is None or changed < most):
            changed += self._blend_into(self._addition, *self._waiting.pop(0))
        if not self._waiting:
            self._addition = None
        return changed > 0

    def encode(self, most: int, version: int) -> bool:
        """Encode the ``most`` longest waiting tiles; return True when there was one."""
        keys = list(itertools.islice(self._dirty, most))
        news: dict[TileKey, EncodedTile] = {}
        for key in keys:
            del self._dirty[key]
            tile = self._loaded(key)
            news[key] = EncodedTile(version, encode_picture(tile.values, tile.seen))
            self.recent.note(key, version)
        self.encoded = self.encoded.changed(news)
        self._evict()
        return bool(keys)

    @property
    def loaded(self) -> int:
        """Number of tiles that are kept as pixels."""
        return len(self._pixels)

    def restore(self, key: TileKey, version: int, data: bytes) -> None:
        """Restore a tile of an earlier run. Raises ValueError when the picture cannot be read."""
        tile = Pixels(*decode_picture(data))
        if not has_mask(data):
            data = encode_picture(tile.values, tile.seen)
        self.encoded = self.encoded.changed({key: EncodedTile(version, data)})
        self.recent.note(key, version)
        blocks = Blocks()
        blocks.renew(tile)
        blocks.cost[blocks.covered == 255] = _EARLIER
        self._blocks[key] = blocks

    def _known(self, window: Window) -> Blocks:
        """Return what is kept of a window of blocks."""
        shape = window.shape
        found = Blocks(np.full(shape, np.inf, np.float16), np.zeros(shape, np.uint8), np.zeros((*shape, 3), np.uint8))
        for key, in_tile, in_window in window.tiles():
            known = self._blocks.get(key)
            if known is not None:
                found.cost[in_window] = known.cost[in_tile]
                found.covered[in_window] = known.covered[in_tile]
                found.colour[in_window] = known.colour[in_tile]
        return found

    def _patch(self, both: NDArray[np.bool_], blocks: Window, below: tuple[float, float]) -> Patch | None:
        """Return the square of the mosaic that a new picture is aligned with, None where they share none."""
        window = Alignment.place(both, blocks, below)
        if window is None:
            return None
        values = np.zeros((*window.shape, 3), np.uint8)
        for key, in_tile, in_window in window.tiles():
            if key in self._blocks:
                values[in_window] = self._loaded(key).values[in_tile]
        return Patch(window, values)

    def _blend_into(self, addition: Addition, key: TileKey, in_tile: Slices, in_window: Slices) -> bool:
        """Blend a picture into one tile; return False where it changes nothing of it."""
        box = _box(addition.blend.used[in_window])
        if box is None:
            return False
        part, blocks_in_tile = _within(in_window, box), _within(in_tile, box)
        place = _finer(blocks_in_tile)
        tile = self._loaded(key)
        values, seen = tile.values[place], tile.seen[place]
        weight = enlarged(addition.blend.weight, part)
        weight[seen == 0] = 1.0
        weight[addition.inside[_finer(part)] == 0] = 0.0
        values[:] = cv2.blendLinear(addition.pixels(part), np.ascontiguousarray(values), weight, 1 - weight)
        seen[weight > 0] = 255
        known = self._blocks.setdefault(key, Blocks())
        before = known.covered[blocks_in_tile] == 255
        known.renew(tile)
        shown = (known.covered[blocks_in_tile] == 255) & ((addition.blend.weight[part] > 0.5) | ~before)
        known.cost[blocks_in_tile][shown] = addition.cost[part][shown]
        self._dirty.setdefault(key)
        if self._watch is not None:
            self._watch(key, place, weight)
        return True

    def _loaded(self, key: TileKey) -> Pixels:
        tile = self._pixels.pop(key, None)
        if tile is None:
            known = self.encoded.get(key)
            tile = Pixels() if known is None else Pixels(*decode_picture(known.data))
        self._pixels[key] = tile
        return tile

    def _evict(self) -> None:
        for key in list(itertools.islice(self._pixels, max(len(self._pixels) - _LOADED, 0))):
            if key not in self._dirty:
                del self._pixels[key]


def _box(used: NDArray[np.bool_]) -> Slices | None:
    """Return the rectangle about all that is used, None for nothing."""
    rows, columns = np.flatnonzero(used.any(1)), np.flatnonzero(used.any(0))
    if len(rows) == 0:
        return None
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)


def _within(outer: Slices, box: Slices) -> Slices:
    rows, columns = (slice(o.start + b.start, o.start + b.stop) for o, b in zip(outer, box, strict=True))
    return rows, columns


def _finer(part: Slices) -> Slices:
    rows, columns = (slice(s.start * BLOCK, s.stop * BLOCK) for s in part)
    return rows, columns
