"""The simulated ground: level, or a plane that rises evenly."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hawk.sim.geometry import Flat


@dataclass(frozen=True, slots=True)
class Slope:
    """Ground that rises by ``percent`` towards ``direction`` (radians clockwise from north), zero at ``start``."""

    percent: float = 0.0
    direction: float = 0.0
    start: Flat = (0.0, 0.0)

    def height(self, north: float, east: float) -> float:
        """Return the ground's height at a place in the world, metres above the ground at the start."""
        if self.percent == 0.0:
            return 0.0
        along = (north - self.start[0]) * math.cos(self.direction) + (east - self.start[1]) * math.sin(self.direction)
        return along * self.percent / 100.0

    def tilt(self, yaw: float) -> Flat:
        """Return roll and pitch (radians) of a drone that stands on it with this heading."""
        gradient = self.percent / 100.0
        ahead, right = (gradient * function(self.direction - yaw) for function in (math.cos, math.sin))
        pitch = math.atan(ahead)
        return -math.atan(right * math.cos(pitch)), pitch
