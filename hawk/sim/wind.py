"""Wind: a mean with gusts about it."""

from __future__ import annotations

import math

import numpy as np

from hawk.sim.vector import Vector

GUST_SHARE = 0.25
"""Standard deviation of the gusts as a share of the mean wind (turbulence intensity over open ground)."""
GUST_TIME_S = 3.0


class Wind:
    """Horizontal wind. ``speed`` m/s and ``heading`` (radians clockwise from north, where it blows to) may be set."""

    def __init__(self, speed: float, heading: float, rng: np.random.Generator) -> None:
        self.speed = speed
        self.heading = heading
        self._rng = rng
        self._gust = (0.0, 0.0)

    def step(self, dt: float) -> Vector:
        """Return the wind (NED m/s) ``dt`` seconds later."""
        if self.speed == 0.0:
            return 0.0, 0.0, 0.0
        keep = math.exp(-dt / GUST_TIME_S)
        fresh = GUST_SHARE * self.speed * math.sqrt(1.0 - keep * keep)
        noise = self._rng.standard_normal(2)
        self._gust = (self._gust[0] * keep + fresh * float(noise[0]), self._gust[1] * keep + fresh * float(noise[1]))
        north, east = self.speed * math.cos(self.heading), self.speed * math.sin(self.heading)
        return north + self._gust[0], east + self._gust[1], 0.0
