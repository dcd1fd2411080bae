"""A rectangle of map cells: where it lies, which tiles it meets, and how a ground picture is laid on it.

Global cells count southwards (rows) and eastwards (columns) from the datum: the centre of cell (r, c) of side ``s``
lies at north = -(r + 0.5) s, east = (c + 0.5) s, which is how `hawk.model.TileKey` counts tiles.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hawk.model import TILE_M, TileKey

Slices = tuple[slice, slice]
_BLOCK = 8


@dataclass(frozen=True, slots=True)
class Window:
    """``rows`` x ``columns`` cells of ``cell_m`` metres, beginning at the global cell (``row``, ``column``)."""

    row: int
    column: int
    rows: int
    columns: int
    cell_m: float

    @classmethod
    def around(cls, points: NDArray[np.float64], cell_m: float, margin_m: float = 0.0) -> Window:
        """Return the smallest window that holds the points (N, 2) of (north, east) metres with a margin."""
        north, east = points[:, 0], points[:, 1]
        top = math.floor((-float(north.max()) - margin_m) / cell_m)
        left = math.floor((float(east.min()) - margin_m) / cell_m)
        bottom = math.ceil((-float(north.min()) + margin_m) / cell_m)
        right = math.ceil((float(east.max()) + margin_m) / cell_m)
        return cls(top, left, max(bottom - top, 1), max(right - left, 1), cell_m)

    def aligned(self, step: int) -> Window:
        """Return the smallest window around this one whose bounds are multiples of ``step`` cells."""
        top, left = self.row // step * step, self.column // step * step
        bottom, right = -(-(self.row + self.rows) // step) * step, -(-(self.column + self.columns) // step) * step
        return Window(top, left, bottom - top, right - left, self.cell_m)

    def grown(self, cells: int) -> Window:
        """Return the window with so many more cells on every side."""
        return Window(
            self.row - cells, self.column - cells, self.rows + 2 * cells, self.columns + 2 * cells, self.cell_m
        )

    def part(self, inner: Window) -> Slices:
        """Return where a window of the same cells that lies inside this one is found in its arrays."""
        top, left = inner.row - self.row, inner.column - self.column
        return slice(top, top + inner.rows), slice(left, left + inner.columns)

    @property
    def middle(self) -> tuple[float, float]:
        """(north, east) of the middle, metres."""
        return -(self.row + self.rows / 2) * self.cell_m, (self.column + self.columns / 2) * self.cell_m

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns)."""
        return self.rows, self.columns

    @property
    def tile_cells(self) -> int:
        """Cells of this size along one side of a tile."""
        return round(TILE_M / self.cell_m)

    def holds(self, place: tuple[float, float]) -> bool:
        """Return whether a place (north, east) lies inside."""
        row, column = -place[0] / self.cell_m - self.row, place[1] / self.cell_m - self.column
        return 0 <= row < self.rows and 0 <= column < self.columns

    def cells_of(self, north: NDArray[np.float64], east: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return window coordinates (..., 2) of (column, row), whole numbers at cell centres."""
        column = east / self.cell_m - self.column - 0.5
        row = -north / self.cell_m - self.row - 0.5
        return np.stack([column, row], -1)

    def affine(self, to_map: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the (2, 3) affine from source pixels (column, row) to this window's (column, row).

        ``to_map`` gives (north, east) metres of (column, row, 1); whole pixel coordinates are centres on both sides.
        """
        result = np.stack([to_map[1], -to_map[0]]) / self.cell_m
        result[:, 2] -= (self.column + 0.5, self.row + 0.5)
        return result

    def tiles(self) -> Iterator[tuple[TileKey, Slices, Slices]]:
        """Yield each tile that the window meets: its key, the part of the tile, and the part of the window."""
        n = self.tile_cells
        for tile_row in range(self.row // n, (self.row + self.rows - 1) // n + 1):
            for tile_column in range(self.column // n, (self.column + self.columns - 1) // n + 1):
                top, bottom = max(self.row, tile_row * n), min(self.row + self.rows, (tile_row + 1) * n)
                left, right = max(self.column, tile_column * n), min(self.column + self.columns, (tile_column + 1) * n)
                in_tile = (
                    slice(top - tile_row * n, bottom - tile_row * n),
                    slice(left - tile_column * n, right - tile_column * n),
                )
                in_window = (slice(top - self.row, bottom - self.row), slice(left - self.column, right - self.column))
                yield (tile_row, tile_column), in_tile, in_window


def tile_window(key: TileKey, cell_m: float) -> Window:
    """Return the window that covers one tile."""
    n = round(TILE_M / cell_m)
    return Window(key[0] * n, key[1] * n, n, n, cell_m)


def shard_of_tile(key: TileKey) -> TileKey:
    """Return the block of tiles to which a tile belongs: what changes at a time lies close together."""
    return key[0] // _BLOCK, key[1] // _BLOCK
