from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.algo.frame import outcome
from hawk.algo.path_plan.footprint import Footprint, Singles
from hawk.algo.path_plan.known_tour import (
    MARGIN_M,
    KnownTour,
    boxes_of,
    corner_inside,
    corners_of,
    grown,
    known_tour,
    lot_tour,
    path_inside,
)
from hawk.algo.path_plan.lot_ground import FenceGuard
from hawk.algo.rows.fit import Rectangles
from hawk.model.known_lot import KnownLot, KnownStall
from hawk.model.plans import Fence, HeightParameters
from tests.examples import examples
from tests.unit.algo.synthetic import CAMERA

LEVEL = Footprint(48.0, 27.0, turned=20.0, spun=26.0)
HEIGHTS = HeightParameters(15.0, 35.0, 60.0)


def rows_of(rows: int, stalls: int, turn: float = 0.0, apart_m: float = 11.0) -> Rectangles:
    """Return rows of stalls about the origin, turned (radians)."""
    row, number = np.divmod(np.arange(rows * stalls), stalls)
    flat = np.column_stack([(row - (rows - 1) / 2) * apart_m, (number - (stalls - 1) / 2) * 2.6])
    c, s = math.cos(turn), math.sin(turn)
    count = len(flat)
    return Rectangles(flat @ np.array([[c, s], [-s, c]]), np.full(count, turn % math.pi), *np.full((2, count), 2.5))


def lots() -> st.SearchStrategy[Rectangles]:
    """Return lots of one to six rows in any direction."""
    return st.builds(rows_of, st.integers(1, 6), st.integers(1, 24), st.floats(0.0, math.pi), st.floats(5.5, 30.0))


def shown_whole(tour: KnownTour, boxes: Singles, foot: Footprint) -> list[bool]:
    """Return for each box whether one leg's pictures, or a turn, show it as a whole: by its own geometry."""
    places = [shapely.Point(place) for place in tour.places]
    shapes = [shapely.buffer(places[0], foot.spun, quad_segs=64), shapely.buffer(places[-1], foot.spun, quad_segs=64)]
    shapes += [shapely.buffer(place, foot.turned, quad_segs=64) for place in places[1:-1]]
    for one, other in pairwise(tour.places):
        ahead = (other - one) / max(float(np.hypot(*(other - one))), 1e-9)
        aside = np.array([-ahead[1], ahead[0]]) * foot.width / 2
        begin, end = one - ahead * foot.depth / 2, other + ahead * foot.depth / 2
        shapes.append(shapely.Polygon([begin - aside, begin + aside, end + aside, end - aside]))
    polygons = [shapely.Polygon(corners) for corners in corners_of(boxes)]
    return [any(shape.buffer(0.05).covers(polygon) for shape in shapes) for polygon in polygons]


@pytest.mark.nightly
@settings(max_examples=examples(8), deadline=None)
@given(lots(), st.floats(-60.0, 60.0), st.floats(-60.0, 60.0))
def test_every_stall_lies_as_a_whole_in_a_picture_of_the_tour(lot: Rectangles, north: float, east: float) -> None:
    tour = outcome(known_tour(boxes_of(lot), LEVEL, (north, east)))
    assert tour.missed == 0
    assert all(shown_whole(tour, boxes_of(lot), LEVEL))


@pytest.mark.slow
@settings(max_examples=3, deadline=None)
@given(lots())
def test_the_distance_is_the_sum_of_the_legs_and_equal_calls_give_equal_tours(lot: Rectangles) -> None:
    tour, same = (outcome(known_tour(boxes_of(lot), LEVEL, (5.0, -40.0))) for _ in range(2))
    assert tour.distance_m == sum(math.dist(a, b) for a, b in pairwise(tour.places.tolist()))
    assert np.array_equal(tour.places, same.places)


@pytest.mark.slow
def test_a_lot_that_one_turn_shows_is_not_flown_over() -> None:
    tour = outcome(known_tour(boxes_of(rows_of(2, 6)), LEVEL, (0.0, 0.0)))
    assert tour.distance_m < 1.0
    assert outcome(known_tour(boxes_of(rows_of(0, 0)), LEVEL, (3.0, 4.0))).places.tolist() == [[3.0, 4.0]]


def test_a_lot_of_four_strips_takes_little_more_than_their_area() -> None:
    lot = rows_of(16, 60)  # 176 m x 156 m: too large to be searched
    tour = outcome(known_tour(boxes_of(lot), LEVEL, (-88.0, -78.0)))
    assert tour.missed == 0
    assert tour.distance_m < 1.25 * (176.0 * 156.0 / LEVEL.width)


@pytest.mark.nightly
def test_stalls_beyond_the_fence_are_counted_as_missed() -> None:
    lot = Rectangles(np.array([[0.0, 0.0], [200.0, 0.0]]), np.zeros(2), np.full(2, 5.0), np.full(2, 2.5))
    tour = outcome(known_tour(boxes_of(lot), LEVEL, (0.0, 0.0), lambda places: places[:, 0] < 100.0))
    assert tour.missed == 1


def test_a_box_is_grown_on_every_side() -> None:
    ((north, east, *_), *_) = boxes = boxes_of(rows_of(1, 1))
    corners = corners_of(grown(boxes, MARGIN_M))[0] - (north, east)
    assert np.allclose(np.abs(corners), 1.25 + MARGIN_M, atol=1e-5)


def _known(lot: Rectangles) -> KnownLot:
    values = np.column_stack([lot.centres, lot.angle, lot.width, lot.length]).tolist()
    return KnownLot("a lot", tuple(KnownStall(str(k), *row) for k, row in enumerate(values)), ())


ZONE = ((-30.0, -4.0), (-30.0, 4.0), (120.0, 4.0), (120.0, -4.0))
RING = ((-100.0, -150.0), (-100.0, 150.0), (100.0, 150.0), (100.0, -150.0))
PARTED = Fence(RING, RING, 97.0, 100.0, zones=(ZONE,), autopilot_zones=(ZONE,))


@pytest.mark.nightly
def test_no_leg_crosses_a_zone_and_the_path_around_it_counts() -> None:
    lot = Rectangles(np.array([[60.0, -60.0], [60.0, 60.0]]), np.zeros(2), np.full(2, 5.0), np.full(2, 2.5))
    free, parted = (
        outcome(lot_tour(_known(lot), CAMERA, HEIGHTS, fence, (60.0, -90.0)))
        for fence in (Fence(RING, RING, 97.0, 100.0), PARTED)
    )
    guard = FenceGuard(PARTED)
    places = [(point.north, point.east) for point in parted.points]
    assert all(guard.contains_line(a, b) for a, b in pairwise(places))
    assert parted.distance_m > free.distance_m + 80.0
    assert parted.distance_m == sum(math.dist(a, b) for a, b in pairwise(places))


def test_a_path_without_end_leads_straight_and_has_no_corner() -> None:
    wall = ((-200.0, -4.0), (-200.0, 4.0), (200.0, 4.0), (200.0, -4.0))
    guard = FenceGuard(Fence(RING, RING, 97.0, 100.0, zones=(wall,)))
    assert corner_inside(guard, (0.0, -50.0), (0.0, 50.0)) is None
    assert path_inside(guard, (0.0, -50.0), (0.0, 50.0)) == [(0.0, 50.0)]
    assert corner_inside(guard, (0.0, -50.0), (0.0, -20.0)) == (0.0, -20.0)
