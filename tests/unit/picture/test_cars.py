from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from hawk.algo.rows.lot import NO_ROW, RowStalls
from hawk.model.lot_map import Counts, OccupancyMap, Stall, StallState
from hawk.picture.cars import LEAST, LOT_M, are_shown, suggest_lone_cars
from tests.unit.algo.rows.parking import LENGTH, WIDTH, ground_of

FREE, TAKEN, SUGGESTED = StallState.FREE, StallState.TAKEN, StallState.SUGGESTED


def _map(*rows: tuple[float, str]) -> OccupancyMap:
    """Return rows of stalls at places to the east, a letter each: f free, t taken."""
    stalls: dict[int, Stall] = {}
    for north, (east, letters) in enumerate(rows):
        for k, letter in enumerate(letters):
            number = len(stalls) + 1
            state = FREE if letter == "f" else TAKEN
            stalls[number] = Stall(
                number,
                40.0 * north,
                east + 2.6 * k,
                0.0,
                2.6,
                5.2,
                0.1 if state is FREE else 0.9,
                state,
                0.95,
                3,
                0.0,
                1,
            )
    states = [stall.state for stall in stalls.values()]
    return OccupancyMap(stalls=stalls, counts=Counts(states.count(FREE), states.count(TAKEN), 0, 1.0, 0))


def _states(found: OccupancyMap) -> list[StallState]:
    return [stall.state for _, stall in sorted(found.stalls.items())]


def test_a_few_cars_alone_are_suggestions() -> None:
    found = suggest_lone_cars(_map((0.0, "t" * (LEAST - 1))))
    assert _states(found) == [SUGGESTED] * (LEAST - 1)
    assert (found.counts.taken, found.counts.suggested, found.counts.free_variance) == (0, LEAST - 1, 0.0)


def test_a_row_of_cars_is_a_row_of_stalls() -> None:
    given = _map((0.0, "t" * LEAST))
    assert suggest_lone_cars(given) is given


def test_cars_beside_a_free_stall_stand_on_stalls() -> None:
    given = _map((0.0, "tft"))
    assert suggest_lone_cars(given) is given


def test_a_free_place_at_the_end_of_a_few_cars_is_what_any_cars_suggest() -> None:
    found = suggest_lone_cars(_map((0.0, "tttf")))
    assert _states(found) == [SUGGESTED] * 4
    assert (found.counts.free, found.counts.taken, found.counts.suggested) == (0, 0, 4)


def test_two_free_stalls_are_marked_ones() -> None:
    given = _map((0.0, "ttff"))
    assert suggest_lone_cars(given) is given


def test_each_group_is_judged_alone() -> None:
    found = suggest_lone_cars(_map((0.0, "ttfftt"), (0.0, "tt")))
    assert _states(found) == [TAKEN, TAKEN, FREE, FREE, TAKEN, TAKEN, SUGGESTED, SUGGESTED]
    assert found.counts.taken == 4


def test_an_empty_map_stays() -> None:
    empty = OccupancyMap()
    assert suggest_lone_cars(empty) is empty


def _shown(*rows: tuple[float, int, str]) -> list[bool]:
    """Return which stalls of rows stay: metres along the stalls, number, and a letter a stall: f free, t taken."""
    places = [(along, k * WIDTH) for along, _, letters in rows for k in range(len(letters))]
    numbers = [number for _, number, letters in rows for _ in letters]
    free = np.array([letter == "f" for _, _, letters in rows for letter in letters])
    return _shown_at(places, numbers, free)


def _shown_at(places: Sequence[tuple[float, float]], numbers: Sequence[int], free: NDArray[np.bool_]) -> list[bool]:
    centres, ones = np.array(places, float), np.ones(len(places))
    row = np.array(numbers, np.intp)
    stalls = RowStalls(centres, 0 * ones, WIDTH * ones, LENGTH * ones, ones, 0 * row, row, 0 * row)
    return [bool(one) for one in are_shown(stalls, free, ground_of(centres, 0.0, centres[~free]))]


@pytest.mark.parametrize("letters", ["t" * (LEAST - 1), "t"])
def test_cars_that_wait_side_by_side_are_on_no_stall(letters: str) -> None:
    assert not any(_shown((0.0, 0, letters)))
    assert not any(_shown((0.0, NO_ROW, letters)))


@pytest.mark.parametrize("letters", ["t" * LEAST, "tf", "f"])
def test_a_long_row_and_a_free_stall_show_themselves(letters: str) -> None:
    assert all(_shown((0.0, 0, letters)))


def test_a_car_in_the_lot_of_a_row_stays_and_one_beyond_it_goes() -> None:
    row = (0.0, 0, "t" * LEAST)
    assert all(_shown(row, (LOT_M - 1, NO_ROW, "t")))
    assert _shown(row, (LOT_M + 1, NO_ROW, "t")) == [True] * LEAST + [False]


def test_full_lanes_are_no_stalls_though_many_cars_stand_side_by_side() -> None:
    lanes = [((LENGTH + 1) * k, k, "t" * LEAST) for k in range(4)]
    assert not any(_shown(*lanes))
    assert not any(_shown(*lanes, ((LENGTH + 1) * 4, 4, "ttf")))


def test_rows_back_to_back_with_an_aisle_on_both_sides_stay() -> None:
    assert all(_shown((0.0, 0, "t" * LEAST), (LENGTH, 1, "t" * LEAST), (2 * LENGTH + 7, 2, "ttt")))
