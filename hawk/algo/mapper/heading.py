"""How far the compass is off, told by the ground's movement: what GNSS's own drift may explain is not laid to it.

While GNSS drifts sideways the ground seems to slip sideways too, as with a wrong compass: that part comes and goes
within tens of metres of way, the compass's stays. Both are told apart by a Kalman filter of the two.
"""

from __future__ import annotations

import math

_FIRST_SIGMA = math.radians(2.0)  # compasses of most flights
_KNOWN_SIGMA = math.radians(0.4)  # of what an earlier flight learned
_WANDER = 0.0005  # radians by square root of metre: compasses change with where the drone heads
_DRIFT_SIGMA = 0.007  # GNSS of 1 m drifts by 3 cm/s, flown over at 4 m/s
_DRIFT_WAY_M = 40.0  # for 10 s
_SIGMA = 0.02  # of one comparison, radians: .014 as measured over worlds 1-20, and some outliers
_LIMIT = math.radians(6)


class Heading:
    """Learns what is to be added to the heading that is told, radians."""

    def __init__(self) -> None:
        self._turn = self._drift = 0.0
        self._turn_variance, self._drift_variance, self._shared = _FIRST_SIGMA**2, _DRIFT_SIGMA**2, 0.0

    @property
    def turn(self) -> float:
        """What is to be added: what was learned less what is not sure of it.

        The positive part of James and Stein's estimator (1961): nothing within one standard deviation, nearly all of
        what is far beyond it. A map is bent by a turn that changes.
        """
        if self._turn**2 <= self._turn_variance:
            return 0.0
        return min(max(self._turn - self._turn_variance / self._turn, -_LIMIT), _LIMIT)

    def restore(self, turn: float) -> None:
        """Take up what an earlier flight learned: `turn` is that."""
        self._turn_variance = _KNOWN_SIGMA**2
        self._turn = (turn + math.copysign(math.sqrt(turn**2 + 4 * self._turn_variance), turn)) / 2 if turn else 0.0

    def move(self, way: float) -> None:
        """The drone flew so many metres."""
        keep = math.exp(-way / _DRIFT_WAY_M)
        self._turn_variance += _WANDER**2 * way
        self._drift *= keep
        self._shared *= keep
        self._drift_variance = self._drift_variance * keep**2 + _DRIFT_SIGMA**2 * (1 - keep**2)

    def learn(self, told: float) -> None:
        """Learn from one comparison, which says that so much is to be added, radians."""
        mine, drifts = self._turn_variance + self._shared, self._drift_variance + self._shared
        whole = mine + drifts + _SIGMA**2
        surprise = told - self._turn - self._drift
        self._turn += mine / whole * surprise
        self._drift += drifts / whole * surprise
        self._turn_variance -= mine * mine / whole
        self._drift_variance -= drifts * drifts / whole
        self._shared -= mine * drifts / whole
