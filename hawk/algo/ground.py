"""The ground grid that mapper and planner share: windows of cells, coarse layers, and the map that the planner reads.

Global cells count southwards (rows) and eastwards (columns) from the datum: the centre of cell (r, c) of side ``s``
lies at north = -(r + 0.5) s, east = (c + 0.5) s, which is how `hawk.model.lot_map.TileKey` counts tiles.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from hawk.model.lot_map import TILE_M, Stall, TileKey
from hawk.model.plans import Inbound

COARSE_M: Final = 1.6
"""Side of a cell of the coarse layers for planning, metres: a whole number of evidence cells, and of cells a tile."""
_SHARD_TILES: Final = 8  # tiles a side

Place = tuple[float, float]
"""(north, east), metres in the map frame."""
Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Indices = NDArray[np.intp]
Grid = NDArray[np.float32]
Mask = NDArray[np.uint8]
Slices = tuple[slice, slice]


@dataclass(frozen=True, slots=True)
class Window:
    """``rows`` x ``columns`` cells of ``cell_m`` metres, beginning at the global cell (``row``, ``column``)."""

    row: int
    column: int
    rows: int
    columns: int
    cell_m: float

    @classmethod
    def around(cls, points: Floats, cell_m: float, margin_m: float = 0.0) -> Window:
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
        """Return the window with this number of cells more on every side."""
        return Window(
            self.row - cells, self.column - cells, self.rows + 2 * cells, self.columns + 2 * cells, self.cell_m
        )

    def joined(self, other: Window) -> Window:
        """Return the smallest window that holds this one and another one of the same cells."""
        top, left = min(self.row, other.row), min(self.column, other.column)
        bottom = max(self.row + self.rows, other.row + other.rows)
        right = max(self.column + self.columns, other.column + other.columns)
        return Window(top, left, bottom - top, right - left, self.cell_m)

    def part(self, inner: Window) -> Slices:
        """Return the slices of this window's arrays that a window of the same cells inside it covers."""
        top, left = inner.row - self.row, inner.column - self.column
        return slice(top, top + inner.rows), slice(left, left + inner.columns)

    @property
    def middle(self) -> Place:
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

    def holds(self, place: Place) -> bool:
        """Return True when a place lies inside."""
        row, column = -place[0] / self.cell_m - self.row, place[1] / self.cell_m - self.column
        return 0 <= row < self.rows and 0 <= column < self.columns

    def cells_of(self, north: Floats, east: Floats) -> Floats:
        """Return window coordinates (..., 2) of (column, row), whole numbers at cell centres."""
        column = east / self.cell_m - self.column - 0.5
        row = -north / self.cell_m - self.row - 0.5
        return np.stack([column, row], -1)

    def cells_at(self, places: Floats) -> tuple[Indices, Indices, Bools]:
        """Return rows and columns (N,) of the cells at places (N, 2), and True for the places inside the window.

        Places outside get the cell (0, 0).
        """
        cells: Indices = np.round(self.cells_of(places[:, 0], places[:, 1])).astype(np.intp)
        within = (cells >= 0) & (cells < (self.columns, self.rows))
        inside: Bools = within[:, 0] & within[:, 1]
        columns, rows = np.where(inside[:, None], cells, 0).T
        return rows, columns, inside

    def values_at(self, layer: NDArray[Any], places: Floats) -> NDArray[Any]:
        """Return the values (N,) of the window's cells ``layer`` at places (N, 2), 0 outside."""
        rows, columns, inside = self.cells_at(places)
        return np.where(inside, layer[rows, columns], 0)

    def centres(self, rows: NDArray[Any], columns: NDArray[Any]) -> tuple[Floats, Floats]:
        """Return (north, east) of the centres of cells, metres; fractions of cells are allowed."""
        return -(self.row + rows + 0.5) * self.cell_m, (self.column + columns + 0.5) * self.cell_m

    def affine(self, to_map: Floats) -> Floats:
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
    """Return the window of cells of ``cell_m`` metres that covers one tile."""
    n = round(TILE_M / cell_m)
    return Window(key[0] * n, key[1] * n, n, n, cell_m)


def shard_of_tile(key: TileKey) -> TileKey:
    """Return the block of tiles to which a tile belongs: tiles that change together lie close together."""
    return key[0] // _SHARD_TILES, key[1] // _SHARD_TILES


@dataclass(frozen=True, slots=True)
class CoarseLayers:
    """Shares (0..1) over a window of coarse cells: ``lot``, ``seen`` at all, ``well`` seen, and ``likely``.

    ``likely`` is ground that looks like lot, with stalls near it or without.
    """

    window: Window
    lot: Grid
    seen: Grid
    well: Grid
    likely: Grid


class LotMap(Protocol):
    """The map as the planner reads it; the Mapper App implements it."""

    def coarse(self, window: Window) -> CoarseLayers:
        """Return the coarse layers over a window of `COARSE_M` cells."""
        ...

    def known_extent(self) -> Floats | None:
        """Return two corners (2, 2) of (north, east) around everything seen, None before the first frame."""
        ...

    def lot_area_m2(self) -> float:
        """Return the area of known lot, square metres."""
        ...

    def inbound(self, north: float, east: float) -> Inbound:
        """Return the verdict on a place (metres, map frame)."""
        ...

    def unclear_stalls(self) -> Mapping[int, Stall]:
        """Return the valid stalls with unknown state, by id."""
        ...


@runtime_checkable
class KnownMap(Protocol):
    """A map onto which the plan of each known lot comes once its place is certain; the Mapper App implements it."""

    def plan_places(self, lot: str) -> Floats | None:
        """Return the stalls (N, 5) of the plan of a lot, by its id: north, east, angle, width, length; None before."""
        ...

    def stalls_near(self, north: float, east: float, radius: float) -> list[Stall]:
        """Return the valid stalls within a radius (metres) of a place near the drone."""
        ...
