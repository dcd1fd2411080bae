"""Ground that the drone may fly over: inside the fence, and for an Autonomous Move over known lot.

A drone, or a place, may lie beside the cells of known lot. The few metres about that end which it takes to reach the
lot are then added to the lot.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import cv2
import numpy as np
import shapely

from hawk.algo.ground import COARSE_M, Bools, CoarseLayers, Floats, LotMap, Mask, Place, Slices, Window
from hawk.algo.path_plan.grid_search import is_clear
from hawk.model.plans import AskedGround, Fence
from hawk.model.poses import Ring

_LOT_SHARE = 0.5
_CHUNK_M = 40.0


class FenceGuard:
    """The fence without its zones, as polygon and as cells; None: there is none yet, and everything is inside."""

    def __init__(self, fence: Fence | None) -> None:
        self.fence = fence
        self._polygon = None
        if fence is not None and len(fence.polygon) >= 3:
            zones = shapely.union_all([shapely.Polygon(zone) for zone in fence.zones])
            self._polygon = shapely.Polygon(fence.polygon).difference(zones)
            shapely.prepare(self._polygon)

    def contains(self, north: float, east: float) -> bool:
        """Return True when a place (metres, map frame) is inside."""
        return self._polygon is None or bool(self._polygon.covers(shapely.Point(north, east)))

    def contain(self, places: Floats) -> Bools:
        """Return True for those of places (T, 2) of (north, east) that are inside."""
        if self._polygon is None:
            return np.ones(len(places), np.bool_)
        return np.asarray(shapely.intersects_xy(self._polygon, places[:, 0], places[:, 1]), np.bool_)

    def contains_line(self, start: Place, end: Place) -> bool:
        """Return True when the whole straight line is inside."""
        return self._polygon is None or bool(self._polygon.covers(shapely.LineString([start, end])))

    def mask(self, window: Window) -> Mask:
        """Return 1 where whole cells lie inside, 0 elsewhere; a cell has the same answer in every window."""
        if self.fence is None or self._polygon is None:
            return np.ones(window.shape, np.uint8)
        wider = window.grown(1)  # erosion needs the cells next to the window
        mask = np.zeros(wider.shape, np.uint8)
        _fill(mask, wider, self.fence.polygon, 1)
        for zone in self.fence.zones:  # each by itself: where two overlap, one drawing of both would leave a hole
            _fill(mask, wider, zone, 0)
        return without_border(mask)[1:-1, 1:-1]

    def ours(self, window: Window) -> Mask:
        """Return 1 for cells with their centre inside the fence as it was drawn and in no zone, 0 elsewhere."""
        if self.fence is None or self._polygon is None:
            return np.ones(window.shape, np.uint8)
        ours = cells_inside([self.fence.autopilot_polygon or self.fence.polygon], window)
        for zone in self.fence.autopilot_zones:
            ours &= 1 - cells_inside([zone], window)
        return ours


@dataclass(frozen=True, slots=True)
class End:
    """One end of a route; ground within ``radius`` metres of the place is added to the lot (0: none)."""

    place: Place
    radius: float = 0.0


@dataclass(frozen=True, slots=True)
class LotGround:
    """Known lot inside the fence, and the ground about the ends of one route."""

    known: LotMap
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
        """Return the end at a place, None when no known lot lies within ``within_m`` metres of it."""
        window = Window.around(np.array([place]), COARSE_M, within_m + 2 * COARSE_M)
        mask = self.mask(window)
        if is_clear(mask, window, place, place):
            return End(place)
        nearest = float(_distances(window, place)[mask > 0].min(initial=math.inf))
        return End(place, nearest + COARSE_M) if nearest <= within_m else None

    def is_clear_line(self, start: Place, end: Place) -> bool:
        """Return True when the straight line is over this ground; the cost grows with the line, not with the map."""
        pieces = max(1, math.ceil(math.dist(start, end) / _CHUNK_M))
        places = np.linspace(start, end, pieces + 1)
        for one, other in pairwise(places):
            window = Window.around(np.stack([one, other]), COARSE_M, 2 * COARSE_M)
            a, b = (float(one[0]), float(one[1])), (float(other[0]), float(other[1]))
            if not is_clear(self.mask(window), window, a, b):
                return False
        return True


def disc_about(window: Window, place: Place, radius: float) -> tuple[Slices, Bools]:
    """Return the part of a window that holds a disc (``radius`` in metres), and its cells with their centre in it."""
    box = Window.around(np.array([place]), window.cell_m, radius)
    top, left = max(box.row - window.row, 0), max(box.column - window.column, 0)
    bottom = max(min(box.row + box.rows - window.row, window.rows), top)
    right = max(min(box.column + box.columns - window.column, window.columns), left)
    part = Window(window.row + top, window.column + left, bottom - top, right - left, window.cell_m)
    return (slice(top, bottom), slice(left, right)), _distances(part, place) <= radius


def without_border(mask: Mask) -> Mask:
    """Return the mask without the cells at its border."""
    return np.asarray(cv2.erode(mask, np.ones((3, 3), np.uint8)), dtype=np.uint8)


def _fill(mask: Mask, window: Window, ring: Sequence[Place], value: int) -> None:
    """Set the cells of a window that a ring (north, east) touches."""
    corners = np.array(ring)
    cells = np.round(window.cells_of(corners[:, 0], corners[:, 1]) * 16).astype(np.int32)
    cv2.fillPoly(mask, [cells], [value], shift=4)


def _distances(window: Window, place: Place) -> Floats:
    """Return the distances from a place to the centres of a window's cells, metres."""
    column, row = window.cells_of(np.array(place[0]), np.array(place[1]))
    rows, columns = np.arange(window.rows)[:, None], np.arange(window.columns)[None]
    return np.asarray(np.hypot(rows - row, columns - column) * window.cell_m)


