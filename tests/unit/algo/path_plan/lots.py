"""Known lots drawn as text for the tests of routes: a character is a coarse cell."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import shapely
from numpy.typing import NDArray

from hawk.algo.ground import COARSE_M, CoarseLayers, Window
from hawk.model.lot_map import Stall
from hawk.model.plans import Fence, Inbound
from hawk.model.poses import MapPoint


class DrawnLot:
    """A map whose lot is an array of booleans, cell (0, 0) of the map at its upper left; ``asked`` counts cells."""

    def __init__(self, lot: NDArray[np.bool_]) -> None:
        self.lot = lot.copy()
        self.asked = 0

    @classmethod
    def of(cls, *rows: str, scale: int = 1) -> DrawnLot:
        cells = np.array([[character == "#" for character in row] for row in rows])
        return cls(np.repeat(np.repeat(cells, scale, 0), scale, 1))

    def coarse(self, window: Window) -> CoarseLayers:
        self.asked += window.rows * window.columns
        share = np.zeros(window.shape, np.float32)
        rows, columns = window.row + np.arange(window.rows), window.column + np.arange(window.columns)
        r, c = (rows >= 0) & (rows < self.lot.shape[0]), (columns >= 0) & (columns < self.lot.shape[1])
        share[np.ix_(r, c)] = self.lot[np.ix_(rows[r], columns[c])]
        return CoarseLayers(window, share, share, share, share)

    def known_extent(self) -> NDArray[np.float64] | None:
        rows, columns = self.lot.shape
        return np.array([[-rows * COARSE_M, 0.0], [0.0, columns * COARSE_M]])

    def lot_area_m2(self) -> float:
        return float(self.lot.sum()) * COARSE_M**2

    def inbound(self, north: float, east: float) -> Inbound:
        return Inbound.UNKNOWN

    def unclear_stalls(self) -> Mapping[int, Stall]:
        return {}

    def area(self) -> shapely.Geometry:
        """The lot's cells as a shape in (row, column), a hair wider so that its own border counts as inside."""
        rows, columns = np.nonzero(self.lot)
        return shapely.union_all(shapely.box(rows, columns, rows + 1, columns + 1)).buffer(1e-6)


def place_in(row: float, column: float) -> tuple[float, float]:
    """Return (north, east) of the middle of a cell."""
    return -(row + 0.5) * COARSE_M, (column + 0.5) * COARSE_M


def line_of(points: tuple[MapPoint, ...]) -> shapely.LineString:
    """Return the points as a line in (row, column)."""
    return shapely.LineString([(-p.north / COARSE_M, p.east / COARSE_M) for p in points])


def fence_of(top: float, left: float, bottom: float, right: float) -> Fence:
    """Return a fence along borders of cells."""
    rows = ((top, left), (top, right), (bottom, right), (bottom, left))
    polygon = tuple((-row * COARSE_M, column * COARSE_M) for row, column in rows)
    return Fence(polygon, polygon, 60.0, 63.0)
