"""The order of a round and its tours: due lots first, the shortest closed path, lengths inside a concave fence."""

from __future__ import annotations

import math
from itertools import pairwise, permutations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.algo.frame import outcome
from hawk.algo.path_plan.lot_ground import FenceGuard
from hawk.algo.path_plan.round_tour import START, RoundScene, best_order, paths_between, round_tour
from hawk.model.known_lot import KnownLot, KnownStall
from hawk.model.plans import Fence, HeightParameters
from tests.examples import examples
from tests.unit.algo.path_plan.flight import LEVEL
from tests.unit.algo.synthetic import CAMERA

HEIGHTS = HeightParameters(15.0, 35.0, 60.0)


def lot_at(name: str, north: float, east: float, rows: int = 2, stalls: int = 8) -> KnownLot:
    """Return a lot with its south-west corner at a place."""
    row, number = np.divmod(np.arange(rows * stalls), stalls)
    places = np.column_stack([north + row * 11.0, east + number * 2.6]).tolist()
    known = (KnownStall(f"{name} {k}", at[0], at[1], 0.0, 2.5, 5.0) for k, at in enumerate(places))
    return KnownLot(name, tuple(known), ())


places = st.lists(st.tuples(st.integers(-300, 300), st.integers(-300, 300)), min_size=1, max_size=5, unique=True)


@settings(max_examples=examples(60), deadline=None)
@given(places, st.data())
def test_no_order_with_the_first_lots_first_is_shorter(found: list[tuple[int, int]], data: st.DataObject) -> None:
    is_first = data.draw(st.lists(st.booleans(), min_size=len(found), max_size=len(found)))
    lengths = outcome(paths_between([shapely.Point(place) for place in found], FenceGuard(None), (0.0, 0.0)))
    order = best_order(lengths, is_first)

    def length(numbers: tuple[int, ...]) -> float:
        return sum(lengths[leg] for leg in pairwise((START, *numbers, START)))

    assert sorted(order) == list(range(len(found)))
    allowed = [
        each for each in permutations(range(len(found))) if sorted(each, key=lambda n: not is_first[n]) == list(each)
    ]
    assert tuple(order) in allowed
    assert length(tuple(order)) == pytest.approx(min(map(length, allowed)))


def test_without_a_lot_nothing_is_flown() -> None:
    assert best_order({}, []) == []


def test_a_lot_alone_is_a_round_of_one() -> None:
    (tour,) = outcome(round_tour([lot_at("one", 40.0, 40.0)], frozenset(), site(Fence(RING, RING, 97.0, 100.0))))
    assert tour.lot == "one"
    assert (tour.points[0].north, tour.points[0].east) == (0.0, 0.0)


RING = ((-20.0, -20.0), (-20.0, 260.0), (200.0, 260.0), (200.0, -20.0))
BENT = ((-20.0, -20.0), (-20.0, 260.0), (200.0, 260.0), (200.0, 170.0), (10.0, 170.0), (10.0, 80.0), (200.0, 80.0),
        (200.0, -20.0))  # fmt: skip
"""Two arms to the north: the path from one to the other leads through the south."""


def site(fence: Fence) -> RoundScene:
    return RoundScene((0.0, 0.0), CAMERA, HEIGHTS, fence, LEVEL)


@pytest.mark.nightly
def test_the_path_between_lots_stays_inside_a_concave_fence_and_each_tour_begins_where_the_last_one_ends() -> None:
    west, east = lot_at("west", 140.0, 20.0), lot_at("east", 140.0, 200.0)
    fence = Fence(BENT, BENT, 97.0, 100.0)
    tours = outcome(round_tour([east, west], frozenset(), site(fence)))
    assert [tour.lot for tour in tours] == ["west", "east"]
    assert [tour.missed for tour in tours] == [0, 0]
    assert tours[1].points[0] == tours[0].points[-1]
    guard = FenceGuard(fence)
    corners = [(point.north, point.east) for tour in tours for point in tour.points]
    assert all(guard.contains_line(*leg) for leg in pairwise(corners))
    assert tours[1].distance_m > 200.0  # 110 m in a straight line across the bay
    ((path, *_), *_) = (tours[1].points[1:],)
    assert not guard.contains_line(corners[len(tours[0].points) - 1], (140.0, 200.0))
    assert guard.contains(path.north, path.east)


@pytest.mark.nightly
def test_lots_that_come_first_are_flown_before_nearer_ones() -> None:
    near, far = lot_at("near", 20.0, 20.0), lot_at("far", 160.0, 200.0)
    fence = Fence(RING, RING, 97.0, 100.0)
    first = outcome(round_tour([near, far], frozenset({"far"}), site(fence)))
    assert [tour.lot for tour in first] == ["far", "near"]


@pytest.mark.nightly
def test_a_round_is_shorter_than_its_lots_one_by_one() -> None:
    lots = [lot_at("a", 160.0, 20.0), lot_at("b", 160.0, 110.0), lot_at("c", 160.0, 200.0)]
    fence = Fence(RING, RING, 97.0, 100.0)

    def flown(chosen: list[KnownLot]) -> float:
        tours = outcome(round_tour(chosen, frozenset(), site(fence)))
        last = tours[-1].points[-1]
        return sum(tour.distance_m for tour in tours) + math.hypot(last.north, last.east)

    assert flown(lots) < 0.75 * sum(flown([lot]) for lot in lots)
