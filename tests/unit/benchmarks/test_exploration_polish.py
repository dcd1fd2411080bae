from __future__ import annotations

import numpy as np
import pytest

from benchmarks.exploration.polish import OracleTour, polished
from hawk.algo.ground import Floats
from hawk.algo.path_plan.tour import length_of

GOAL = np.array([30.0, 0.0])
DETOUR = np.array([[0.0, 0.0], [10.0, 9.0], [20.0, -7.0], [30.0, 3.0]])


def flown(places: Floats) -> OracleTour | None:
    """A tour that ends near the goal shows enough."""
    if np.hypot(*(places[-1] - GOAL)) > 4.0:
        return None
    return OracleTour(places, length_of(places), 0.0)


def test_a_tour_gets_shorter_and_still_shows_enough() -> None:
    first = flown(DETOUR)
    assert first is not None
    best = polished(first, DETOUR, flown, np.random.default_rng(1))
    assert best.distance_m < 0.85 * first.distance_m
    assert best.distance_m == pytest.approx(length_of(best.places))
    assert flown(best.places) is not None
    assert (best.places[0] == DETOUR[0]).all()


def test_what_nothing_betters_stays_as_it_is() -> None:
    first = OracleTour(DETOUR, 50.0, 20.0)
    assert polished(first, DETOUR, lambda _: None, np.random.default_rng(1)) is first


def test_equal_generators_find_equal_tours() -> None:
    first = flown(DETOUR)
    assert first is not None
    one, other = (polished(first, DETOUR, flown, np.random.default_rng(5)) for _ in range(2))
    assert np.array_equal(one.places, other.places)
