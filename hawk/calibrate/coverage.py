"""Which views of the board are there, and which one is to be shown next.

A calibration is as good as its views: corners in all parts of the picture show the distortion, tilted boards separate
the focal length from the distance, near and far ones the centre from the tilt.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

CELLS: Final = (4, 3)
"""Parts of the picture across and down."""
CELL_CORNERS: Final = 8
"""Corners, of all views, that a part of the picture needs."""
LEAST_VIEWS: Final = 15
TILTED: Final = math.radians(20)
"""A board that leans by so much counts as tilted."""
NEAR: Final = 0.6
FAR: Final = 0.4
"""Share of the picture's width or height, the larger one, that the board spans: near from the one on, far up to the
other."""
_DIFFERENT = 0.2  # of the sum of differences of place, size and tilt (radians), as ROS's calibrator has it

_ROWS = ("upper", "middle", "lower")
_COLUMNS = ("left", "left of the middle", "right of the middle", "right")
_LEANS = ("left", "right", "top", "bottom")


@dataclass(frozen=True, slots=True)
class View:
    """A view of the board.

    ``corners`` (N, 2): pixels of those of its corners that are seen, ``ids`` (N,) their numbers. ``place``: middle of
    the corners, shares of the picture's width and height. ``size``: `NEAR`'s share. ``lean``: radians by which the
    board's right edge is farther away than its left, and its lower edge than its upper.
    """

    corners: Floats = field(repr=False)
    ids: NDArray[np.int32] = field(repr=False)
    place: tuple[float, float]
    size: float
    lean: tuple[float, float]

    def differs(self, other: View) -> bool:
        """Return True when this view adds something to the other."""
        mine, its = (np.array([*view.place, view.size, *view.lean]) for view in (self, other))
        return float(np.abs(mine - its).sum()) >= _DIFFERENT


@dataclass(frozen=True, slots=True)
class Coverage:
    """Parts, tilts and distances that the views show. ``cells`` (rows, columns): corners by part of the picture."""

    cells: NDArray[np.int64] = field(repr=False)
    leans: tuple[bool, bool, bool, bool]
    """True where a view leans so: its left, right, top, bottom edge is the near one."""
    is_near: bool
    is_far: bool
    views: int

    @property
    def missing(self) -> str:
        """Next view to show, in words; empty when everything is there."""
        if not self.views:
            return "hold the board into the picture, still and in even light"
        rows, columns = np.nonzero(self.cells < CELL_CORNERS)
        if len(rows):
            least = int(np.argmin(self.cells[rows, columns]))
            return f"move the board to the {_part(int(rows[least]), int(columns[least]))} of the picture"
        for there, edge in zip(self.leans, _LEANS, strict=True):
            if not there:
                return f"tilt the board: its {edge} edge nearer to the camera, by 30 degrees or more"
        if not self.is_near:
            return "move the board nearer, until it is more than 60 % as high or as wide as the picture"
        if not self.is_far:
            return "move the board away, until it is less than 40 % as high and as wide as the picture"
        if self.views < LEAST_VIEWS:
            return f"show {LEAST_VIEWS - self.views} more views, each at another place and tilt"
        return ""

    @property
    def share(self) -> float:
        """Share of what is needed that is there, 0 to 1."""
        parts = [min(1.0, float(cell) / CELL_CORNERS) for cell in self.cells.flat]
        parts += [float(each) for each in (*self.leans, self.is_near, self.is_far)]
        return (sum(parts) + min(1.0, self.views / LEAST_VIEWS)) / (len(parts) + 1)


def coverage(views: Sequence[View], width: int, height: int) -> Coverage:
    """Return what views of a picture of that size (pixels) show."""
    cells = np.zeros((CELLS[1], CELLS[0]), np.int64)
    for view in views:
        columns = np.clip(view.corners[:, 0] / width * CELLS[0], 0, CELLS[0] - 1).astype(int)
        rows = np.clip(view.corners[:, 1] / height * CELLS[1], 0, CELLS[1] - 1).astype(int)
        np.add.at(cells, (rows, columns), 1)
    leans = [view.lean for view in views]
    return Coverage(
        cells,
        (
            any(across >= TILTED for across, _ in leans),
            any(across <= -TILTED for across, _ in leans),
            any(down >= TILTED for _, down in leans),
            any(down <= -TILTED for _, down in leans),
        ),
        any(view.size >= NEAR for view in views),
        any(view.size <= FAR for view in views),
        len(views),
    )


def _part(row: int, column: int) -> str:
    """Return a part of the picture in words."""
    if row == 1:
        return _COLUMNS[column]
    return f"{_ROWS[row]} {_COLUMNS[column]}" if column in (0, CELLS[0] - 1) else f"{_ROWS[row]} middle"
