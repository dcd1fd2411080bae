"""The plan of the lot that is flown over, as it comes onto the map of the flight."""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon

from hawk.algo.ground import COARSE_M, Window
from hawk.algo.known_lot import PlanRegistration, judge
from hawk.algo.mapper.fused_ground import FusedGround
from hawk.algo.mapper.grid import EvidenceGrid
from hawk.algo.mapper.stalls import GivenLook, StallTracker, call_state
from hawk.algo.mapper.table import SQUARE_M, Rows, corners_of, geometry_of, square_of
from hawk.algo.registration.likelihood import StallMap
from hawk.algo.rows.fit import Rectangles
from hawk.algo.vision.detection import FrameGround
from hawk.model.known_lot import KnownLot

_LEAST_SHOWN: Final = 0.6
"""Share of a given stall in the picture from which its state is judged."""

_REACH_M: Final = 5.0
"""Half the diagonal of the longest stall."""


class PlanOnMap:
    """Brings plans onto the map: one at a time, each once."""

    def __init__(self) -> None:
        self._search: PlanRegistration | None = None
        self.names: tuple[tuple[str, str], ...] = ()
        """Ids and labels of the stalls of the plan that is on the map, by their numbers from 1."""
        self.placed: tuple[KnownLot, NDArray[np.float64]] | None = None
        """The plan whose place is certain, and its stalls on the map (N, 5): north, east, angle, width, length."""

    def know(self, lot: KnownLot | None) -> None:
        """Take the plan of the lot that is flown over. None changes nothing: what is on the map stays."""
        if lot is not None and (self._search is None or self._search.lot is not lot):
            self._search = PlanRegistration(lot)

    def go_on(self, tracker: StallTracker, grid: EvidenceGrid, version: int, time: float) -> NDArray[np.intp] | None:
        """Look on for the place of the plan; once it is certain, put it on the map.

        ``time``: of the frame, seconds. Returns the indices of the rows that changed then, and None before and after.
        """
        search = self._search
        if search is None or search.is_over:
            return None
        plan = search.go_on(tracker.count, lambda: found_map(tracker, grid))
        if plan is None:
            return None
        self.names = tuple((stall.id, stall.label) for stall in search.lot.stalls)
        self.placed = search.lot, np.column_stack([plan.centres, plan.angle, plan.width, plan.length])
        is_confirmed = np.array([stall.is_confirmed for stall in search.lot.stalls], np.bool_)
        index = tracker.put_plan(plan, is_confirmed, version)
        _call_unseen(tracker.rows, grid, time)
        return index


def _call_unseen(rows: Rows, grid: EvidenceGrid, time: float) -> None:
    """Call the states of given stalls that no frame was asked about, by what all frames have shown of their ground."""
    asked = np.flatnonzero(rows["given"] & (rows["seen"] == 0))
    squares = [square_of(north, east) for north, east in zip(rows["north"][asked], rows["east"][asked], strict=True)]
    for square in set(squares):
        index = asked[[each == square for each in squares]]
        middle = ((square[0] + 0.5) * SQUARE_M, (square[1] + 0.5) * SQUARE_M)
        ground = FusedGround(grid, middle, SQUARE_M / 2 + _REACH_M)
        corners = corners_of(rows[index])
        is_seen = ground.seen(corners)
        index, taken = index[is_seen], ground.taken(corners[is_seen])
        rows["taken"][index], rows["seen"][index], rows["last_seen"][index] = taken, 1, time
        rows["state"][index] = call_state(taken, rows["state"][index])


def found_map(tracker: StallTracker, grid: EvidenceGrid) -> StallMap:
    """Return the valid stalls that pictures have shown, and the ground that was seen well."""
    rows = tracker.confirmed
    rows = rows[~rows["inferred"] & (rows["seen"] > 0)]
    return StallMap(rectangles_of(rows), well_seen(grid))


def well_seen(grid: EvidenceGrid) -> MultiPolygon:
    """Return the ground that was seen well, (north, east) metres, to the half of a coarse cell."""
    extent = grid.extent()
    if extent is None:
        return MultiPolygon()
    window = Window.around(extent, COARSE_M)
    mask = np.pad((grid.coarse(window).well > 0.5).astype(np.uint8), 1)
    rings, tree = cv2.findContours(mask, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
    grounds = []
    for ring, (_, _, _, parent) in zip(rings, [] if tree is None else tree[0], strict=True):
        if len(ring) >= 3:
            column, row = ring[:, 0].T.astype(np.float64) - 1
            corners = np.column_stack(window.centres(row, column))
            grounds.append((Polygon(corners).buffer(0), bool(parent >= 0)))
    outer, holes = (
        shapely.union_all([ground for ground, is_hole in grounds if is_hole is wanted]) for wanted in (False, True)
    )
    left = shapely.get_parts(outer.difference(holes).buffer(COARSE_M / 2))
    return MultiPolygon([part for part in left if isinstance(part, Polygon)])


def given_look(rows: Rows, local: NDArray[np.intp], seen: FrameGround) -> GivenLook:
    """Return what a frame shows of the given stalls among the rows ``local``."""
    index = local[rows["given"][local]]
    taken, visible = judge(seen, rectangles_of(rows[index]))
    shown = visible >= _LEAST_SHOWN
    return GivenLook(index[shown], taken[shown], visible[shown])


def rectangles_of(rows: Rows) -> Rectangles:
    """Return rows (N,) as rectangles."""
    north, east, angle, width, length = geometry_of(rows)
    return Rectangles(np.column_stack([north, east]), angle, width, length)
