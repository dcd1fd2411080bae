"""Cars as boxes: connected cells of car evidence that have the size and the fill of one car.

Two cars that touch at a low level of evidence are often apart at a higher one, so that parts which are no car by
themselves are looked at again at the next level.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.ground import Floats, Grid, Mask, Window

LEVELS: Final = (0.5, 0.7, 0.85)
"""Mean car probability of a cell."""
WIDTH_M: Final = (1.3, 2.6)
LENGTH_M: Final = (3.2, 6.2)
"""From a city car to a van, mirrors and a cell's rounding included."""
_Box = tuple[float, float, float, float, float]
_FILL = 0.7  # of its box: a car seen from above is a rounded rectangle, a bent blob is none


@dataclass(frozen=True, slots=True)
class CarBoxes:
    """Boxes as arrays of length N, metres and radians: ``angle`` is the direction of the long side in [0, pi)."""

    north: Floats
    east: Floats
    angle: Floats
    width: Floats
    length: Floats

    def __len__(self) -> int:
        return len(self.north)

    def take(self, which: NDArray[np.bool_] | NDArray[np.intp]) -> CarBoxes:
        """Return some of them."""
        return CarBoxes(*(getattr(self, f.name)[which] for f in fields(self)))


def car_boxes(car: Grid, window: Window) -> CarBoxes:
    """Return the cars of a window of cells, of which ``car`` (rows, columns) is the probability (0..1) of a car.

    A car that the window cuts is none: set ``car`` to 0 where nothing was seen.
    """
    boxes: list[_Box] = []
    left = np.ones(car.shape, np.bool_)
    for level in LEVELS:
        above = ((car > level) & left).astype(np.uint8)
        count, labels, stats, _ = cv2.connectedComponentsWithStats(above, connectivity=4)
        found = {label: box for label in range(1, count) if (box := _box(labels, label, stats[label], window.cell_m))}
        boxes += found.values()
        is_car = np.zeros(count, np.bool_)
        is_car[list(found)] = True
        left &= ~is_car[labels]
    column, row, across, width, length = np.array(boxes, np.float64).reshape(-1, 5).T
    north, east = window.centres(row, column)
    return CarBoxes(north, east, across, width, length)


def _box(labels: NDArray[Any], label: int, stats: NDArray[Any], cell_m: float) -> _Box | None:
    """Return (column, row, map angle, width, length) of one connected part, None when it is no whole car."""
    left, top, wide, high, cells = (int(value) for value in stats[: cv2.CC_STAT_AREA + 1])
    least, most = (np.prod(sizes) / cell_m**2 for sizes in zip(WIDTH_M, LENGTH_M, strict=True))
    at_border = left == 0 or top == 0 or left + wide == labels.shape[1] or top + high == labels.shape[0]
    if at_border or not least * _FILL <= cells <= most:
        return None
    mask: Mask = (labels[top : top + high, left : left + wide] == label).astype(np.uint8)
    (x, y), sides, degrees = cv2.minAreaRect(cv2.findNonZero(mask))
    first, second = (side + 1 for side in sides)  # from the outermost cells' centres to their edges
    width, length = min(first, second) * cell_m, max(first, second) * cell_m
    fits = WIDTH_M[0] <= width <= WIDTH_M[1] and LENGTH_M[0] <= length <= LENGTH_M[1]
    if not fits or cells < _FILL * first * second:
        return None
    turn = np.radians(degrees + (0 if first >= second else 90))  # of the long side, from column to row
    angle = float(np.arctan2(np.cos(turn), -np.sin(turn)) % np.pi)  # rows run south, columns east
    return x + left, y + top, angle, width, length