LOOKED_AT: Final = 0.5
"""Share of a cell that must have been seen well: the cell counts as looked at then."""
_BLOCK: Final = 128  # cells a side of the blocks in which a large outline is read


class OutlinedGround:
    """The cells (of `COARSE_M`) with their centre in the asked ground."""

    def __init__(self, ground: AskedGround) -> None:
        self.ground = ground
        rings = [ring for piece in ground.pieces for ring in piece]
        corners = np.array([corner for ring in rings for corner in ring]).reshape(-1, 2)
        self.extent: Floats | None = None if len(corners) == 0 else np.stack([corners.min(0), corners.max(0)])
        """Two corners (2, 2) of (north, east) about the ground, metres; None when there is none."""
        self._window = Window(0, 0, 1, 1, COARSE_M) if len(corners) == 0 else Window.around(corners, COARSE_M)
        self._mask = cells_inside(rings, self._window)

    @property
    def area_m2(self) -> float:
        """Area of the cells, square metres."""
        return float(np.count_nonzero(self._mask)) * COARSE_M**2

    def mask(self, window: Window) -> Mask:
        """Return 1 for the cells of a window that belong to the ground, 0 for others."""
        mask = np.zeros(window.shape, np.uint8)
        top, left = max(window.row, self._window.row), max(window.column, self._window.column)
        bottom = min(window.row + window.rows, self._window.row + self._window.rows)
        right = min(window.column + window.columns, self._window.column + self._window.columns)
        if bottom > top and right > left:
            both = Window(top, left, bottom - top, right - left, COARSE_M)
            mask[window.part(both)] = self._mask[self._window.part(both)]
        return mask

    def contains(self, place: Place) -> bool:
        """Return True when the cell at a place (metres, map frame) belongs to the ground."""
        rows, columns, inside = self._window.cells_at(np.array([place]))
        return bool(inside[0] and self._mask[rows[0], columns[0]])

    def on(self, layers: CoarseLayers) -> CoarseLayers:
        """Return the map's layers with this ground as the lot, and everything outside it as seen."""
        outlined = self.mask(layers.window).astype(np.float32)
        looked_at = outlined * (layers.well >= LOOKED_AT)
        return replace(
            layers,
            lot=outlined,
            likely=outlined,
            seen=np.maximum(layers.seen, 1 - outlined),
            well=np.maximum(layers.well, looked_at),
        )

    def unseen_m2(self, known: LotMap) -> float:
        """Return the area of the cells that were not looked at, square metres."""
        left = 0
        for block in self._blocks():
            outlined = self.mask(block) > 0
            if outlined.any():
                left += int(np.count_nonzero(outlined & (known.coarse(block).well < LOOKED_AT)))
        return left * COARSE_M**2

    def _blocks(self) -> Iterator[Window]:
        whole = self._window
        for row in range(0, whole.rows, _BLOCK):
            for column in range(0, whole.columns, _BLOCK):
                rows, columns = min(_BLOCK, whole.rows - row), min(_BLOCK, whole.columns - column)
                yield Window(whole.row + row, whole.column + column, rows, columns, whole.cell_m)


def cells_inside(rings: list[Ring], window: Window) -> Mask:
    """Return 1 for the cells of a window with their centre inside an odd number of rings of (north, east), else 0.

    A side changes the answer for every cell east of it, in the rows whose middle it crosses.
    """
    changes = np.zeros((window.rows, window.columns + 1), np.uint8)
    for ring in rings:
        corners = window.cells_of(*np.array(ring, dtype=np.float64).T)
        for (x, y), (x_next, y_next) in zip(corners.tolist(), np.roll(corners, -1, axis=0).tolist(), strict=True):
            low, high = min(y, y_next), max(y, y_next)
            rows = np.arange(max(math.ceil(low), 0), min(math.ceil(high), window.rows))  # half open: no corner twice
            if len(rows):
                crossed = x + (rows - y) * ((x_next - x) / (y_next - y))
                changes[rows, np.clip(np.ceil(crossed), 0, window.columns).astype(np.intp)] ^= 1
    return np.asarray(np.bitwise_xor.accumulate(changes[:, :-1], axis=1))
