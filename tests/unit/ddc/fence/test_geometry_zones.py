"""Exclusion zones: what is inside, what is refused, and how a drone in a zone is led out of it."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from hawk.ddc.fence.geometry import (
    FenceError,
    Ring,
    area,
    autopilot_fence,
    contains,
    extent,
    inside_point,
    is_about_same,
    last_inside,
    leads_inside,
    outside_by,
    path_is_inside,
    polygon_fence,
    sees_all,
    shape,
    zone_of,
)
from hawk.ddc.fence.plan import check_zones
from hawk.ddc.motion import Goal
from hawk.ddc.requests.service_interface import Limits, target_refusal
from hawk.model.plans import Fence, HeightParameters
from hawk.model.poses import MapPoint, MapPose

SQUARE = ((-100.0, -100.0), (100.0, -100.0), (100.0, 100.0), (-100.0, 100.0))


def box(south: float, west: float, north: float, east: float) -> Ring:
    return ((south, west), (north, west), (north, east), (south, east))


MIDDLE, SIDE = box(-20, -20, 20, 20), box(60, 40, 70, 95)
"""A zone in the middle, and one whose margin crosses ours of the fence, so that it makes a bay of the edge."""
ZONED = polygon_fence(SQUARE, 5, 100, 3, [MIDDLE, SIDE])
BAY = polygon_fence(SQUARE, 5, 100, 3, [SIDE])
PASSAGE = polygon_fence(SQUARE, 5, 100, 3, [box(-20, -60, 20, -6), box(-20, 6, 20, 15)])
"""Two zones that leave 2 m between their margins: too narrow to be led into, and the farther one is thin."""
coordinate = st.floats(-130, 130)
centimetres = coordinate.map(lambda value: round(value, 2))
places = st.builds(MapPoint, coordinate, coordinate)


def sampled(start: MapPoint, end: MapPoint) -> list[MapPoint]:
    shares = [k / 200 for k in range(201)]
    north, east = end.north - start.north, end.east - start.east
    return [MapPoint(start.north + north * share, start.east + east * share) for share in shares]


# -- what is inside ---------------------------------------------------------------------------------------------------


def test_our_zones_are_grown_by_the_margin_and_the_autopilots_are_as_drawn() -> None:
    assert ZONED.autopilot_zones == (MIDDLE, SIDE)
    assert sorted(ZONED.zones[0]) == [(-25, -25), (-25, 25), (25, -25), (25, 25)]
    assert ZONED.polygon == polygon_fence(SQUARE, 5, 100, 3).polygon


@pytest.mark.nightly
@given(st.lists(st.tuples(centimetres, centimetres), min_size=3, max_size=7), st.floats(0.5, 20.0))
def test_a_grown_zone_is_nowhere_nearer_than_the_margin(corners: list[tuple[float, float]], margin: float) -> None:
    zone = shapely.Polygon(corners)
    assume(zone.is_valid and zone.area > 1.0)
    around = ((-900.0, -900.0), (900.0, -900.0), (900.0, 900.0), (-900.0, 900.0))
    grown = shapely.Polygon(polygon_fence(around, margin, 100, 3, [tuple(corners)]).zones[0])
    assert grown.is_valid
    assert grown.exterior.distance(zone) >= margin - 1e-6
    assert grown.within(zone.convex_hull.buffer(3 * margin))


@given(places)
def test_inside_is_in_the_polygon_and_in_no_zone(place: MapPoint) -> None:
    point = shapely.Point(place.north, place.east)
    holds = shapely.Polygon(ZONED.polygon).intersects(point)
    forbidden = any(shapely.Polygon(zone).contains(point) for zone in ZONED.zones)
    assert contains(ZONED, place) is (holds and not forbidden)
    assert (outside_by(ZONED, place) == 0.0) is contains(ZONED, place)
    assert forbidden is (zone_of(ZONED, place) is not None)


def test_how_deep_in_a_zone_a_place_lies() -> None:
    assert outside_by(ZONED, MapPoint(0, 0)) == pytest.approx(25)
    assert outside_by(ZONED, MapPoint(24, 0)) == pytest.approx(1)
    assert [zone_of(ZONED, MapPoint(*place)) for place in ((0, 0), (65, 60), (-60, 0), (math.nan, 0))] == [
        1,
        2,
        None,
        None,
    ]


def test_extent_and_area_are_those_of_the_ground_that_is_left() -> None:
    fence = polygon_fence(SQUARE, 5, 100, 3, [MIDDLE])
    assert extent(fence) == (190, 190)
    assert area(fence) == pytest.approx(190**2 - 50**2)
    theirs = autopilot_fence(fence)
    assert extent(theirs) == (200, 200)
    assert area(theirs) == pytest.approx(200**2 - 40**2)


@given(places, places)
def test_a_path_is_inside_when_none_of_its_places_is_forbidden(start: MapPoint, end: MapPoint) -> None:
    along = [contains(ZONED, place) for place in sampled(start, end)]
    if path_is_inside(ZONED, start, end):
        assert all(along)
    if leads_inside(ZONED, start, end):
        assert along[-1]
        assert along == sorted(along), "outside first, then inside to the end"
    if not all(along):
        assert not path_is_inside(ZONED, start, end)


def test_a_straight_path_across_a_zone_is_not_inside() -> None:
    assert not path_is_inside(ZONED, MapPoint(-60, 0), MapPoint(60, 0))
    assert path_is_inside(ZONED, MapPoint(-60, 30), MapPoint(60, 30))
    assert not leads_inside(ZONED, MapPoint(-120, 0), MapPoint(60, 0))
    assert leads_inside(ZONED, MapPoint(0, 0), MapPoint(60, 0))
    assert last_inside(ZONED, MapPoint(-60, 0), MapPoint(60, 0)).north == pytest.approx(-25.5)


def test_from_nowhere_is_everything_seen_when_a_zone_lies_in_between() -> None:
    assert all(not sees_all(ZONED, MapPoint(*place)) for place in ((-60, 0), (60, 0), (90, 90), (0, -80)))
    assert not shape(BAY).interiors
    assert not sees_all(BAY, MapPoint(0, 0))
    assert not sees_all(BAY, MapPoint(90, 90))


@given(places, places)
def test_what_is_seen_whole_is_seen_everywhere(home: MapPoint, place: MapPoint) -> None:
    corner = polygon_fence(SQUARE, 5, 100, 3, [box(70, 70, 95, 95)])
    assume(contains(corner, place))
    if sees_all(corner, home):
        assert path_is_inside(corner, place, home)


def test_a_bay_in_a_corner_is_seen_whole_from_the_other_one() -> None:
    corner = polygon_fence(SQUARE, 5, 100, 3, [box(70, 70, 95, 95)])
    assert sees_all(corner, MapPoint(-50, -50))
    assert not sees_all(corner, MapPoint(80, -50))


# -- led out ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("fence", [ZONED, BAY, PASSAGE], ids=["zones", "bay", "passage"])
@given(place=places)
def test_the_path_from_outside_ends_inside_and_enters_once(fence: Fence, place: MapPoint) -> None:
    out = inside_point(fence, place)
    assert contains(fence, out)
    if not contains(fence, place):
        assert leads_inside(fence, place, out)
        assert place.distance(out) <= outside_by(fence, place) + 2 / math.cos(math.pi / 4) + 0.02 or fence is PASSAGE
    if fence is ZONED:
        assert shape(fence).boundary.distance(shapely.Point(out.north, out.east)) >= 2 - 1e-6


def test_out_of_a_zone_it_is_the_nearest_edge() -> None:
    out = inside_point(ZONED, MapPoint(10, 3))
    assert out.north == pytest.approx(27, abs=0.02)
    assert out.east == pytest.approx(3)
    assert inside_point(ZONED, MapPoint(-3, -10)).east == pytest.approx(-27, abs=0.02)


def test_out_of_a_zone_it_does_not_lead_through_the_next_one() -> None:
    """2 m inside is nearest beyond the thin zone; straight there the drone would fly over that zone."""
    place = MapPoint(0, -2)
    out = inside_point(PASSAGE, place)
    assert leads_inside(PASSAGE, place, out)
    assert -1 <= out.east <= 1


# -- the same fence ---------------------------------------------------------------------------------------------------


def test_a_fence_with_other_zones_is_another_one() -> None:
    near = tuple((north + 1, east) for north, east in MIDDLE)
    far = tuple((north + 4, east) for north, east in MIDDLE)
    plain = polygon_fence(SQUARE, 5, 100, 3)
    zoned = polygon_fence(SQUARE, 5, 100, 3, [MIDDLE])
    assert is_about_same(zoned, zoned, 3)
    assert is_about_same(zoned, polygon_fence(SQUARE, 5, 100, 3, [near]), 3)
    assert not is_about_same(zoned, polygon_fence(SQUARE, 5, 100, 3, [far]), 3)
    assert not is_about_same(zoned, plain, 3)
    assert not is_about_same(plain, zoned, 3)
    assert not is_about_same(zoned, ZONED, 3)


# -- fences that cannot be flown in -----------------------------------------------------------------------------------


@pytest.mark.fault("zones that cut the inside into pieces", "refused with the zone's number")
@pytest.mark.parametrize(
    ("zones", "words"),
    [
        ([box(-20, -95, 20, 95)], "Zone 1: with 5 m around it, it cuts 13300 m² off the inside"),
        ([box(60, 60, 70, 70), box(-20, -91, 20, 91)], "Zone 2: with 5 m around it, it cuts 12900 m² off"),
        ([box(-20, -60, 20, 0), box(-20, 8, 20, 92), box(-10, -92, 0, -68)], "Zone 3: with 5 m around it, it cuts"),
        ([box(-99, -99, 99, 99)], "Zone 1: with 5 m around it nothing is left"),
    ],
    ids=["across", "across with its margin", "three together", "everything"],
)
def test_zones_that_leave_no_whole_inside_are_refused(zones: list[Ring], words: str) -> None:
    with pytest.raises(FenceError) as caught:
        polygon_fence(SQUARE, 5, 100, 3, zones)
    assert str(caught.value).startswith(words)
    assert ": " in str(caught.value).partition(": ")[2], "a remedy"


def test_ground_that_zones_cut_off_is_forbidden() -> None:
    """A fence whose zones cut it, which no plan has: the smaller part is outside."""
    cut = replace(polygon_fence(SQUARE, 5, 100, 3), zones=(box(20, -100, 40, 100),))
    assert contains(cut, MapPoint(0, 0))
    assert not contains(cut, MapPoint(70, 0))
    nothing = replace(cut, zones=(box(-200, -200, 200, 200),))
    assert not contains(nothing, MapPoint(0, 0))


@pytest.mark.parametrize(
    ("zones", "words"),
    [
        ([box(80, 0, 120, 20)], "Zone 1: crosses the fence's edge: move its corners inside"),
        ([MIDDLE, box(180, 0, 190, 20)], "Zone 2: lies outside the fence: move its corners inside"),
        ([MIDDLE, box(0, 0, 40, 40)], "Zone 2: it crosses or holds zone 1: "),
        ([MIDDLE, box(-5, -5, 5, 5)], "Zone 2: it crosses or holds zone 1: "),
        ([box(-5, -5, 5, 5), MIDDLE], "Zone 2: it crosses or holds zone 1: "),
        ([((0, 0), (20, 20), (20, 0), (0, 20))], "Zone 1: the sides 1-2 and 3-4 cross: "),
        ([((0, 0), (20, 0), (20, 0.1), (20, 20))], "Zone 1: corners 2 and 3 lie at one place: "),
        ([box(0, 0, 0.6, 0.6)], "Zone 1: it holds 0.4 m², too little"),
    ],
)
def test_a_zone_that_cannot_be_meant_is_named_with_fault_and_remedy(zones: list[Ring], words: str) -> None:
    with pytest.raises(FenceError) as caught:
        check_zones(SQUARE, zones)
    assert str(caught.value).startswith(words)


def test_zones_may_touch_the_edge_and_each_other() -> None:
    check_zones(SQUARE, [box(80, -100, 100, -80), box(80, -80, 100, -60), MIDDLE])


@given(st.lists(st.tuples(coordinate, coordinate), min_size=3, max_size=6))
def test_a_zone_that_is_taken_leaves_one_whole_inside(corners: list[tuple[float, float]]) -> None:
    refusal = ""
    try:
        check_zones(SQUARE, [tuple(corners)])
        fence = polygon_fence(SQUARE, 5, 100, 3, [tuple(corners)])
    except FenceError as error:
        refusal = str(error)
    if refusal:
        assert ": " in refusal.partition(": ")[2], "field, fault and remedy"
        return
    assert shape(fence).is_valid
    assert shape(fence).distance(shapely.Polygon(corners)) >= 5 - 1e-6


# -- the gate ---------------------------------------------------------------------------------------------------------

HEIGHTS = HeightParameters()


@pytest.mark.fault(
    "a target in an exclusion zone, or straight across one",
    "refused by the gate, for tasks and for holding",
)
@pytest.mark.parametrize("holds", [False, True], ids=["a task", "holding"])
@pytest.mark.parametrize(
    ("at", "target", "words"),
    [
        ((-40, 0), (0, 0), "the target is in zone 1 or its margin"),
        ((-40, 0), (-24, 0), "the target is in zone 1"),
        ((-30, -30), (-30, 30), ""),
        ((-30, 0), (-10, 28), "the straight path to the target leaves the fence or crosses a zone"),
        ((0, -28), (20, 28), "the straight path to the target leaves the fence or crosses a zone"),
        ((-40, 0), (-26, 0), ""),
    ],
)
def test_no_target_in_a_zone_and_no_straight_path_across_one(
    at: tuple[float, float], target: tuple[float, float], words: str, holds: bool
) -> None:
    here = MapPose(float(at[0]), float(at[1]), 30.0, 0.0, 0.0, 0.0)
    goal = Goal(float(target[0]), float(target[1]), 30.0, 0.0)
    found = target_refusal(goal, here, Limits(ZONED, HEIGHTS, 20.0, holds))
    assert words in found
    assert bool(words) is bool(found)


def test_a_drone_in_a_zone_may_only_be_led_out_of_it() -> None:
    here, limits = MapPose(15.0, 0.0, 30.0, 0.0, 0.0, 0.0), Limits(ZONED, HEIGHTS, 5.0, holds=True)
    found = [target_refusal(Goal(north, 0.0, 30.0, 0.0), here, limits) for north in (10.0, 14.9, 15.1, 20.0, 27.0)]
    assert [bool(refusal) for refusal in found] == [True, True, False, False, False]
    task = replace(limits, holds=False)
    assert target_refusal(Goal(20.0, 0.0, 30.0, 0.0), here, task), "a task does not fly in a zone"


def test_every_order_of_two_places_around_a_zone_is_judged_alike() -> None:
    around = [MapPoint(*place) for place in ((-40, 0), (40, 0), (0, -40), (0, 40))]
    for one, other in itertools.permutations(around, 2):
        assert path_is_inside(ZONED, one, other) is path_is_inside(ZONED, other, one)


def test_a_zone_of_one_square_metre_may_be_meant() -> None:
    check_zones(SQUARE, [((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))])
    with pytest.raises(FenceError, match="too little to be meant"):
        check_zones(SQUARE, [((0.0, 0.0), (1.0, 0.0), (1.0, 0.9), (0.0, 0.9))])
