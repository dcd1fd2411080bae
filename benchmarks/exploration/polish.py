"""Shortens a tour by flying it: a waypoint is moved or left out; a shorter flight that shows enough is kept."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.random import Generator

from hawk.algo.ground import Floats

_FLIGHTS: Final = 100
_STEPS_M: Final = (8.0, 0.7)
"""Distance by which waypoints are moved in the first and the last flight, metres, standard deviation."""
_DROPPED: Final = 0.15


@dataclass(frozen=True, slots=True)
class OracleTour:
    """``places`` (K, 2) as flown, the start first; distance (metres) and seconds until the lot was seen."""

    places: Floats
    distance_m: float
    seconds: float


def polished(
    best: OracleTour, places: Floats, flown: Callable[[Floats], OracleTour | None], rng: Generator
) -> OracleTour:
    """Return the shortest flight found. ``best`` is that of the waypoints ``places`` (K, 2), the start first;
    ``flown`` flies others, and returns None when they do not show enough.
    """
    for flight in range(_FLIGHTS):
        step = _STEPS_M[0] * (_STEPS_M[1] / _STEPS_M[0]) ** (flight / _FLIGHTS)
        changed = _changed(places, step, rng)
        tour = flown(changed)
        if tour is not None and tour.distance_m < best.distance_m:
            best, places = tour, changed
    return best


def _changed(places: Floats, step: float, rng: Generator) -> Floats:
    """Return the waypoints with one of them (not the start) moved, or left out."""
    index = int(rng.integers(1, len(places)))
    if len(places) > 2 and rng.random() < _DROPPED:
        return np.delete(places, index, axis=0)
    places = places.copy()
    places[index] += rng.normal(0.0, step, 2)
    return places
