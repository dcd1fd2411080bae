"""The best tour found over the known lot: what a planner could fly at best if it knew the border before.

Lines to and fro in many directions, with gaps flown over or round, are the beginnings; the shortest of them are
annealed by the search that the planner has, for much longer and with the whole truth. What comes of it is flown,
changed a little and flown again (`polish`): only a flight shows what a leaning camera sees. The oracle knows no fence
and no error, turns cost it nothing, and it may turn on the spot where it begins and ends: it is meant to be hard to
beat.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchmarks.exploration.lots import Lot
from benchmarks.exploration.polish import OracleTour, polished
from benchmarks.exploration.setups import Setup
from benchmarks.exploration.surveyed import FINE_M, drawn
from benchmarks.exploration.tour_flights import TourFlights
from hawk.algo.ground import Floats, Window
from hawk.algo.path_plan.footprint import Footprint
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.path_plan.tour import Terms, Tour, Wanted, length_of

VERSION: Final = 6
"""Rises with every change of the search: older tours in a cache are then made again."""
_CELLS: Final = 1000
_HEADINGS: Final = 36
_OFFSETS: Final = (0.0, 0.25, 0.5, 0.75)
_STARTS: Final = 4
_SPREAD_RAD: Final = math.radians(20)
_SHORT_BY: Final = 12.0
_SWEEPS: Final = 120
_HOT_M: Final = 6.0
_AGAIN: Final = 25
_WARM_M: Final = 1.0
_COLD_M: Final = 0.15
_STEPS_M: Final = ((1.5, 12.0), (0.5, 4.0), (0.0, 1.2))
"""Heat from which on waypoints are shifted by so much."""
_SHARES: Final = (0.78, 0.82, 0.85, 0.88, 0.90, 0.915, 0.93, 0.945, 0.96, 0.97, 0.98, 0.987, 0.993, 0.998)
"""The search knows nothing of what turns show: from few legs on, the first tour that shows enough as flown counts."""


@dataclass(frozen=True, slots=True)
class _Ground:
    wanted: Wanted
    terms: Terms
    start: Floats

    def with_share(self, share: float) -> _Ground:
        return replace(self, wanted=replace(self.wanted, spare=(1 - share) * self.wanted.total))


def best_tour(lot: Lot, setup: Setup, wanted: float) -> OracleTour:
    """Return the shortest tour that showed the wanted share of the lot. Equal calls give equal tours.

    Two searches are made: one that turns on the spot where a tour begins and ends, and counts on what turns show, and
    one that knows of legs only. Raises ValueError when neither shows enough.
    """
    found = [_best(lot, setup, wanted, turns=turns) for turns in (False, True)]
    tours = [tour for tour in found if tour is not None]
    if not tours:
        raise ValueError(f"seed {lot.seed}: no tour shows {wanted:.0%} of the lot")
    return min(tours, key=lambda tour: tour.distance_m)


def _best(lot: Lot, setup: Setup, wanted: float, *, turns: bool) -> OracleTour | None:
    """Turns always show more than a search knows of: tours are made for less than what is wanted, and flown."""
    rng = np.random.default_rng([lot.seed, 7])
    flights = TourFlights(lot, setup, turns=turns)
    ground = _ground(lot, setup, turns=turns).with_share(wanted)
    shares = _SHARES[0 if turns else 1 :]
    annealed = sorted((_annealed(ground, one, rng, _SWEEPS, _HOT_M) for one in _beginnings(ground)), key=length_of)
    found = []
    for tour in annealed[:2]:
        for share in shares:
            tour = _annealed(ground.with_share(share), tour, rng, _AGAIN, _WARM_M)
            flown = flights.fly(tour)
            if flown is not None:
                found.append((flown, tour))
                break
    if not found:
        return None
    best, places = min(found, key=lambda one: one[0].distance_m)
    return polished(best, places, flights.fly, rng)


def _annealed(ground: _Ground, places: Floats, rng: np.random.Generator, sweeps: int, hot: float) -> Floats:
    """Return the shortest tour met that shows enough, the last one if none did."""
    tour = Tour(ground.terms, ground.wanted, places, None, rng)
    best, least = None, math.inf
    for sweep in range(sweeps):
        heat = hot * (_COLD_M / hot) ** (sweep / max(sweeps - 1, 1))
        step = next(step for above, step in _STEPS_M if heat > above) * ground.terms.footprint.width / 40
        tour.sweep(step, heat)
        length = length_of(tour.places)
        if tour.missing <= ground.wanted.spare and length < least:
            best, least = tour.places, length
    return tour.places if best is None else best


def _ground(lot: Lot, setup: Setup, *, turns: bool) -> _Ground:
    low, high = np.array(lot.shape.bounds[:2]), np.array(lot.shape.bounds[2:])
    window = Window.around(np.array([low, high]), FINE_M, 1.0)
    cells = np.argwhere(drawn(lot.shape, window) > 0)
    step = max(1, round(math.sqrt(len(cells) / _CELLS)))
    cells = cells[(cells[:, 0] % step == 0) & (cells[:, 1] % step == 0)]
    places = np.column_stack([-(window.row + cells[:, 0] + 0.5), window.column + cells[:, 1] + 0.5]) * FINE_M
    weights = np.full(len(places), (step * FINE_M) ** 2, np.float32)
    swath = setup.swath
    footprint = Footprint.of(swath, PathPlanSettings()) if turns else Footprint(swath.width, swath.depth)
    wanted = Wanted(places.astype(np.float32), weights, 0.0)
    return _Ground(wanted, Terms(footprint, _SHORT_BY, trials=24, turned_first=turns), np.array(lot.start))


def _beginnings(ground: _Ground) -> list[Floats]:
    """Return the shortest tours to and fro, of directions that differ."""
    found: list[tuple[float, float, Floats]] = []
    for number in range(_HEADINGS):
        heading = math.pi * number / _HEADINGS
        options = [_to_and_fro(ground, heading, offset) for offset in _OFFSETS]
        tour = min(options, key=length_of)
        found.append((length_of(tour), heading, tour))
    found.sort(key=lambda one: one[0])
    chosen: list[tuple[float, float, Floats]] = []
    for one in found:
        if all(abs(math.remainder(one[1] - other[1], math.pi)) > _SPREAD_RAD for other in chosen):
            chosen.append(one)
    return [tour for _, _, tour in chosen[:_STARTS]]


def _to_and_fro(ground: _Ground, heading: float, offset: float) -> Floats:
    c, s = math.cos(heading), math.sin(heading)
    turned = ground.wanted.cells @ np.array([[c, -s], [s, c]])  # along, across
    lines = _lines(turned, ground, offset)
    start = ground.start @ np.array([[c, -s], [s, c]])
    ordered = _ordered(lines, start)
    back = np.array([[c, s], [-s, c]])
    return np.vstack([ground.start, ordered @ back])


def _lines(turned: Floats, ground: _Ground, offset: float) -> list[Floats]:
    """Return lines (2, 2) of (along, across) that together show all cells."""
    low, high = float(turned[:, 1].min()), float(turned[:, 1].max())
    count = max(1, math.ceil((high - low) / ground.terms.footprint.width - 0.1 + offset / 2))
    pitch = max((high - low) / count, 1e-6)
    reach = ground.terms.footprint.depth / 2
    lines = []
    for number in range(count):
        begin = low + number * pitch
        band = np.sort(turned[(turned[:, 1] >= begin - 1e-9) & (turned[:, 1] <= begin + pitch + 1e-9), 0])
        if len(band) == 0:
            continue
        middle = begin + pitch / 2
        for part in np.split(band, np.flatnonzero(np.diff(band) > ground.terms.footprint.depth) + 1):
            first, last = part[0] + reach, part[-1] - reach
            if first > last:
                first = last = (part[0] + part[-1]) / 2
            lines.append(np.array([[first, middle], [last, middle]]))
    return lines


def _ordered(lines: list[Floats], start: NDArray[np.float64]) -> Floats:
    """Return the lines' ends in a good order: cheapest insertion, then turns and moves of single lines."""
    order: list[Floats] = []
    for line in sorted(lines, key=lambda one: -float(abs(one[1, 0] - one[0, 0]))):
        order = min(_inserted(order, line), key=lambda o: _length(o, start))
    best, improved = _length(order, start), True
    while improved:
        improved = False
        for index in range(len(order)):
            rest = order[:index] + order[index + 1 :]
            option = min(_inserted(rest, order[index]), key=lambda o: _length(o, start))
            length = _length(option, start)
            if length < best - 1e-6:
                order, best, improved = option, length, True
    return np.vstack(order)


def _inserted(order: list[Floats], line: Floats) -> list[list[Floats]]:
    return [[*order[:at], strip, *order[at:]] for at in range(len(order) + 1) for strip in (line, line[::-1])]


def _length(order: list[Floats], start: NDArray[np.float64]) -> float:
    return length_of(np.vstack([start, *order]))
