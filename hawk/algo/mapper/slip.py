"""How far the height and the compass are wrong, from the ground's own movement: a map laid with a wrong height slips.

A frame is laid about the drone's place. Told ``s`` times too high and turned by ``t``, it shows a stall at
drone + s R(t) (stall - drone): while the drone flies by d the stall moves by (1 - s e^{it}) d, with directions as
complex numbers. The usual size of stalls tells of gross errors only, before the drone has moved: from lot to lot it
differs by a tenth.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from hawk.algo.mapper.heading import Heading
from hawk.algo.vision import quads

Floats = NDArray[np.float64]

REACH_M = 1.1
"""Less than half of the narrowest pitch, 2.3 m."""
_BASE_M = 3.0  # way between the two frames that are compared
_STILL_M = 0.03
_LEAST_PAIRS = 6
_SPREAD_M = 0.45  # median absolute deviation above which the pairs do not agree
_SIGMA = 0.06  # of one comparison: share of the height
_FIRST_SIGMA = 0.03  # of most flights
_GROSS_SIGMA = 0.15  # once something shows that the height is grossly wrong
_GROSS = 2.0  # standard deviations
_WANDER = 0.001  # standard deviation by square root of metre: the ground is not level, barometers drift
_LEAST_SIGMA = 0.006
USUAL = (0.90, 1.08)
"""Sizes of stalls (by the usual 2.62 x 5.35 m) that lots have: 2.4 x 4.8 to 2.9 x 5.6 m."""
_SIZE_SHARE = 0.3  # of what is beyond them that one frame takes back
_ENOUGH = 3  # comparisons from which on the movement says more
_SURE, _DOUBTFUL = 0.02, 0.05  # standard deviations of the scale
LIMITS = (0.7, 1.4)
"""Of the height's correction."""


@dataclass(frozen=True, slots=True)
class _Key:
    """An earlier frame, when it was taken (seconds): the drone's place, and its stalls (N, 3), as the height that was
    told lays them."""

    drone: complex
    time: float
    found: Floats


class Slip:
    """``scale`` is what the height that is told must be multiplied by, ``turn`` what is to be added to the heading.

    ``leans`` (N,) is by what share of the drone's way each stall of the last frame moves against the ground, backwards:
    NaN where it was not compared with an earlier frame.
    """

    def __init__(self, *, learns_height: bool = True) -> None:
        """``learns_height`` False: the height is taken for right, ``scale`` stays 1."""
        self._learns_height = learns_height
        self.scale = 1.0
        self.leans: Floats = np.zeros(0)
        self._sigma = _FIRST_SIGMA
        self._heading = Heading()
        self._compared = 0
        self._key: _Key | None = None
        self._last: tuple[complex, float] | None = None

    def restore(self, scale: float, turn: float) -> None:
        """Take up what an earlier flight learned."""
        self.scale = scale
        self._heading.restore(turn)
        self._compared = _ENOUGH

    @property
    def turn(self) -> float:
        """What is to be added to the heading, radians."""
        return self._heading.turn

    @property
    def is_sure(self) -> bool:
        """Whether the scale is known so well that the map can be trusted more than GNSS."""
        return self._sigma < _SURE

    @property
    def is_doubtful(self) -> bool:
        """Whether the scale turned out to be wrong, and so is what was laid by it."""
        return self._sigma > _DOUBTFUL

    def size(self, told: float) -> None:
        """Learn from the size of stalls by the usual one, as the height that is told shows them."""
        if not self._learns_height:
            return
        size = told * self.scale
        within = min(max(size, USUAL[0]), USUAL[1])
        if within == size or self._compared >= _ENOUGH:
            return
        self.scale *= (within / size) ** _SIZE_SHARE
        self._sigma = max(self._sigma, _GROSS_SIGMA)

    def move(self, found: Floats, drone: tuple[float, float], time: float) -> None:
        """Learn from the stalls (N, 3: north, east, angle) of the next frame, taken then (seconds), as the height that
        is told lays them."""
        at = complex(*drone)
        self.leans = np.full(len(found), np.nan)
        last, before = self._last or (at, time)
        step = abs(at - last)
        self._last = at, time
        self._sigma = math.hypot(self._sigma, _WANDER * math.sqrt(step))
        self._heading.move(step, max(time - before, 0.0))
        if self._key is None or step < _STILL_M:  # while the drone stands, GNSS drifts on
            self._key = _Key(at, time, found)
        way = at - self._key.drone
        if abs(way) < _BASE_M:
            return
        if abs(way) < 3 * _BASE_M:
            self._compare(found, way, max(time - self._key.time, 0.0))
        self._key = _Key(at, time, found)

    def _compare(self, found: Floats, way: complex, seconds: float) -> None:
        assert self._key is not None  # noqa: S101 - set by move()
        known = self._key.found
        wrong = complex(math.cos(self.turn), -math.sin(self.turn)) / self.scale
        expected = way * (1 - wrong)
        places = known[:, :2] + (expected.real, expected.imag)
        k, f = mutual_nearest(np.column_stack([places, known[:, 2]]), found[:, :2], found[:, 2])
        if len(k) < _LEAST_PAIRS:
            return
        residual = found[f, :2] - places[k]
        step = np.median(residual, 0)
        if np.median(np.abs(residual - step)) > _SPREAD_M:
            return
        self.leans[f] = (step - residual) @ (way.real, way.imag) / abs(way) ** 2
        measured = 1 - (expected + complex(*step)) / way
        if not LIMITS[0] < abs(measured) * self.scale < LIMITS[1]:
            return
        self._compared += 1
        ratio = measured / wrong
        self._heading.learn(self.turn - math.atan2(ratio.imag, ratio.real), way, seconds)
        self._correct(-math.log(abs(ratio)))

    def _correct(self, scale: float) -> None:
        """Take in a correction of the logarithm of the scale by its certainty (Kalman)."""
        scale = scale if self._learns_height else 0.0
        if abs(scale) > _GROSS * math.hypot(self._sigma, _SIGMA):  # no chance: what was believed of it is void
            self._sigma = max(self._sigma, _GROSS_SIGMA)
        gain = self._sigma**2 / (self._sigma**2 + _SIGMA**2)
        self.scale = min(max(self.scale * math.exp(gain * scale), LIMITS[0]), LIMITS[1])
        self._sigma = max(self._sigma * math.sqrt(1 - gain), _LEAST_SIGMA)


def mutual_nearest(known: Floats, places: Floats, angles: Floats) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return pairs of known stalls (N, 3) and places (M, 2) with directions (M,) that are each other's nearest."""
    if len(known) == 0 or len(places) == 0:
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    _, there = cKDTree(known[:, :2]).query(places, distance_upper_bound=REACH_M)
    _, back = cKDTree(places).query(known[:, :2], distance_upper_bound=REACH_M)
    f = np.flatnonzero(there < len(known))
    f = f[back[there[f]] == f]
    k = there[f]
    good = quads.angle_between(known[k, 2], angles[f]) < 0.2
    return k[good], f[good]
