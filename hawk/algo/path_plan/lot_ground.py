"""Where an Autonomous Move may lead: known lot inside the fence.

The secret is what becomes of a drone, or of a place, that lies beside the cells of known lot: a few metres about that
end count as well, just as many as it takes to reach the lot.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.mapper.grid import COARSE_M, CoarseLayers
from hawk.algo.mapper.window import Slices, Window
from hawk.algo.path_plan.fence import FenceGuard
from hawk.algo.path_plan.sight import is_clear
from hawk.algo.path_plan.turned import Place

_LOT_SHARE = 0.5
_CHUNK_M = 40.0

Mask = NDArray[np.uint8]


class KnowsLot(Protocol):
    """What is asked of the map."""

    def coarse(self, window: Window) -> CoarseLayers:
        """Return the coarse layers over a window."""
        ...

    def known_extent(self) -> NDArray[np.float64] | None:
        """Return two corners (2, 2) around everything seen."""
        ...


@dataclass(frozen=True, slots=True)
class End:
    """One end of a route; all within ``radius`` metres of the place counts as lot (0: nothing does)."""

    place: Place
    radius: float = 0.0


@dataclass(frozen=True, slots=True)
class LotGround:
    """The ground for one route."""

    known: KnowsLot
    guard: FenceGuard
    ends: tuple[End, ...] = ()

    def mask(self, window: Window) -> Mask:
        """Return 1 where whole cells of a window (of `COARSE_M` cells) may be flown over."""
        lot = self.known.coarse(window).lot >= _LOT_SHARE
        for end in self.ends:
            if end.radius > 0:
                part, disc = disc_about(window, end.place, end.radius)
                lot[part] |= disc
        return lot.astype(np.uint8) & self.guard.mask(window)

    def reached_from(self, place: Place, within_m: float) -> End | None:
        """Return the end at a place, None when known lot does not begin within so many metres of it."""
        window = Window.around(np.array([place]), COARSE_M, within_m + 2 * COARSE_M)
        mask = self.mask(window)
        if is_clear(mask, window, place, place):
            return End(place)
        nearest = float(distance_to(window, place)[mask > 0].min(initial=math.inf))
        return End(place, nearest + COARSE_M) if nearest <= within_m else None

    def is_clear_way(self, start: Place, end: Place) -> bool:
        """Return whether the straight way is over this ground; its cost grows with its length, not with the map."""
        pieces = max(1, math.ceil(math.dist(start, end) / _CHUNK_M))
        places = np.linspace(start, end, pieces + 1)
        for one, other in pairwise(places):
            window = Window.around(np.stack([one, other]), COARSE_M, 2 * COARSE_M)
            a, b = (float(one[0]), float(one[1])), (float(other[0]), float(other[1]))
            if not is_clear(self.mask(window), window, a, b):
                return False
        return True


def distance_to(window: Window, place: Place) -> NDArray[np.float64]:
    """Return the metres from a place to the middle of each of the window's cells."""
    column, row = window.cells_of(np.array(place[0]), np.array(place[1]))
    rows, columns = np.arange(window.rows)[:, None], np.arange(window.columns)[None]
    return np.asarray(np.hypot(rows - row, columns - column) * window.cell_m)


def disc_about(window: Window, place: Place, radius: float) -> tuple[Slices, NDArray[np.bool_]]:
    """Return the part of a window that holds a disc, and which of its cells have their middle in it."""
    box = Window.around(np.array([place]), window.cell_m, radius)
    top, left = max(box.row - window.row, 0), max(box.column - window.column, 0)
    bottom = max(min(box.row + box.rows - window.row, window.rows), top)
    right = max(min(box.column + box.columns - window.column, window.columns), left)
    part = Window(window.row + top, window.column + left, bottom - top, right - left, window.cell_m)
    return (slice(top, bottom), slice(left, right)), distance_to(part, place) <= radius


def cleared(mask: Mask) -> Mask:
    """Return the mask without the cells at its border."""
    return np.asarray(cv2.erode(mask, np.ones((3, 3), np.uint8)), dtype=np.uint8)
