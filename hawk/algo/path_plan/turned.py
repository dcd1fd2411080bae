"""The field in a heading's own axes: rows lie along the heading, columns across it (to the right)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.path_plan.field import InformationField

Place = tuple[float, float]
Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Axes:
    """A grid turned to a heading (radians from north).

    Cell (row, column) lies ``row - behind`` cells ahead of the place and ``column - left`` to its right.
    """

    place: Place
    heading: float
    cell_m: float
    behind: float
    left: float

    def place_of(self, row: float, column: float) -> Place:
        """Return (north, east) of a cell."""
        ahead, right = (row - self.behind) * self.cell_m, (column - self.left) * self.cell_m
        c, s = math.cos(self.heading), math.sin(self.heading)
        return self.place[0] + ahead * c - right * s, self.place[1] + ahead * s + right * c

    def turned(
        self,
        field: InformationField,
        values: NDArray[np.float32] | NDArray[np.uint8],
        shape: tuple[int, int],
        interpolation: int = cv2.INTER_LINEAR,
    ) -> NDArray[np.float32]:
        """Return a layer of the field on this grid, 0 outside the field."""
        column, row = field.window.cells_of(np.array(self.place[0]), np.array(self.place[1]))
        c, s = math.cos(self.heading), math.sin(self.heading)
        ahead, right = np.array([s, -c]), np.array([c, s])  # one cell on, in the field's (column, row)
        origin = np.array([column, row]) - self.behind * ahead - self.left * right
        affine = np.column_stack([right, ahead, origin])
        size = (shape[1], shape[0])
        result = cv2.warpAffine(values, affine, size, flags=interpolation | cv2.WARP_INVERSE_MAP)
        return np.asarray(result, dtype=np.float32)
