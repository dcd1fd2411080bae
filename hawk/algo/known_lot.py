"""A lot that is known already: the place of its plan on the map of a flight, and what a frame shows of its stalls.

The map of the flight grows; the plan is compared with it again and again, a few milliseconds a frame, until its place
is certain (`hawk.algo.registration`). Until then the flight knows nothing of the plan.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon

from hawk.algo.frame import Steps
from hawk.algo.registration.likelihood import Placement, StallMap
from hawk.algo.registration.whole_map import Doubt, Registration, registering
from hawk.algo.rows.fit import Rectangles
from hawk.algo.vision.decode import Stalls, occupancy, sample, sample_points
from hawk.algo.vision.detection import FloatArray, Found, GroundImage
from hawk.algo.vision.network import MapArray
from hawk.model.known_lot import KnownLot, KnownStall
from hawk.model.poses import Ring

FIRST_TRY: Final = 12
"""Stalls on the map of the flight with which the plan is first compared."""
GROWTH: Final = 1.25
"""The map is compared again once it has grown by this factor, or after `PAUSE` frames: they show more ground."""
PAUSE: Final = 40
_STEPS_A_FRAME: Final = 2
_BESIDE_M: Final = 30.0
"""Lots no farther apart adjoin. A row that goes on in the next lot has no end: without that lot's plan, the place of a
plan along its rows is doubtful. One receiver errs alike over both."""
_ABOUT_M: Final = 60.0
"""Ground about a lot that its flight sees. What is farther off belongs to other lots of a round."""


def plan_rectangles(lot: KnownLot) -> Rectangles:
    """Return the stalls of a plan (N,)."""
    return _rectangles(lot.stalls)


def tour_rectangles(lot: KnownLot) -> Rectangles:
    """Return all that a flight over a known lot looks at (M,): the stalls of its plan, then the places of sections."""
    return _rectangles((*lot.stalls, *lot.section_places))


def _rectangles(stalls: Sequence[KnownStall]) -> Rectangles:
    values = np.array([(s.north, s.east, s.angle, s.width, s.length) for s in stalls], float).reshape(-1, 5)
    return Rectangles(values[:, :2], *values[:, 2:].T)


def adjoining(lots: Sequence[KnownLot]) -> list[list[KnownLot]]:
    """Return the groups of two and more lots that lie beside each other."""
    boxes = [shapely.MultiPoint([(s.north, s.east) for s in lot.stalls]).envelope for lot in lots]
    ground = shapely.union_all([box.buffer(_BESIDE_M / 2) for box in boxes])
    groups = [
        [lot for lot, box in zip(lots, boxes, strict=True) if part.covers(box)] for part in shapely.get_parts(ground)
    ]
    return [group for group in groups if len(group) > 1]


class PlanRegistration:
    """Looks for the place of one plan, or of adjoining plans as one."""

    def __init__(self, *lots: KnownLot) -> None:
        """``lots`` lie where the position by GNSS places them."""
        self.lots = lots
        stalls = _rectangles([stall for lot in lots for stall in lot.stalls])
        self._known = StallMap(stalls, _polygons([piece for lot in lots for piece in lot.ground]))
        low, high = self._known.stalls.centres.min(0), self._known.stalls.centres.max(0)
        self.about: FloatArray = np.stack([low - _ABOUT_M, high + _ABOUT_M])
        """Two corners (2, 2) of (north, east) about the lot and what its flight sees, metres."""
        self._steps: Steps[Registration] | None = None
        self._next = FIRST_TRY
        self._count = self._waited = 0
        self.doubt: Doubt | None = Doubt.TOO_FEW
        """Why the place was not certain when it was last looked for."""

    def __getstate__(self) -> dict[str, object]:
        """Return the state of a copy: a comparison under way is not copied."""
        return {**self.__dict__, "_steps": None}

    def go_on(self, count: int, found: Callable[[], StallMap]) -> list[Rectangles] | None:
        """Do the next steps; return the stalls of each plan on the map of the flight once their place is certain.

        Args:
            count: Number of stalls about the lot on the map of the flight.
            found: Returns these stalls with the ground that was seen; called when a comparison begins.
        """
        if self._steps is None:
            self._waited += 1
            if count < FIRST_TRY or (count < self._next and self._waited < PAUSE):
                return None
            self._count, self._waited = count, 0
            self._steps = registering(self._known, found())
        try:
            for _ in range(_STEPS_A_FRAME):
                next(self._steps)
        except StopIteration as end:
            self._steps, self._next = None, round(self._count * GROWTH) + 1
            outcome: Registration = end.value
            self.doubt = outcome.doubt
            if outcome.is_certain and outcome.best is not None:
                placed = _placed(self._known.stalls, outcome.best.placement)
                ends = np.cumsum([len(lot.stalls) for lot in self.lots])
                return [placed[mine] for mine in np.split(np.arange(len(placed)), ends[:-1])]
        return None


def _placed(plan: Rectangles, placement: Placement) -> Rectangles:
    """Return the plan on the map of the flight; ``placement`` brings that map onto the plan."""
    return Rectangles(placement.back(plan.centres), (plan.angle - placement.turn) % np.pi, plan.width, plan.length)


def _polygons(ground: Sequence[tuple[Ring, ...]]) -> MultiPolygon:
    """Return the known ground; rings that cross themselves are mended."""
    whole = shapely.union_all([shapely.make_valid(Polygon(piece[0], piece[1:])) for piece in ground])
    return MultiPolygon([part for part in shapely.get_parts(whole) if isinstance(part, Polygon) and not part.is_empty])


@dataclass(frozen=True, slots=True)
class _Layers:
    core: MapArray = field(repr=False)
    taken: MapArray = field(repr=False)
    car: MapArray = field(repr=False)


def judge(found: Found, stalls: Rectangles) -> tuple[FloatArray, FloatArray]:
    """Return the probability (N,) that each stall is taken, and the share (N,) of each that the picture shows.

    ``stalls``: metres (north, east), wherever vision found any itself.
    """
    if not len(stalls):
        return np.zeros(0), np.zeros(0)
    cells = _in_cells(stalls, found.core)
    layers = _Layers(found.core.values, found.taken.values, found.car.values)
    visible = sample(found.core.valid, sample_points(cells)).mean(axis=1)
    return occupancy(layers, cells), np.asarray(visible, np.float64)


def _in_cells(stalls: Rectangles, ground: GroundImage) -> Stalls:
    column, row = ground.pixel_points(stalls.centres).T
    along = np.column_stack([np.cos(stalls.angle), np.sin(stalls.angle)]) @ np.linalg.inv(ground.to_map[:, :2]).T
    side = ground.metres_per_pixel
    size = stalls.width / side, stalls.length / side
    return Stalls(column, row, np.arctan2(along[:, 1], along[:, 0]), *size, np.ones(len(stalls)))
