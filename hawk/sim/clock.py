"""The simulation's clock: how many simulated seconds have passed."""

from __future__ import annotations

import time
from collections.abc import Callable


class SimulationClock:
    """``speed`` simulated seconds for every real one, from zero when it is made."""

    def __init__(self, speed: float = 1.0, monotonic: Callable[[], float] = time.monotonic) -> None:
        self.speed = speed
        self._monotonic = monotonic
        self._start = monotonic()

    def __call__(self) -> float:
        """Return simulated seconds since the start."""
        return (self._monotonic() - self._start) * self.speed
