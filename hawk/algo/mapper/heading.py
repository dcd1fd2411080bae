"""How far the compass is off, told by the ground's movement: what GNSS's own drift may explain is not laid to it.

While GNSS drifts sideways the ground seems to slip sideways too, as with a wrong compass: the more, the slower the
drone flies, the other way round where it flies back, and not for long; what the compass is off stays. Both are told
apart by a Kalman filter of the compass's error and the drift's velocity, north and east.
"""

from __future__ import annotations

import math

import numpy as np

_FIRST_SIGMA = math.radians(2.0)  # compasses of most flights
_KNOWN_SIGMA = math.radians(0.4)  # of what an earlier flight learned
_WANDER = 0.0005  # radians by square root of metre: compasses change with where the drone heads
_DRIFT_SIGMA = 0.03  # m/s, each way: GNSS that is off by 1 m
_DRIFT_S = 10.0
_SIGMA = 0.02  # of one comparison, radians: .014 as measured over worlds 1-20, and some outliers
_LIMIT = math.radians(6)


class Heading:
    """Learns what is to be added to the heading that is told, radians."""

    def __init__(self) -> None:
        self._state = np.zeros(3)
        self._spread = np.diag([_FIRST_SIGMA**2, _DRIFT_SIGMA**2, _DRIFT_SIGMA**2])

    @property
    def turn(self) -> float:
        """What is to be added: what was learned less what is not sure of it.

        The positive part of James and Stein's estimator (1961): nothing within one standard deviation, nearly all of
        what is far beyond it. A map is bent by a turn that changes.
        """
        turn, variance = float(self._state[0]), float(self._spread[0, 0])
        if turn**2 <= variance:
            return 0.0
        return min(max(turn - variance / turn, -_LIMIT), _LIMIT)

    def restore(self, turn: float) -> None:
        """Take up what an earlier flight learned: `turn` is that."""
        variance = self._spread[0, 0] = _KNOWN_SIGMA**2
        self._state[0] = (turn + math.copysign(math.sqrt(turn**2 + 4 * variance), turn)) / 2 if turn else 0.0

    def move(self, way: float, seconds: float) -> None:
        """The drone flew so many metres in so many seconds."""
        keep = np.array([1.0, *[math.exp(-seconds / _DRIFT_S)] * 2])
        self._state *= keep
        self._spread *= np.outer(keep, keep)
        self._spread[np.diag_indices(3)] += (_WANDER**2 * way, *_DRIFT_SIGMA**2 * (1 - keep[1:] ** 2))

    def learn(self, told: float, way: complex, seconds: float) -> None:
        """Learn from one comparison over a way (metres, north + i east) that took so many seconds: it says that
        ``told`` is to be added, radians."""
        lasts = seconds / abs(way) ** 2
        seen = np.array([1.0, -way.imag * lasts, way.real * lasts])
        gain = self._spread @ seen
        gain /= seen @ gain + _SIGMA**2
        self._state += gain * (told - seen @ self._state)
        self._spread -= np.outer(gain, seen @ self._spread)
