"""The path home that the battery's reserve counts: inside the fence, where the straight line leaves it."""

from __future__ import annotations

import math
from itertools import pairwise

from hawk.ddc.battery.energy import SLOWEST_M_S
from hawk.ddc.fence.geometry import path_is_inside
from hawk.ddc.fence.path import length, path_inside
from hawk.ddc.readings.wind import Wind, ground_speed
from hawk.model.limits import Fence
from hawk.model.poses import MapPoint

LOOK_S = 1.0
"""A path is looked for once in this time, seconds: it costs milliseconds. Its first leg follows the drone."""


class HomePath:
    """Keeps the path home, and looks for it again once a second."""

    def __init__(self) -> None:
        self._of: tuple[Fence, MapPoint] | None = None
        self._path: tuple[MapPoint, ...] | None = None
        self._looked = -math.inf

    def look(self, fence: Fence | None, place: MapPoint, home: MapPoint, now: float) -> tuple[MapPoint, ...]:
        """Return the path from a place home, both ends included; the straight line where none inside is needed.

        A place or home outside the fence has no path inside: the line is straight as well.
        """
        if fence is None or path_is_inside(fence, place, home):
            return (place, home)
        if self._of != (fence, home) or now - self._looked >= LOOK_S:
            self._of, self._looked = (fence, home), now
            self._path = path_inside(fence, place, home)
        return (place, home) if self._path is None else (place, *self._path[1:])


def mean_speed(path: tuple[MapPoint, ...], speed: float, wind: Wind | None) -> float:
    """Return the mean speed over ground along a path, m/s, each leg against its wind.

    A leg that the wind forbids counts as flown at `SLOWEST_M_S`.
    """
    whole = length(path)
    if whole == 0.0:
        return speed
    legs = [(a.distance(b), math.atan2(b.east - a.east, b.north - a.north)) for a, b in pairwise(path)]
    return whole / sum(metres / max(ground_speed(speed, track, wind), SLOWEST_M_S) for metres, track in legs)
