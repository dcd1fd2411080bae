"""The tour that is being flown: followed from frame to frame, bettered a little at each, replaced by a better one.

The secret is how the search is spread over frames, so that none takes long: the present tour is only ever improved; a
challenger is begun elsewhere, cooled over some frames, and takes over when it is shorter by a margin.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from hawk.algo.path_plan.field import Place
from hawk.algo.path_plan.footprint import Floats
from hawk.algo.path_plan.tour import Terms, Tour, Wanted

_FIRST_SWEEPS: Final = 6
_CHALLENGE_FRAMES: Final = 8
_HOT_M: Final = 6.0
_COLD_M: Final = 0.2
_SWEEPS: Final = 2
_MOST_SHIFTS: Final = 12
_STEPS_M: Final = (6.0, 2.0, 0.7)


@dataclass(frozen=True, slots=True)
class Outlook:
    """What one frame's search is made from: the drone's place and heading (radians), and what is wanted."""

    place: Place
    yaw: float
    wanted: Wanted
    terms: Terms


class Course:
    """Keeps the tour of one exploration."""

    def __init__(self, arrival_m: float, margin_m: float) -> None:
        """A way point is reached within ``arrival_m``; a challenger must be shorter by ``margin_m``."""
        self._arrival = arrival_m
        self._margin = margin_m
        self._rng = np.random.default_rng(0)
        self._tour: Tour | None = None
        self._challenger: Tour | None = None
        self._cooled = 0
        self._frame = 0

    def follow(self, outlook: Outlook) -> Floats:
        """Return the way points still to be flown (K, 2), none when nothing is worth the way."""
        self._frame += 1
        if self._tour is None:
            self._tour = self._begun(outlook)
            for sweep in range(_FIRST_SWEEPS):
                self._sweep(self._tour, _HOT_M * (_COLD_M / _HOT_M) ** (sweep / _FIRST_SWEEPS))
        else:
            self._meet(self._tour, outlook)
        self._sweep(self._tour, 0.0)
        self._challenge(outlook)
        return self._tour.places[1:]

    def _challenge(self, outlook: Outlook) -> None:
        if self._challenger is None:
            self._challenger = self._begun(outlook)
            self._cooled = 0
        else:
            self._meet(self._challenger, outlook)
        self._cooled += 1
        share = self._cooled / _CHALLENGE_FRAMES
        self._sweep(self._challenger, 0.0 if share >= 1 else _HOT_M * (_COLD_M / _HOT_M) ** share)
        if share < 1:
            return
        assert self._tour is not None  # noqa: S101 - follow() made it
        if self._challenger.cost < self._tour.cost - self._margin:
            self._tour = self._challenger
        self._challenger = None

    def _begun(self, outlook: Outlook) -> Tour:
        return Tour(outlook.terms, outlook.wanted, np.array([outlook.place]), outlook.yaw, self._rng)

    def _meet(self, tour: Tour, outlook: Outlook) -> None:
        """Go on from where the drone is by now."""
        left = tour.places[1:]
        while len(left) and math.dist(left[0], outlook.place) <= self._arrival:
            left = left[1:]
        tour.meet(outlook.terms, outlook.wanted, np.vstack([outlook.place, left]), outlook.yaw)

    def _sweep(self, tour: Tour, heat: float) -> None:
        """Try to better every way point, and the tour as a whole, some times."""
        for number in range(_SWEEPS):
            step = _STEPS_M[(self._frame + number) % len(_STEPS_M)] if heat < 1.0 else _STEPS_M[0]
            for index in range(1, min(len(tour.places), _MOST_SHIFTS + 1)):
                tour.shift(index, step, heat)
            tour.drop(heat)
            tour.add(heat)
            tour.exchange(heat)
