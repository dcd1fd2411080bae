"""The map as it is sent: classes of `TILE_CELLS` x `TILE_CELLS` cells a tile, compressed where something changed."""

from __future__ import annotations

import zlib

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.mapper.evidence import EVIDENCE_M
from hawk.algo.mapper.grid import EvidenceGrid
from hawk.algo.mapper.mosaic import nearest_first
from hawk.algo.mapper.table import FREE, TAKEN, Rows, corners_of
from hawk.algo.mapper.window import Window, shard_of_tile, tile_window
from hawk.model import CELL_M, TILE_M, Cell, EncodedTile, TileKey
from hawk.sharded import Sharded

_FINER = round(EVIDENCE_M / CELL_M)
_REACH_M = 5.0  # half the diagonal of the longest stall
_SHIFT = 4  # bits of fraction in polygon corners
_CELLS = ((FREE, Cell.FREE), (TAKEN, Cell.TAKEN))


class TileEncoder:
    """Keeps the encoded tiles and what waits to be encoded."""

    def __init__(self) -> None:
        self.encoded: Sharded[TileKey, EncodedTile] = Sharded(shard_of_tile)
        self._waiting: set[TileKey] = set()

    def mark(self, keys: set[TileKey]) -> None:
        """Tell that something in these tiles may have changed."""
        self._waiting |= keys

    def mark_around(self, corners: NDArray[np.float64]) -> None:
        """Tell that stalls with these corners (N, 4, 2) changed, came or went."""
        rows = np.floor(-corners[..., 0] / TILE_M).astype(int)
        columns = np.floor(corners[..., 1] / TILE_M).astype(int)
        self._waiting |= set(zip(rows.ravel().tolist(), columns.ravel().tolist(), strict=True))

    def next_tiles(self, most: int, near: tuple[float, float]) -> list[TileKey]:
        """Return the tiles that are encoded next, at most so many: those nearest to a place."""
        return nearest_first(list(self._waiting), *near)[:most]

    def encode(self, grid: EvidenceGrid, stalls: Rows, most: int, version: int, near: tuple[float, float]) -> bool:
        """Encode the waiting tiles nearest to a place, at most so many; return whether one shows something new.

        ``stalls`` are all that may lie on them.
        """
        news: dict[TileKey, EncodedTile] = {}
        for key in self.next_tiles(most, near):
            self._waiting.discard(key)
            known = self.encoded.get(key)
            if known is None and key not in grid.tiles:
                continue
            data = zlib.compress(raster(grid, key, stalls).tobytes(), 1)
            if known is None or known.data != data:
                news[key] = EncodedTile(version, data)
        self.encoded = self.encoded.changed(news)
        return bool(news)


def raster(grid: EvidenceGrid, key: TileKey, stalls: Rows) -> NDArray[np.uint8]:
    """Return the `Cell` classes of one tile with its stalls drawn in."""
    tile = grid.tile(key)
    n = round(TILE_M / CELL_M)
    cells = np.zeros((n, n), np.uint8) if tile is None else np.repeat(np.repeat(tile.shown, _FINER, 0), _FINER, 1)
    window = tile_window(key, CELL_M)
    near = stalls[_meets(stalls, key)]
    if len(near) == 0:
        return cells
    corners = corners_of(near)
    for state, cell in _CELLS:
        _draw(cells, corners[near["state"] == state], window, cell)
    return cells


def _meets(stalls: Rows, key: TileKey) -> NDArray[np.bool_]:
    middle_north, middle_east = -(key[0] + 0.5) * TILE_M, (key[1] + 0.5) * TILE_M
    reach = TILE_M / 2 + _REACH_M
    return np.asarray((np.abs(stalls["north"] - middle_north) < reach) & (np.abs(stalls["east"] - middle_east) < reach))


def _draw(cells: NDArray[np.uint8], corners: NDArray[np.float64], window: Window, cell: Cell) -> None:
    if len(corners):
        points = window.cells_of(corners[..., 0], corners[..., 1])
        fixed = np.round(points * (1 << _SHIFT)).astype(np.int32)
        cv2.fillPoly(cells, list(fixed), [int(cell)], shift=_SHIFT)
