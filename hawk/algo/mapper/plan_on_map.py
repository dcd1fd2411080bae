"""The plan of the lot that is flown over, as it comes onto the map of the flight."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Final

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon

from hawk.algo.ground import COARSE_M, Window
from hawk.algo.known_lot import PlanRegistration, adjoining, judge
from hawk.algo.mapper.fused_ground import FusedGround
from hawk.algo.mapper.grid import EvidenceGrid
from hawk.algo.mapper.plan_rows import PlanStalls
from hawk.algo.mapper.stalls import GivenLook, StallTracker, call_state
from hawk.algo.mapper.table import SQUARE_M, Rows, corners_of, geometry_of, is_in, square_of
from hawk.algo.registration.likelihood import StallMap
from hawk.algo.rows.fit import Rectangles
from hawk.algo.vision.detection import FrameGround
from hawk.model.known_lot import KnownLot

_LEAST_SHOWN: Final = 0.6
"""Share of a given stall in the picture from which its state is judged."""

_REACH_M: Final = 5.0
"""Half the diagonal of the longest stall."""


def _are_same(lots: Sequence[KnownLot], others: Sequence[KnownLot]) -> bool:
    return len(lots) == len(others) and all(lot is other for lot, other in zip(lots, others, strict=True))


@dataclass(frozen=True, slots=True)
class _Placed:
    """A plan on the map: its stalls (N, 5), and their numbers."""

    lot: KnownLot
    stalls: NDArray[np.float64] = field(repr=False)
    numbers: range


class PlanOnMap:
    """Brings plans onto the map, each once."""

    def __init__(self) -> None:
        self._lots: tuple[KnownLot, ...] = ()
        self._searches: list[PlanRegistration] = []
        self._placed: dict[str, _Placed] = {}
        self.names: tuple[tuple[str, str], ...] = ()
        """Ids and labels of the stalls of the plans that came onto the map, by their numbers from 1."""

    def know(self, lots: Sequence[KnownLot]) -> None:
        """Take the plans of the lots that are flown over. Without one nothing changes: what is on the map stays.

        Sections alone have no place on the map: the receiver says where they lie.
        """
        lots = tuple(lot for lot in lots if lot.stalls)
        if not lots or _are_same(lots, self._lots):
            return
        groups = [*adjoining(lots), *([lot] for lot in lots)]
        former = self._searches
        self._lots = lots
        self._searches = [
            next((search for search in former if _are_same(search.lots, group)), None) or PlanRegistration(*group)
            for group in groups
        ]

    def places(self, lot: str) -> NDArray[np.float64] | None:
        """Return the stalls (N, 5) of the plan of a lot on the map: north, east, angle, width, length; None before its
        place is certain.
        """
        placed = self._placed.get(lot)
        return None if placed is None else placed.stalls

    def _is_on_map(self, lot: KnownLot) -> bool:
        placed = self._placed.get(lot.id)
        return placed is not None and placed.lot is lot

    def go_on(self, tracker: StallTracker, grid: EvidenceGrid, version: int, time: float) -> NDArray[np.intp] | None:
        """Look on for the places of the plans; once one is certain, put it on the map.

        ``time``: of the frame, seconds. Returns the indices of the rows that changed then, and None before and after.
        """
        for search in self._searches:
            if all(self._is_on_map(lot) for lot in search.lots):
                continue
            plans = search.go_on(tracker.count_in(search.about), partial(found_map, tracker, grid, search.about))
            if plans is not None:
                index = None
                for lot, plan in zip(search.lots, plans, strict=True):
                    if not self._is_on_map(lot):
                        index = self._put(lot, plan, tracker, grid, version, time)  # with the changes before it
                return index
        return None

    def _put(
        self, lot: KnownLot, plan: Rectangles, tracker: StallTracker, grid: EvidenceGrid, version: int, time: float
    ) -> NDArray[np.intp]:
        """Put one plan beside those of the other lots of the flight, in place of any other plan."""
        flown = {each.id for each in self._lots} - {lot.id}
        self._placed = {each: placed for each, placed in self._placed.items() if each in flown}
        numbers = range(len(self.names) + 1, len(self.names) + 1 + len(lot.stalls))
        self.names += tuple((stall.id, stall.label) for stall in lot.stalls)
        values = np.column_stack([plan.centres, plan.angle, plan.width, plan.length])
        is_confirmed = np.array([stall.is_confirmed for stall in lot.stalls], np.bool_)
        others = tuple(placed.numbers for placed in self._placed.values())
        index = tracker.put_plan(PlanStalls(plan, is_confirmed, numbers.start, others), version)
        self._placed[lot.id] = _Placed(lot, values, numbers)
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


def found_map(tracker: StallTracker, grid: EvidenceGrid, about: NDArray[np.float64]) -> StallMap:
    """Return the valid stalls that pictures have shown, and the ground that was seen well.

    ``about``: two corners (2, 2) of (north, east), metres; nothing beyond is looked at.
    """
    rows = tracker.confirmed
    rows = rows[~rows["inferred"] & (rows["seen"] > 0)]
    return StallMap(rectangles_of(rows[is_in(rows, about)]), well_seen(grid, about))


def well_seen(grid: EvidenceGrid, about: NDArray[np.float64]) -> MultiPolygon:
    """Return the ground that was seen well, (north, east) metres, to the half of a coarse cell.

    ``about`` as for `found_map`.
    """
    whole = grid.extent()
    if whole is None:
        return MultiPolygon()
    extent = np.stack([np.maximum(whole.min(0), about[0]), np.minimum(whole.max(0), about[1])])
    if (extent[0] >= extent[1]).any():
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
