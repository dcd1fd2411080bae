from __future__ import annotations

import itertools

import cv2
import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from numpy.typing import NDArray

from hawk.algo.ground import COARSE_M, Window
from hawk.algo.path_plan.lot_ground import FenceGuard
from hawk.algo.path_plan.lot_route import NO_LOT_HERE, NO_LOT_THERE, NO_ROUTE, lot_route
from hawk.model.plans import Fence, Route
from hawk.model.poses import MapPoint
from tests.examples import examples
from tests.unit.algo.path_plan.lots import DrawnLot, fence_of, line_of, place_in

NEAR_M = 10.0

LOTS = arrays.arrays(
    np.bool_, st.tuples(st.integers(1, 14), st.integers(1, 14)), elements=st.booleans(), fill=st.just(True)
)
SHARE = st.floats(0.05, 0.95)


def route(lot: DrawnLot, start: tuple[float, float], goal: tuple[float, float], fence: Fence | None = None) -> Route:
    return lot_route(lot, FenceGuard(fence), start, goal, NEAR_M)


@pytest.mark.nightly
@settings(max_examples=examples(300))
@given(lot=LOTS, data=st.data(), scale=st.sampled_from([1, 3]), fenced=st.booleans())
def test_every_route_lies_over_lot_and_in_the_fence_and_none_means_that_there_is_none(
    lot: NDArray[np.bool_], data: st.DataObject, scale: int, fenced: bool
) -> None:
    known = DrawnLot(np.repeat(np.repeat(lot, scale, 0), scale, 1))
    rows, columns = known.lot.shape
    fence = None
    free = known.lot.astype(np.uint8)
    if fenced:
        top, bottom = sorted(data.draw(st.tuples(st.integers(0, rows), st.integers(0, rows))))
        assume(bottom - top >= 3)
        fence = fence_of(top, 0.0, bottom, columns)
        free &= FenceGuard(fence).mask(Window(0, 0, rows, columns, COARSE_M))
    cells = np.argwhere(free)
    assume(len(cells) > 0)
    ends = [cells[data.draw(st.integers(0, len(cells) - 1))] for _ in range(2)]
    start, goal = (place_in(r + data.draw(SHARE) - 0.5, c + data.draw(SHARE) - 0.5) for r, c in ends)
    found = route(known, start, goal, fence)
    _, labels = cv2.connectedComponents(free, connectivity=4)
    if labels[tuple(ends[0])] != labels[tuple(ends[1])]:
        assert found == Route(refused=NO_ROUTE)
        return
    assert found.refused == ""
    assert (found.points[0], found.points[-1]) == (MapPoint(*start), MapPoint(*goal))
    assert shapely.covers(known.area(), line_of(found.points))
    if fence is not None:
        assert all(
            FenceGuard(fence).contains_line((a.north, a.east), (b.north, b.east))
            for a, b in itertools.pairwise(found.points)
        )
    assert_cuts_lie_over(known, found)


def assert_cuts_lie_over(known: DrawnLot, found: Route) -> None:
    """The ground of a cut corner is lot too, and no two cuts share ground of one leg."""
    assert len(found.turns) == len(found.points)
    line = line_of(found.points)
    corners = itertools.accumulate((a.distance(b) for a, b in itertools.pairwise(found.points)), initial=0.0)
    for at, turn in zip(corners, found.turns, strict=True):
        if turn > 0:
            places = [line.interpolate((at + offset) / COARSE_M) for offset in (-turn, 0.0, turn)]
            assert shapely.covers(known.area(), shapely.Polygon(places))
    for (a, b), (one, other) in zip(itertools.pairwise(found.points), itertools.pairwise(found.turns), strict=True):
        assert one + other <= a.distance(b) + 1e-6


L_SHAPE = DrawnLot.of("##....", "##....", "##....", "######", "######", scale=8)


def test_an_l_shaped_lot_is_flown_around_its_corner() -> None:
    start, goal = place_in(4, 8), place_in(32, 40)
    found = route(L_SHAPE, start, goal)
    assert not shapely.covers(L_SHAPE.area(), shapely.LineString(line_of((MapPoint(*start), MapPoint(*goal)))))
    assert shapely.covers(L_SHAPE.area(), line_of(found.points))
    assert len(found.points) == 3
    assert found.turns[1] >= 4.0
    corner = found.points[1]
    assert found.length_m < 1.1 * (
        MapPoint(*start).distance(MapPoint(*place_in(24, 16))) + MapPoint(*goal).distance(MapPoint(*place_in(24, 16)))
    )
    assert MapPoint(*place_in(24, 16)).distance(corner) < 6.0


