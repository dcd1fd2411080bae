from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchmarks.perception.eyes import Result
from benchmarks.perception.needed import Needed, figures, needed, run_of
from benchmarks.perception.places import Place, state_array
from hawk.model.lot_map import StallState
from hawk.survey.accuracy import Finding, FloatArray, LabelledPlace

LOT = np.array([[2.0, 2.0], [58.0, 2.0], [58.0, 28.0], [2.0, 28.0]])


def row(count: int, x: float = 5.0, y: float = 5.0) -> FloatArray:
    """Stalls side by side, 2.6 by 5.2 m, from their upper left corner."""
    box = np.array([[0, 0], [2.6, 0], [2.6, 5.2], [0, 5.2]])
    return np.array([box + np.array([x + 2.6 * k, y]) for k in range(count)])


class Fixed:
    def __init__(self, found: FloatArray) -> None:
        self.found = found

    def look(self, image: NDArray[np.uint8], metres_per_pixel: float, *, scale: float = 1.0) -> Result:
        states = state_array([StallState.FREE] * len(self.found))
        return Result(Finding(self.found, states), np.zeros(len(self.found)), np.zeros((300, 600), np.bool_), 0.1)


def count(found: FloatArray, labels: FloatArray) -> tuple[int, int, int]:
    states = state_array([StallState.FREE] * len(labels))
    place = Place("drawn", np.full((300, 600, 3), 90, np.uint8), 0.1, LabelledPlace(labels, states, (LOT,)))
    one = needed(Fixed(found), place)
    return one.rows, one.removals, one.moves


def test_what_was_found_as_it_is_needs_nothing() -> None:
    assert count(row(10), row(10)) == (0, 0, 0)


def test_a_missing_row_is_one_operation() -> None:
    labels = np.vstack([row(10), row(12, y=18.0)])
    assert count(row(10), labels) == (1, 0, 0)


def test_a_row_in_pieces_is_removed_and_added_as_a_whole() -> None:
    assert count(row(11)[[0, 1, 2, 4, 5, 7, 8, 10]], row(11)) == (1, 1, 0)
    assert count(row(11)[[0, 1, 2, 4, 5, 6, 7, 8, 9, 10]], row(11)) == (1, 0, 0)


def test_false_stalls_outside_the_lot_are_one_removal_a_run_and_unlabelled_ones_within_it_are_none() -> None:
    outside = row(3, x=30.0, y=-3.4)
    within = row(3, x=40.0, y=20.0)
    assert count(np.vstack([row(5), outside]), row(5)) == (0, 1, 0)
    assert count(np.vstack([row(5), within]), row(5)) == (0, 0, 0)


def test_a_run_that_lies_aside_is_one_move() -> None:
    assert count(np.vstack([row(5), row(6, y=19.8)]), np.vstack([row(5), row(6, y=17.0)])) == (0, 0, 1)


def test_stalls_apart_are_runs_of_their_own() -> None:
    assert len({*run_of(np.vstack([row(4), row(3, x=25.0)])).tolist()}) == 2
    assert len(run_of(np.zeros((0, 4, 2)))) == 0


def test_stalls_head_to_foot_along_a_street_are_one_run() -> None:
    box = np.array([[0.0, 0.0], [5.6, 0.0], [5.6, 2.1], [0.0, 2.1]])
    street = np.array([box + np.array([5.0 + 5.7 * k, 12.0]) for k in range(6)])
    assert count(street[:3], street) == (1, 0, 0)


def test_figures_pool_the_places() -> None:
    found = {f.key: f.value for f in figures("places", [Needed("a", 30, 1, 1, 0), Needed("b", 10, 0, 1, 1)])}
    assert found["operations_per_10_stalls"] == 1.0
    assert found["places_rows"] == 1.0
