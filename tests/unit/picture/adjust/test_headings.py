from __future__ import annotations

import math

import pytest

from hawk.picture.adjust.headings import headings, turned
from tests.unit.picture.flights import flight, found


def test_neighbours_show_how_a_photograph_was_turned() -> None:
    flown = flight(lanes=1, count=4, sigma=0.3, turned=frozenset({1, 2}))
    posed = [one.posed for one in flown.known]
    seen = headings(posed, 0.5, found(flown).__getitem__)
    assert set(seen) == {0, 1, 2, 3}
    for number, heading in seen.items():
        assert math.remainder(heading - flown.true[number].attitude[2], math.tau) == pytest.approx(0.0, abs=0.15)
    assert set(turned(posed, seen)) == {1, 2}


def test_places_that_err_more_than_they_are_apart_show_no_heading() -> None:
    flown = flight(lanes=1, count=3, sigma=0.3)
    assert headings([one.posed for one in flown.known], 10.0, found(flown).__getitem__) == {}
