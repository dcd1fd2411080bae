"""The distance to what is below: how long it has been too small, and what a rangefinder's health is.

Without a rangefinder nothing here says anything.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from hawk.comm.autopilot.terrain import Terrain
from hawk.ddc.readings.slope import Slope
from hawk.model.operation import Health, HealthStatus
from hawk.model.sentences import say

LOW_S = 0.5
"""Seconds for which the distance must be too small."""
LOW_READINGS = 4
"""Number of readings that must show it: a single bad one does not count."""
GAP_S = 1.0
"""After this time without a reading that is too small, seconds, those before do not count."""
SILENT_S = 3.0
"""A rangefinder that was heard and is silent for this time is unhealthy, seconds."""
MIN_SHARE = 0.5
"""The least clearance is never more than this share of Min: Min itself must be free to fly."""


@dataclass(frozen=True, slots=True)
class BelowFacts:
    """Readings of what is below the drone. Without a rangefinder there is only ``slope``."""

    terrain: Terrain | None = None
    """The last message of the rangefinder; None when there was none, and when it is silent."""
    low_s: float | None = None
    """Seconds for which the distance has been below the least clearance; None while it is not, and on the ground."""
    low_m: float | None = None
    """The least distance in that time, metres."""
    slope: Slope | None = None
    """The slope that the drone stands on, disarmed; None in flight and before it was seen at rest for a second."""

    @property
    def ground(self) -> float | None:
        """Height of the ground below, metres above the arm place; None where it is not known or not believed."""
        return None if self.terrain is None else self.terrain.believed_ground


def least_clearance(setting_m: float, minimum: float) -> float:
    """Return the least distance to what is below in a task, metres."""
    return min(setting_m, MIN_SHARE * minimum)


class ClearanceWatch:
    """Counts the readings that are too small, one after the other."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget the readings: the drone is on the ground."""
        self._seen = self._first = self._last = -math.inf
        self._count = 0
        self._least = math.inf

    def update(self, terrain: Terrain | None, limit: float) -> None:
        """Take the newest message (the same one again changes nothing); ``limit`` in metres."""
        if terrain is None or terrain.time <= self._seen:
            return
        self._seen = terrain.time
        if terrain.doubt or (terrain.distance is not None and terrain.distance >= limit):
            self._count = 0
        elif terrain.distance is not None:
            if terrain.time - self._last > GAP_S:
                self._count = 0
            if not self._count:
                self._first, self._least = terrain.time, math.inf
            self._count += 1
            self._least = min(self._least, terrain.distance)
            self._last = terrain.time

    def low(self, now: float) -> tuple[float | None, float | None]:
        """Return how long the distance has been too small (s) and the least one (m); None while it is not too small."""
        if self._count < LOW_READINGS or now - self._last > GAP_S:
            return None, None
        return self._last - self._first, self._least


def range_health(terrain: Terrain | None, age: float) -> Health | None:
    """Return the health of the rangefinder; None when none was ever heard. ``age`` of its last message, seconds."""
    if terrain is None:
        return None
    if age > SILENT_S:
        return Health.bad(say("silent for {age:.0f} s: heights count above the arm place", age=age))
    if terrain.doubt:
        return Health.bad(say("not believed: {doubt}", doubt=terrain.doubt))
    reason = "" if terrain.distance is not None else say("no reading (it reaches {most:.0f} m)", most=terrain.most)
    return Health(HealthStatus.HEALTHY, reason)
