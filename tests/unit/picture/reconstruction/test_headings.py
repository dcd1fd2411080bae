from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import pytest

from hawk.picture.reconstruction.features import Features
from hawk.picture.reconstruction.headings import Couple, Middles, correct_headings, neighbour_headings
from tests.unit.picture.flights import flight, found


@pytest.mark.nightly
def test_neighbours_show_how_a_photograph_was_turned() -> None:
    flown = flight(lanes=1, count=4, sigma=0.3, turned=frozenset({1, 2}))
    posed = [one.posed for one in flown.known]
    seen = neighbour_headings(posed, 0.5, found(flown).__getitem__).headings
    assert set(seen) == {0, 1, 2, 3}
    for number, heading in seen.items():
        assert math.remainder(heading - flown.true[number].attitude[2], math.tau) == pytest.approx(0.0, abs=0.15)
    assert set(correct_headings(posed, seen)) == {1, 2}


@pytest.mark.slow
def test_places_that_err_more_than_they_are_apart_show_no_heading() -> None:
    flown = flight(lanes=1, count=3, sigma=0.3)
    seen = neighbour_headings([one.posed for one in flown.known], 10.0, found(flown).__getitem__)
    assert (seen.headings, seen.heights, seen.height) == ({}, (), None)


@pytest.mark.slow
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

    first = neighbour_headings(posed, 0.5, found(flown).__getitem__, keep)
    assert [one for middles in kept.values() for one in middles if one is not None]
    assert (
        first == neighbour_headings(posed, 0.5, found(flown).__getitem__) == neighbour_headings(posed, 0.5, lost, keep)
    )


@pytest.mark.nightly
@pytest.mark.parametrize("said_m", [20.0, 30.0, 50.0])
def test_the_distances_of_places_show_the_height_whatever_the_files_say(said_m: float) -> None:
    flown = flight(lanes=2, count=3, sigma=0.3)
    posed = [replace(one.posed, height=said_m) for one in flown.known]
    assert neighbour_headings(posed, 0.5, found(flown).__getitem__).height == pytest.approx(30.0, rel=0.04)
