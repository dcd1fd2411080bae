"""The tour that is being flown: followed from frame to frame, bettered a little at each, replaced by a better one.

The secret is how the search is spread over frames, so that none takes long: the present tour is only ever improved; a
challenger is begun elsewhere, cooled over some frames, and takes over when it is cheaper by a margin. What a tour costs
is told by its legs, or, where the settings ask for it, by flying it in the mind (`rehearsal`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.random import Generator

from hawk.algo.path_plan.field import Place
from hawk.algo.path_plan.following import Motion
from hawk.algo.path_plan.footprint import Floats
from hawk.algo.path_plan.rehearsal import Rehearsal, flown_ahead
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.path_plan.tour import Terms, Tour, Wanted, as_place

_FIRST_SWEEPS: Final = 6
_CHALLENGE_FRAMES: Final = 8
_HOT_M: Final = 6.0
_COLD_M: Final = 0.2
_SWEEPS: Final = 2
_MOST_SHIFTS: Final = 12
_STEPS_M: Final = (6.0, 2.0, 0.7)
_CHANGES: Final = 20
_DROPPED: Final = 0.15
_ADDED: Final = 0.25
_ADDED_OFF_M: Final = 6.0
_CHANGED_M: Final = 0.2
_SEARCHED_M: Final = 0.5
"""So much cheaper a change of the tour, and what the search made of it, must be: what is equal stays."""


@dataclass(frozen=True, slots=True)
class Outlook:
    """What one frame's search is made from: how the drone moves, and what is wanted."""

    motion: Motion
    wanted: Wanted
    terms: Terms

    @property
    def place(self) -> Place:
        """Where the drone is."""
        return as_place(self.motion.place)

    @property
    def yaw(self) -> float:
        """The picture's heading, radians."""
        return self.motion.yaw


