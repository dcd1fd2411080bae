"""The best tour found over the known lot: what a planner could fly at best if it knew the border before.

Lines to and fro in many directions, with gaps flown over or round, are the beginnings; the shortest of them are
annealed (`tours`). The oracle knows no fence, no error and no turning time: it is meant to be hard to beat.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from benchmarks.exploration.flight import fly
from benchmarks.exploration.lots import Lot
from benchmarks.exploration.pilots import TourPilot
from benchmarks.exploration.setups import Setup
from benchmarks.exploration.surveyed import FINE_M, drawn
from benchmarks.exploration.tours import Annealer, Floats, Ground, length_of
from hawk.algo.mapper.window import Window

VERSION: Final = 1
"""Rises with every change of the search: older tours in a cache are then made anew."""
_CELLS: Final = 1000
_HEADINGS: Final = 36
_OFFSETS: Final = (0.0, 0.25, 0.5, 0.75)
_STARTS: Final = 4
_SWEEPS: Final = 120
_AGAIN: Final = 25
_WARM_M: Final = 1.0
_SHARES: Final = (0.98, 0.95, 0.965, 0.973, 0.987)
_SURE_SHARES: Final = (0.993, 0.998, 1.0)
_SPREAD_RAD: Final = math.radians(20)


@dataclass(frozen=True, slots=True)
class Tour:
    """A tour's way points (K, 2), the start first; way (metres) and seconds until the lot was seen, as flown."""

    places: Floats
    way: float
    seconds: float


def best_tour(lot: Lot, setup: Setup) -> Tour:
    """Return the tour that showed enough of the lot on the shortest way. Equal calls give equal tours.

    Turns show more than the search knows of, and leaning less: tours are made for several shares, and all are flown.
    Raises ValueError when none shows enough.
    """
    rng = np.random.default_rng([lot.seed, 7])
    ground = _ground(lot, setup, _SHARES[0])
    annealed = [_annealed(ground, places, rng, _SWEEPS, None) for places in _beginnings(ground)]
    first, second = sorted(annealed, key=length_of)[:2] if len(annealed) > 1 else (annealed[0], annealed[0])
    tours = [first, second]
    for share in _SHARES[1:]:
        begin = tours[-1] if len(tours) > 2 else first
        tours.append(_annealed(replace(ground, wanted=share), begin, rng, _AGAIN, _WARM_M))
    found = [tour for tour in (_flown(lot, setup, tour) for tour in tours) if tour is not None]
    for share in () if found else _SURE_SHARES:
        tours.append(_annealed(replace(ground, wanted=share), tours[-1], rng, _AGAIN, _WARM_M))
        flight = _flown(lot, setup, tours[-1])
        if flight is not None:
            return flight
    if not found:
        raise ValueError(f"seed {lot.seed}: no tour shows enough of the lot")
    return min(found, key=lambda tour: tour.way)


def _annealed(ground: Ground, places: Floats, rng: np.random.Generator, sweeps: int, hot: float | None) -> Floats:
    annealer = Annealer(ground, places.copy(), rng)
    annealer.run(sweeps, *(() if hot is None else (hot,)))
    return places if annealer.best is None else annealer.best


def _flown(lot: Lot, setup: Setup, places: Floats) -> Tour | None:
    pilot = TourPilot([(float(north), float(east)) for north, east in places[1:]])
    flight = fly(lot, setup, pilot, errors=False, to_the_end=False)
    if flight.way is None or flight.seconds is None:
        return None
    return Tour(places, flight.way, flight.seconds)


class TourCache:
    """Keeps tours in a file, by set-up, versions and seed: what this program computed before."""

    def __init__(self, path: Path | None) -> None:
        self._path = path
        self._known: dict[str, dict[str, Any]] = {}
        if path is not None and path.exists():
            self._known = json.loads(path.read_text(encoding="utf-8"))

    def tour(self, lot: Lot, setup: Setup) -> Tour:
        """Return the tour of a lot, from the file if it is there."""
        key = _key(lot, setup)
        if key not in self._known:
            self._keep(key, best_tour(lot, setup))
        kept = self._known[key]
        return Tour(np.array(kept["places"]), kept["way"], kept["seconds"])

    def keep(self, lot: Lot, setup: Setup, tour: Tour) -> None:
        """Take a tour that another process computed."""
        key = _key(lot, setup)
        if key not in self._known:
            self._keep(key, tour)

    def _keep(self, key: str, tour: Tour) -> None:
        places = np.round(tour.places, 2).tolist()
        self._known[key] = {"places": places, "way": round(tour.way, 2), "seconds": round(tour.seconds, 2)}
        if self._path is not None:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._path.write_text(json.dumps(self._known, indent=0), encoding="utf-8")


def _key(lot: Lot, setup: Setup) -> str:
    return f"{setup.name}.{setup.version}.{VERSION}.{lot.seed}"


def _ground(lot: Lot, setup: Setup, wanted: float) -> Ground:
    low, high = np.array(lot.shape.bounds[:2]), np.array(lot.shape.bounds[2:])
    window = Window.around(np.array([low, high]), FINE_M, 1.0)
    cells = np.argwhere(drawn(lot.shape, window) > 0)
    step = max(1, round(math.sqrt(len(cells) / _CELLS)))
    cells = cells[(cells[:, 0] % step == 0) & (cells[:, 1] % step == 0)]
    places = np.column_stack([-(window.row + cells[:, 0] + 0.5), window.column + cells[:, 1] + 0.5]) * FINE_M
    swath = setup.swath
    depth = swath.width if setup.is_disc else swath.depth
    area = (step * FINE_M) ** 2
    return Ground(places, area, np.array(lot.start), swath.width, depth, setup.is_disc, wanted)


def _beginnings(ground: Ground) -> list[Floats]:
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


def _to_and_fro(ground: Ground, heading: float, offset: float) -> Floats:
    c, s = math.cos(heading), math.sin(heading)
    turned = ground.cells @ np.array([[c, -s], [s, c]])  # along, across
    lines = _lines(turned, ground, offset)
    start = ground.start @ np.array([[c, -s], [s, c]])
    ordered = _ordered(lines, start)
    back = np.array([[c, s], [-s, c]])
    return np.vstack([ground.start, ordered @ back])


def _lines(turned: Floats, ground: Ground, offset: float) -> list[Floats]:
    """Return lines (2, 2) of (along, across) that together show all cells."""
    low, high = float(turned[:, 1].min()), float(turned[:, 1].max())
    count = max(1, math.ceil((high - low) / ground.width - 0.1 + offset / 2))
    pitch = max((high - low) / count, 1e-6)
    reach = ground.depth / 2 * (0.7 if ground.is_disc else 1.0)
    lines = []
    for number in range(count):
        begin = low + number * pitch
        band = np.sort(turned[(turned[:, 1] >= begin - 1e-9) & (turned[:, 1] <= begin + pitch + 1e-9), 0])
        if len(band) == 0:
            continue
        middle = begin + pitch / 2
        for part in np.split(band, np.flatnonzero(np.diff(band) > ground.depth) + 1):
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
    return [[*order[:at], way, *order[at:]] for at in range(len(order) + 1) for way in (line, line[::-1])]


def _length(order: list[Floats], start: NDArray[np.float64]) -> float:
    return length_of(np.vstack([start, *order]))
