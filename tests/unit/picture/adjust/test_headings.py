from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import pytest

from hawk.picture.adjust.features import Features
from hawk.picture.adjust.headings import Couple, Middles, headings, turned
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


def test_middles_that_are_kept_need_no_features_and_give_the_same_headings() -> None:
    flown = flight(lanes=1, count=4, sigma=0.3, turned=frozenset({1, 2}))
    posed, kept = [one.posed for one in flown.known], dict[tuple[tuple[int, int], ...], Middles]()

    def keep(couples: Sequence[Couple], make: Callable[[], Middles]) -> Middles:
        numbers = tuple(one.numbers for one in couples)
        assert [(one.first, one.second) for one in couples] == [(posed[a], posed[b]) for a, b in numbers]
        if numbers not in kept:
            kept[numbers] = make()
        return kept[numbers]

    def lost(number: int) -> Features:
        raise AssertionError(number)

    first = headings(posed, 0.5, found(flown).__getitem__, keep)
    assert [one for middles in kept.values() for one in middles if one is not None]
    assert first == headings(posed, 0.5, found(flown).__getitem__) == headings(posed, 0.5, lost, keep)
