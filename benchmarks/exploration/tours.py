"""Tours over a lot whose border is known: polylines, what they show, and annealing that shortens them.

The secret is the search. A tour is a polyline from the start; what it shows is what its legs show, each leg a swath as
wide as the footprint, longer than the leg by the footprint's depth. Moves (shift, drop, add and exchange of way points)
are tried many at once and drawn by their cost (heat bath), ever colder.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_TRIALS: Final = 24
_STEPS_M: Final = (12.0, 4.0, 1.2)
_SHORT_BY: Final = 4.0  # what is not seen costs so many times the way that sweeps it
_HOT_M: Final = 6.0
_COLD_M: Final = 0.15


@dataclass(frozen=True, slots=True)
class Ground:
    """What is to be shown: ``cells`` (N, 2) of (north, east), each ``area`` square metres; the start; the footprint.

    ``width`` across and ``depth`` along a leg, metres; ``is_disc``: both are the disc's diameter.
    """

    cells: Floats
    area: float
    start: Floats
    width: float
    depth: float
    is_disc: bool
    wanted: float

    def shown(self, begins: Floats, ends: Floats) -> Bools:
        """Return (K, N): which cells each of K legs shows."""
        leg = ends - begins
        length = np.hypot(leg[:, 0], leg[:, 1])
        unit = leg / np.maximum(length, 1e-9)[:, None]
        # one product of matrices gives both coordinates of every cell about every leg
        turn = np.concatenate([unit, np.column_stack([-unit[:, 1], unit[:, 0]])]).astype(np.float32)
        origin = np.concatenate([(begins * unit).sum(1), begins[:, 1] * unit[:, 0] - begins[:, 0] * unit[:, 1]])
        turned = turn @ self.cells.T.astype(np.float32) - origin[:, None].astype(np.float32)
        along, across = turned[: len(leg)], turned[len(leg) :]
        along -= (length / 2).astype(np.float32)[:, None]
        np.abs(along, out=along)
        half = (length / 2).astype(np.float32)[:, None]
        if self.is_disc:
            beyond = np.maximum(along - half, 0)
            return np.asarray(beyond * beyond + across * across <= (self.width / 2) ** 2)
        return np.asarray((np.abs(across) <= self.width / 2) & (along <= half + self.depth / 2))


def length_of(tour: Floats) -> float:
    """Return the length of a polyline (K, 2), metres."""
    return float(np.hypot(*np.diff(tour, axis=0).T).sum())


class Annealer:
    """Anneals one tour (K, 2), its first row the start."""

    def __init__(self, ground: Ground, tour: Floats, rng: Generator) -> None:
        self._ground = ground
        self._rng = rng
        self._tour = tour
        self._spare = (1.0 - ground.wanted) * len(ground.cells)
        self._price = _SHORT_BY * ground.area / ground.width
        self._refresh()
        self.best: Floats | None = None
        self.best_length = math.inf

    def run(self, sweeps: int, hot: float = _HOT_M) -> None:
        """Go through all way points so many times; `best` is the shortest tour that shows enough, if there was one.

        ``hot`` is the heat to begin with, metres: less of it changes a good tour less.
        """
        for sweep in range(sweeps):
            heat = hot * (_COLD_M / hot) ** (sweep / max(sweeps - 1, 1))
            step = self._ground.width / 40 * (_STEPS_M[0] if heat > 1.5 else _STEPS_M[1] if heat > 0.5 else _STEPS_M[2])
            index = 1
            while index < len(self._tour):
                self._shift(index, step, heat)
                index += 1
            self._drop(heat)
            self._add(heat)
            self._exchange(heat)
            self._note()

    def _refresh(self) -> None:
        self._legs = self._ground.shown(self._tour[:-1], self._tour[1:])
        self._count = self._legs.sum(0, dtype=np.int16)

    def _cost(self, missing: NDArray[np.intp] | NDArray[np.float64]) -> Floats:
        return np.maximum(np.asarray(missing, np.float64) - self._spare, 0.0) * self._price

    def _missing_without(self, legs: slice) -> tuple[Bools, NDArray[np.int16]]:
        rest = self._count - self._legs[legs].sum(0, dtype=np.int16)
        return rest == 0, rest

    def _drawn(self, costs: Floats, heat: float) -> int:
        """Draw one of the alternatives by its cost."""
        weights = np.exp(-(costs - costs.min()) / heat)
        return int(np.searchsorted(np.cumsum(weights), self._rng.random() * weights.sum()))

    def _shift(self, index: int, step: float, heat: float) -> None:
        tour, ground = self._tour, self._ground
        offsets = self._rng.normal(0.0, step, (_TRIALS, 2))
        offsets[0] = 0.0
        places = tour[index] + offsets
        is_last = index == len(tour) - 1
        unseen, _ = self._missing_without(slice(index - 1, index if is_last else index + 1))
        before = np.broadcast_to(tour[index - 1], places.shape)
        shown = ground.shown(before, places)
        lengths = np.hypot(*(places - before).T)
        after_legs = None
        if not is_last:
            after = np.broadcast_to(tour[index + 1], places.shape)
            after_legs = ground.shown(places, after)
            lengths = lengths + np.hypot(*(after - places).T)
        both = shown if after_legs is None else shown | after_legs
        costs = lengths + self._cost((unseen & ~both).sum(1))
        chosen = self._drawn(costs, heat)
        if chosen == 0:
            return
        self._count = self._count - self._legs[index - 1] + shown[chosen]
        self._legs[index - 1] = shown[chosen]
        if after_legs is not None:
            self._count = self._count - self._legs[index] + after_legs[chosen]
            self._legs[index] = after_legs[chosen]
        tour[index] = places[chosen]

    def _present(self) -> float:
        return length_of(self._tour) + float(self._cost(np.array([(self._count == 0).sum()]))[0])

    def _try(self, tours: list[Floats], heat: float) -> None:
        """Draw one of the tours, the first being the present one."""
        costs = np.empty(len(tours))
        costs[0] = self._present()
        kept = []
        for number, tour in enumerate(tours[1:], 1):
            legs = self._ground.shown(tour[:-1], tour[1:])
            costs[number] = length_of(tour) + float(self._cost(np.array([(~legs.any(0)).sum()]))[0])
            kept.append(legs)
        chosen = self._drawn(costs, heat)
        if chosen:
            self._tour, self._legs = tours[chosen], kept[chosen - 1]
            self._count = self._legs.sum(0, dtype=np.int16)

    def _drop(self, heat: float) -> None:
        if len(self._tour) <= 2:
            return
        picks = self._rng.permutation(np.arange(1, len(self._tour)))[:4]
        self._try([self._tour, *(np.delete(self._tour, pick, axis=0) for pick in picks)], heat)

    def _add(self, heat: float) -> None:
        """Add a way point: near what is not seen, or on a leg."""
        unseen = np.flatnonzero(self._count == 0)
        tours = [self._tour]
        for _ in range(4):
            if len(unseen) and self._rng.random() < 0.7:
                place = self._ground.cells[unseen[int(self._rng.integers(len(unseen)))]]
                place = place + self._rng.normal(0.0, self._ground.width / 6, 2)
            else:
                at = int(self._rng.integers(1, len(self._tour)))
                place = self._tour[at - 1 : at + 1].mean(0) + self._rng.normal(0.0, self._ground.width / 10, 2)
            tours.append(np.insert(self._tour, self._cheapest_gap(place), place, axis=0))
        self._try(tours, heat)

    def _cheapest_gap(self, place: Floats) -> int:
        away = np.hypot(*(self._tour - place).T)
        detour = away[:-1] + away[1:] - np.hypot(*np.diff(self._tour, axis=0).T)
        at = int(np.argmin(detour))
        return len(self._tour) if away[-1] < detour[at] else at + 1

    def _exchange(self, heat: float) -> None:
        """Turn a part of the tour round, or move it elsewhere."""
        size = len(self._tour)
        if size <= 3:
            return
        tours = [self._tour]
        for _ in range(6):
            first, last = np.sort(self._rng.choice(np.arange(1, size), 2, replace=False))
            part, rest = self._tour[first : last + 1], np.delete(self._tour, slice(first, last + 1), axis=0)
            if self._rng.random() < 0.5:
                tours.append(np.concatenate([self._tour[:first], part[::-1], self._tour[last + 1 :]]))
            else:
                at = int(self._rng.integers(1, len(rest) + 1))
                part = part[::-1] if self._rng.random() < 0.5 else part
                tours.append(np.concatenate([rest[:at], part, rest[at:]]))
        self._try(tours, heat)

    def _note(self) -> None:
        if (self._count == 0).sum() <= self._spare:
            length = length_of(self._tour)
            if length < self.best_length:
                self.best, self.best_length = self._tour.copy(), length