class Course:
    """Keeps the tour of one exploration."""

    def __init__(self, settings: PathPlanSettings) -> None:
        self._settings = settings
        self._rng = np.random.default_rng(0)
        self._tour: Tour | None = None
        self._challenger: Tour | None = None
        self._cooled = 0
        self._frame = 0

    def prepare(self, outlook: Outlook) -> None:
        """Search for the first tour, a part with every frame, while the drone does not follow it yet."""
        self._frame += 1
        if self._tour is None:
            self._tour = self._challenged(outlook)
        else:
            self._go_on(self._tour, outlook)

    def follow(self, outlook: Outlook) -> Floats:
        """Return the way points still to be flown (K, 2), none when nothing is worth the way."""
        self._frame += 1
        if self._tour is None:
            self._tour = self._begun(outlook)
            for sweep in range(_FIRST_SWEEPS):
                self._sweep(self._tour, _HOT_M * (_COLD_M / _HOT_M) ** (sweep / _FIRST_SWEEPS))
        self._go_on(self._tour, outlook)
        return self._tour.places[1:]

    def _go_on(self, tour: Tour, outlook: Outlook) -> None:
        """Better the tour from where the drone is by now."""
        self._meet(tour, outlook)
        if self._settings.rehearses:
            self._better_as_flown(tour, outlook)
        else:
            self._better(tour, outlook)

    def _better(self, tour: Tour, outlook: Outlook) -> None:
        """Better the tour by what its legs show, or let the challenger take over."""
        self._sweep(tour, 0.0)
        challenger = self._challenged(outlook)
        if challenger is not None and challenger.cost < tour.cost - self._settings.switch_m:
            self._tour = challenger

    def _better_as_flown(self, tour: Tour, outlook: Outlook) -> None:
        """Let the tour be the cheapest of what stands against it, as flown."""
        searched = Tour(outlook.terms, outlook.wanted, tour.places, outlook.yaw, self._rng)
        self._sweep(searched, 0.0)
        options = [(0.0, tour.places), (_SEARCHED_M, searched.places)]
        options += [(_CHANGED_M, places) for places in changed(tour.places, outlook.terms, self._rng)]
        challenger = self._challenged(outlook)
        if challenger is not None:
            options.append((self._settings.switch_m, challenger.places))
        rehearsal = Rehearsal(outlook.wanted, outlook.terms, outlook.motion, self._settings)
        costs = rehearsal.costs([places for _, places in options])
        costs += [dearer + self._kept(tour.places, places, outlook) for dearer, places in options]
        best = int(np.argmin(costs))
        if best > 0:
            tour.meet(outlook.terms, outlook.wanted, options[best][1], outlook.yaw)

    def _kept(self, tour: Floats, places: Floats, outlook: Outlook) -> float:
        """Return what a tour must be cheaper, metres, for flying elsewhere than to where the drone is on its way to."""
        if len(tour) < 2:
            return 0.0
        away = np.hypot(*(places[1:] - tour[1]).T)
        return 0.0 if (away <= outlook.terms.footprint.depth / 2).any() else outlook.terms.keep_m

    def _challenged(self, outlook: Outlook) -> Tour | None:
        """Cool the challenger by one frame; return it when it is cold, and begin another with the next frame."""
        if self._challenger is None:
            self._challenger, self._cooled = self._begun(outlook), 0
        else:
            self._meet(self._challenger, outlook)
        self._cooled += 1
        share = self._cooled / _CHALLENGE_FRAMES
        self._sweep(self._challenger, 0.0 if share >= 1 else _HOT_M * (_COLD_M / _HOT_M) ** share)
        if share < 1:
            return None
        cold, self._challenger = self._challenger, None
        return cold

    def _begun(self, outlook: Outlook) -> Tour:
        return Tour(outlook.terms, outlook.wanted, np.array([outlook.place]), outlook.yaw, self._rng)

    def _meet(self, tour: Tour, outlook: Outlook) -> None:
        """Go on from where the drone is by now."""
        left = tour.places[1:]
        while len(left) and math.dist(left[0], outlook.place) <= self._settings.arrival_m:
            left = left[1:]
        tour.meet(outlook.terms, outlook.wanted, np.vstack([outlook.place, left]), outlook.yaw)

    def _sweep(self, tour: Tour, heat: float) -> None:
        """Try to better every way point, and the tour as a whole, by what its legs show."""
        for number in range(_SWEEPS):
            step = _STEPS_M[(self._frame + number) % len(_STEPS_M)] if heat < 1.0 else _STEPS_M[0]
            for index in range(1, min(len(tour.places), _MOST_SHIFTS + 1)):
                tour.shift(index, step, heat)
            tour.drop(heat)
            tour.add(heat)
            tour.exchange(heat)


def changed(tour: Floats, terms: Terms, rng: Generator) -> list[Floats]:
    """Return tours that differ from a tour (K, 2) in one of the way points that are flown in the mind: moved, left out
    or added."""
    ahead = flown_ahead(tour)
    if ahead == 0:
        return []
    drawn = [_one_changed(tour, int(rng.integers(1, ahead + 1)), rng) for _ in range(_CHANGES)]
    allowed = terms.allowed(np.array([tour[0] if new is None else new for _, new in drawn]))
    return [places for (places, new), may in zip(drawn, allowed, strict=True) if new is None or may]


def _one_changed(tour: Floats, index: int, rng: Generator) -> tuple[Floats, Floats | None]:
    """Return the tour with a way point changed, and that way point, None when it is left out."""
    draw = rng.random()
    if draw < _DROPPED and len(tour) > 2:
        return np.delete(tour, index, axis=0), None
    if draw < _DROPPED + _ADDED:
        new = tour[index - 1 : index + 1].mean(0) + rng.normal(0.0, _ADDED_OFF_M, 2)
        return np.insert(tour, index, new, axis=0), new
    places = tour.copy()
    places[index] += rng.normal(0.0, _STEPS_M[int(rng.integers(len(_STEPS_M)))], 2)
    return places, places[index]
