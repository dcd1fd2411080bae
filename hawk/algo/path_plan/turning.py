"""A turn on the spot: what lies about the drone is shown by the picture's long side, for seconds and no way.

The secret is which way round and how far: until what is wanted about the drone is shown, and no farther.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from hawk.algo.path_plan.field import Place
from hawk.algo.path_plan.footprint import Floats, Footprint, Singles
from hawk.algo.path_plan.tour import Wanted

_LEAD_RAD: Final = 0.3  # the heading asked for lies so far beyond: a controller slows down towards it
_LEAST_RAD: Final = 0.02
_MOST_RAD: Final = math.pi  # after half a turn the picture has shown everything


class Turning:
    """One turn at one place."""

    def __init__(self, place: Place, footprint: Footprint, least_m2: float, idle_plans: int) -> None:
        """What is worth less than ``least_m2`` is not turned for; a drone that does not turn in so many plans is let
        be."""
        self.place = place
        self._footprint = footprint
        self._least = least_m2
        self._most_idle = idle_plans
        self._side = 0.0
        self._last: float | None = None
        self._turned = 0.0
        self._idle = 0

    def heading(self, place: Place, heading: float, wanted: Wanted) -> float | None:
        """Return the picture's heading (radians) to turn to from the present one, None when the turn is over."""
        self._count(heading)
        off = wanted.cells - np.array(place, np.float32)
        near = np.hypot(off[:, 0], off[:, 1]) <= self._footprint.spun
        if self._turned > _MOST_RAD or self._idle > self._most_idle or not near.any():
            return None
        left, right = self._still_to_turn(off[near], wanted.weights[near], heading)
        if self._side == 0.0:
            self._side = -1.0 if left < right else 1.0
        turn = left if self._side < 0 else right
        return None if turn <= 0 else heading + self._side * (turn + _LEAD_RAD)

    def _count(self, heading: float) -> None:
        moved = 0.0 if self._last is None else abs(math.remainder(heading - self._last, math.tau))
        self._idle = 0 if moved > _LEAST_RAD else self._idle + 1
        self._turned += moved
        self._last = heading

    def _still_to_turn(self, off: Singles, weights: Singles, heading: float) -> tuple[float, float]:
        """Return by how much to turn to the left, or to the right, until little enough is left; 0 is not at all."""
        left, right = self._footprint.turns_until_shown(off, heading)
        return self._until_little(left, weights), self._until_little(right, weights)

    def _until_little(self, turns: Floats, weights: Singles) -> float:
        order = np.argsort(-turns)
        beyond = np.cumsum(weights[order])
        last = int(np.searchsorted(beyond, self._least))  # the farthest of them together are worth less
        return 0.0 if last >= len(order) else float(turns[order[last]])
