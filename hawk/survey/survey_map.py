"""The map of a finished survey as the exports and the scoring see it."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.model import CELL_M, TILE_CELLS, TILE_M, Cell, Counts, GlobalPose, Stall, StallState, TileKey
from hawk.stall_exports import to_global


@dataclass(frozen=True, slots=True)
class Raster:
    """Cells of a rectangle of the map: row 0 is its north edge, column 0 its west edge.

    ``north`` and ``east`` are the map coordinates (metres) of the north-west corner, ``cell_m`` the side of a cell.
    """

    values: NDArray[np.uint8]
    north: float
    east: float
    cell_m: float

    def to_pixels(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return (N, 2) of (north, east) as (column, row), pixel centres at whole numbers plus a half."""
        return np.column_stack(((points[:, 1] - self.east) / self.cell_m, (self.north - points[:, 0]) / self.cell_m))


@dataclass(frozen=True, slots=True)
class SurveyMap:
    """Stalls and cells of a survey in the map frame, and the WGS-84 place of its origin."""

    datum: GlobalPose
    stalls: Mapping[int, Stall]
    tiles: Mapping[TileKey, NDArray[np.uint8]]
    mosaic: Mapping[TileKey, bytes] = field(default_factory=dict, repr=False)

    @property
    def counts(self) -> Counts:
        """Stalls by state."""
        states = [stall.state for stall in self.stalls.values()]
        return Counts(states.count(StallState.FREE), states.count(StallState.TAKEN), states.count(StallState.UNKNOWN))

    def to_global(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return (N, 2) of (north, east) metres as (latitude, longitude) degrees."""
        return to_global(self.datum, points)

    def cells(self) -> Raster:
        """Return all tiles as one picture of `Cell` values; a single unknown cell when nothing was seen."""
        if not self.tiles:
            return Raster(np.zeros((1, 1), np.uint8), 0.0, 0.0, CELL_M)
        north, east, shape = self._extent(self.tiles)
        values = np.full(shape, Cell.UNKNOWN, np.uint8)
        for key, tile in self.tiles.items():
            values[self._window(key, north, east)] = tile
        return Raster(values, north, east, CELL_M)

    def picture(self) -> tuple[NDArray[np.uint8], Raster]:
        """Return the mosaic (BGR, black where nothing was seen) over the same extent as `cells`, and those cells."""
        cells = self.cells()
        picture = np.zeros((*cells.values.shape, 3), np.uint8)
        for key, jpeg in self.mosaic.items():
            tile = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
            if tile is None or key not in self.tiles:
                continue
            picture[self._window(key, cells.north, cells.east)] = cv2.resize(tile, (TILE_CELLS, TILE_CELLS))
        return picture, cells

    @staticmethod
    def _extent(keys: Mapping[TileKey, object]) -> tuple[float, float, tuple[int, int]]:
        rows = [row for row, _ in keys]
        columns = [column for _, column in keys]
        shape = ((max(rows) - min(rows) + 1) * TILE_CELLS, (max(columns) - min(columns) + 1) * TILE_CELLS)
        return -min(rows) * TILE_M, min(columns) * TILE_M, shape

    @staticmethod
    def _window(key: TileKey, north: float, east: float) -> tuple[slice, slice]:
        top = (key[0] + round(north / TILE_M)) * TILE_CELLS
        left = (key[1] - round(east / TILE_M)) * TILE_CELLS
        return slice(top, top + TILE_CELLS), slice(left, left + TILE_CELLS)


def unpack_tiles(tiles: Mapping[TileKey, bytes]) -> dict[TileKey, NDArray[np.uint8]]:
    """Return tiles as they are sent (zlib of TILE_CELLS x TILE_CELLS bytes) as arrays of `Cell` values.

    Raises ValueError naming a tile that is not one.
    """
    unpacked = {}
    for key, data in tiles.items():
        try:
            cells = np.frombuffer(zlib.decompress(data), np.uint8)
            unpacked[key] = cells.reshape(TILE_CELLS, TILE_CELLS)
        except (zlib.error, ValueError) as error:
            raise ValueError(f"tile {key}: {error}") from None
    return unpacked