def test_where_there_is_room_it_keeps_a_cell_from_the_border() -> None:
    found = route(L_SHAPE, place_in(4, 8), place_in(32, 40))
    beside = L_SHAPE.area().buffer(-0.99)
    inner = shapely.intersection(line_of(found.points), beside)
    assert inner.length == pytest.approx(line_of(found.points).length, abs=0.1)


def test_an_island_is_flown_around() -> None:
    lot = DrawnLot.of("#####", "#####", "##.##", "#####", "#####", scale=6)
    found = route(lot, place_in(14, 4), place_in(14, 26))
    assert shapely.covers(lot.area(), line_of(found.points))
    assert len(found.points) > 2


def test_a_lane_one_cell_wide_is_used_when_there_is_no_other_route() -> None:
    lot = DrawnLot.of("####...####", "####...####", "###########", "####...####", "####...####")
    found = route(lot, place_in(0, 1), place_in(4, 9))
    assert shapely.covers(lot.area(), line_of(found.points))


def test_two_lots_that_touch_at_a_corner_are_not_joined() -> None:
    lot = DrawnLot.of("###...", "###...", "###...", "...###", "...###", "...###")
    assert route(lot, place_in(0, 0), place_in(5, 5)).refused == NO_ROUTE


@pytest.mark.slow
def test_a_detour_far_beyond_the_straight_line_is_found() -> None:
    lot = DrawnLot(np.ones((300, 40), np.bool_))
    lot.lot[:290, 20] = False
    found = route(lot, place_in(5, 2), place_in(5, 37))
    assert found.length_m > 2 * 280 * COARSE_M
    assert shapely.covers(lot.area(), line_of(found.points))


def test_the_shorter_detour_is_taken_though_the_other_lies_in_the_first_band() -> None:
    lot = DrawnLot(np.ones((140, 140), np.bool_))
    lot.lot[50, 1:118] = False  # open to the west, inside the band only after a long path
    found = route(lot, place_in(40, 110), place_in(60, 110))
    east = 2 * np.hypot(10, 8) * COARSE_M
    assert found.length_m < 1.3 * east


@pytest.mark.parametrize(
    ("start", "goal", "why"),
    [((4, 8), (4, 40), NO_LOT_THERE), ((-12, 8), (32, 40), NO_LOT_HERE), ((4, 8), (400, 400), NO_LOT_THERE)],
)
def test_places_off_the_lot_are_refused(start: tuple[int, int], goal: tuple[int, int], why: str) -> None:
    assert route(L_SHAPE, place_in(*start), place_in(*goal)).refused == why


def test_a_drone_just_beside_the_lot_goes_straight_in() -> None:
    found = route(L_SHAPE, place_in(-4, 8), place_in(20, 8))
    assert found.refused == ""
    outside = shapely.difference(line_of(found.points), L_SHAPE.area())
    assert outside.length <= 4.6


def test_a_route_across_the_fence_is_none() -> None:
    fence = fence_of(0, 0, 23, 48)
    assert route(L_SHAPE, place_in(4, 8), place_in(32, 40), fence).refused == NO_LOT_THERE
    assert route(L_SHAPE, place_in(4, 8), place_in(20, 8), fence).refused == ""


def test_an_unknown_map_has_no_route() -> None:
    empty = DrawnLot(np.zeros((4, 4), np.bool_))
    assert route(empty, place_in(0, 0), place_in(3, 3)).refused == NO_LOT_THERE


def test_the_cost_grows_with_the_route_and_not_with_the_map() -> None:
    asked = []
    for side in (60, 600):
        lot = DrawnLot(np.ones((side, side), np.bool_))
        middle = side // 2
        assert route(lot, place_in(middle, middle), place_in(middle + 10, middle + 20)).refused == ""
        asked.append(lot.asked)
    assert asked[0] == asked[1]


def test_a_route_of_no_length() -> None:
    found = route(L_SHAPE, place_in(4, 8), place_in(4, 8))
    assert found.refused == ""
    assert found.length_m == 0.0
