"""What tours cost when they are flown: the way, and what the pictures on it would not show.

The secret is how much is reckoned: the first way points are flown in the mind (`following`) and looked at picture by
picture, leaning as the drone leans; what lies beyond them is weighed by its legs (`footprint`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from hawk.algo.path_plan.following import Flights, Motion, fly
from hawk.algo.path_plan.footprint import Bools, Corners, Floats, Singles, directions
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.path_plan.tour import Terms, Wanted, length_of

_AHEAD_M: Final = 80.0
_MOST_POINTS: Final = 6
"""So much of a tour, and no more way points, is flown in the mind."""
_MOST_STEPS: Final = 130
_EVERY: Final = 2
"""Every such step of a flight is looked at: a picture each half second."""


@dataclass(frozen=True, slots=True)
class _Left:
    """What is to be shown near the flights, as in `Wanted`, and square metres ``elsewhere``, where none comes."""

    cells: Singles
    weights: Singles
    elsewhere: float


@dataclass(frozen=True, slots=True)
class Rehearsal:
    """Weighs tours that begin at the drone."""

    wanted: Wanted
    terms: Terms
    motion: Motion
    settings: PathPlanSettings

    def costs(self, tours: Sequence[Floats]) -> Floats:
        """Return what tours (K, 2) cost, metres: way, way points and what is not shown. Each begins at the drone."""
        heads, tails = [tour[1 : 1 + flown_ahead(tour)] for tour in tours], [_tail(tour) for tour in tours]
        flights = fly(self.motion, _padded(heads), np.array([len(head) for head in heads]), self.settings, _MOST_STEPS)
        lefts, missed = dict[bytes, _Left](), np.empty(len(tours))
        for number, (head, tail) in enumerate(zip(heads, tails, strict=True)):
            left = lefts.get(tail.tobytes())
            if left is None:
                left = lefts[tail.tobytes()] = self._left(flights, tail)
            missed[number] = self._missed(flights, number, left, end=head[-1] if len(head) and not len(tail) else None)
        points = np.array([len(tour) - 1 for tour in tours])
        way = flights.ways + [length_of(tail) for tail in tails] + self.terms.leg_m * points
        return np.asarray(way + self.terms.penalty(missed, self.wanted.spare))

    def _left(self, flights: Flights, tail: Floats) -> _Left:
        """Return what the legs of a tour's last part leave to its flight."""
        left = self._not_shown_by_legs(tail)
        near = _about(left.cells, flights, self.terms.footprint.width)
        return _Left(left.cells[near], left.weights[near], float(left.weights[~near].sum()))

    def _missed(self, flights: Flights, number: int, left: _Left, end: Floats | None) -> float:
        """Return the square metres of what is left that neither a flight nor the turn at its ``end`` shows."""
        foot, looks = self.terms.footprint, np.flatnonzero(flights.flies[:, number])[::_EVERY]
        shown = foot.seen(
            left.cells, flights.places[looks, number], flights.yaws[looks, number], flights.leans[looks, number]
        ).any(0)
        if end is not None:
            shown |= ((left.cells - end.astype(np.float32)) ** 2).sum(1) < foot.spun**2
        return left.elsewhere + float(left.weights @ ~shown)

    def _not_shown_by_legs(self, tail: Floats) -> Wanted:
        """Return what the legs of a tour's last part do not show."""
        if len(tail) < 2:
            return self.wanted
        foot, legs = self.terms.footprint, directions(np.diff(tail, axis=0))
        before, order = np.vstack([legs[:1], legs[:-1]]), np.arange(len(legs))
        corners = Corners(before, np.full(len(legs), foot.turned), order == len(order) - 1)
        left = ~foot.shown(self.wanted.cells, tail[:-1], tail[1:], corners).any(0)
        return Wanted(self.wanted.cells[left], self.wanted.weights[left], self.wanted.spare)


def flown_ahead(tour: Floats) -> int:
    """Return how many way points of a tour (K, 2) are flown in the mind: the first ones, not the drone's place."""
    along = np.cumsum(np.hypot(*np.diff(tour, axis=0).T))
    return min(int(np.searchsorted(along, _AHEAD_M)) + 1, _MOST_POINTS, len(along))


def _tail(tour: Floats) -> Floats:
    """Return the places from the last one on that is flown in the mind; none when that is the tour's end."""
    ahead = flown_ahead(tour)
    return tour[ahead:] if ahead < len(tour) - 1 else tour[:0]


def _padded(heads: Sequence[Floats]) -> Floats:
    """Return way points of several tours as one array (B, K, 2)."""
    result = np.zeros((len(heads), max(1, *(len(head) for head in heads)), 2))
    for row, head in zip(result, heads, strict=True):
        row[: len(head)] = head
    return result


def _about(cells: Singles, flights: Flights, margin: float) -> Bools:
    """Return which cells (N, 2) lie in the box about all flights, with a margin."""
    if not len(flights.places):
        return np.zeros(len(cells), np.bool_)
    low, high = flights.places.min((0, 1)) - margin, flights.places.max((0, 1)) + margin
    return np.asarray(((cells >= low) & (cells <= high)).all(1))
