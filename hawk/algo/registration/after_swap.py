"""Finds where the drone is on the map of the flight before a battery swap: its position is off by another metre or two.

Rows repeat at every pitch, so that places alone often fit a stall farther along as well. Row ends distinguish the
shifts, and so do taken stalls while the swap is young: cars stay for some minutes. The frames until then are not fused.
A map of another day is registered as a whole (`hawk.algo.registration`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from hawk.algo.vision import quads

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Inside = Callable[[Floats], Bools]
"""Returns True for the places (N, 2) that lie inside some ground."""

SAME_CARS_S: Final = 1800.0
"""After this time other cars may stand in the stalls."""
REACH_M: Final = 3.0
"""Largest shift that is sought, along each axis."""
STEP_M: Final = 0.3
_LEAST_STALLS: Final = 4
_MATCH_M: Final = 0.7  # beyond it a found stall is another one
_ANGLE: Final = 0.2
_OTHER_STATE: Final = -0.5  # a match of a free and a taken stall; equal ones count 1
_NO_STALL: Final = -0.7  # found where the map shows ground that was seen well, and no stall
_NOT_FOUND: Final = -0.5  # on the map and in the picture, yet not found
_APART_M: Final = 1.0  # shifts nearer to each other are the same one
_LEAD: Final = 8.0  # of the best shift before any other, over all frames
_LEAST_FRAMES: Final = 3
_MOST_FRAMES: Final = 40
_USUAL_M: Final = 1.5  # standard deviation of the shift between two flights


@dataclass(frozen=True, slots=True)
class Stalls:
    """Stalls: ``places`` (N, 2) of (north, east), ``angles`` (N,) in radians, ``taken`` (N,) 0..1, 0.5 for unknown."""

    places: Floats
    angles: Floats
    taken: Floats


class AfterSwap:
    """Adds up how well each shift fits, frame by frame, until one is better than all others."""

    def __init__(self, *, has_same_cars: bool = True) -> None:
        """Begin. ``has_same_cars``: the swap is younger than `SAME_CARS_S`; else the states of stalls say nothing."""
        self._has_same_cars = has_same_cars
        steps = np.arange(-round(REACH_M / STEP_M), round(REACH_M / STEP_M) + 1) * STEP_M
        north, east = np.meshgrid(steps, steps, indexing="ij")
        self._shifts = np.column_stack([north.ravel(), east.ravel()])
        self._scores = -0.5 * (self._shifts**2).sum(1) / _USUAL_M**2
        self._frames = self._doubts = 0
        self.is_over = False
        """True when a shift was found, or none is better than the others."""

    def look(self, known: Stalls, found: Stalls, in_picture: Inside, was_seen: Inside) -> Floats | None:
        """Learn from a frame; return the shift (2,) north and east, metres, once it is certain.

        Args:
            known: Stalls of the earlier flight.
            found: Stalls of the frame, whole ones, placed as it is believed so far.
            in_picture: Of the frame, placed likewise.
            was_seen: Ground that the earlier flight saw well.

        Raises:
            TooFewError: The frame shows too little of the earlier map to compare.
        """
        if len(found.places) < _LEAST_STALLS or in_picture(known.places).sum() < _LEAST_STALLS:
            raise TooFewError
        self._frames += 1
        self._scores += self._fit(known, found, in_picture, was_seen)
        best = int(np.argmax(self._scores))
        away = np.hypot(*(self._shifts - self._shifts[best]).T)
        lead = self._scores[best] - self._scores[away > _APART_M].max()
        if self._frames >= _LEAST_FRAMES and lead >= _LEAD:
            self.is_over = True
            return _refined(self._shifts[best], known, found)
        self.is_over = self._frames >= _MOST_FRAMES
        return None

    def is_doubtful(self, known: Floats, found: Floats) -> bool:
        """Return True for a frame of too few stalls of which one may be a known one: fused now, it would count twice.

        Where it stays so, the frames after the first `_MOST_FRAMES` are not doubtful. ``known`` (N, 2) and ``found``
        (M, 2) are places, as for `look`.
        """
        away, _ = cKDTree(known).query(found, distance_upper_bound=math.sqrt(2) * REACH_M)
        if not np.isfinite(away).any():
            return False
        self._doubts += 1
        return self._doubts <= _MOST_FRAMES

    def _fit(self, known: Stalls, found: Stalls, in_picture: Inside, was_seen: Inside) -> Floats:
        """Return how well each shift fits (S,): by the found stalls, and by the known ones that should be found."""
        shifts, count = self._shifts, len(found.places)
        places = (shifts[:, None] + found.places).reshape(-1, 2)
        away, nearest = cKDTree(known.places).query(places, distance_upper_bound=_MATCH_M)
        is_match = nearest < len(known.places)
        nearest = np.where(is_match, nearest, 0)
        is_match &= quads.angle_between(known.angles[nearest], np.tile(found.angles, len(shifts))) < _ANGLE
        alike = 1 - np.abs(known.taken[nearest] - np.tile(found.taken, len(shifts)))
        state = _OTHER_STATE + (1 - _OTHER_STATE) * alike if self._has_same_cars else np.ones(len(nearest))
        worth = state * (1 - (np.where(is_match, away, 0) / _MATCH_M) ** 2)
        score = np.where(is_match, worth, np.where(was_seen(places), _NO_STALL, 0.0)).reshape(-1, count).sum(1)
        back = (known.places - shifts[:, None]).reshape(-1, 2)
        missed = in_picture(back) & ~np.isfinite(cKDTree(found.places).query(back, distance_upper_bound=_MATCH_M)[0])
        return np.asarray(score + _NOT_FOUND * missed.reshape(len(shifts), -1).sum(1))


class TooFewError(Exception):
    """The frame shows too little of the earlier map."""


def _refined(shift: Floats, known: Stalls, found: Stalls) -> Floats:
    """Return the shift between two steps: the median of the matches' residuals is added."""
    places = found.places + shift
    away, nearest = cKDTree(known.places).query(places, distance_upper_bound=_MATCH_M)
    near = np.isfinite(away)
    if near.sum() < _LEAST_STALLS:
        return shift
    return np.asarray(shift + np.median(known.places[nearest[near]] - places[near], 0))
