"""The fence's geometry at its limits: each distance, area and word for drawn rings whose answer is known."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from hawk.ddc.fence.geometry import (
    FenceError,
    Ring,
    area,
    autopilot_fence,
    check_fence_ring,
    circle,
    contains,
    converted,
    crossing,
    extent,
    inside_point,
    is_about_same,
    last_inside,
    leads_inside,
    outside_by,
    path_is_inside,
    path_words,
    place_words,
    polygon_fence,
    recovery_words,
    ring_from_map,
    ring_to_map,
    sees_all,
    to_map,
    zone_of,
)
from hawk.model.poses import GlobalPose, MapPoint, MapPose

DATUM = GlobalPose(43.26, -79.92, 100.0)
ORIGIN = MapPoint(0.0, 0.0)


def box(south: float, west: float, north: float, east: float) -> Ring:
    return ((south, west), (north, west), (north, east), (south, east))


OUTER = box(-65, -65, 65, 65)
FENCE = polygon_fence(OUTER, 5, 100, 3)
"""Our limit is 60 m away on each side."""
ZONED = polygon_fence(OUTER, 5, 100, 3, [box(10, 10, 20, 20), box(-20, -20, -10, -10)])
"""Our zones reach 5 m farther: 5 to 25 m, and -25 to -5 m."""


def refusal(ring: Ring) -> str:
    try:
        check_fence_ring(ring)
    except FenceError as error:
        return str(error)
    return ""


class TestPlaces:
    def test_a_place_keeps_its_height_out_of_the_ground(self) -> None:
        place = to_map(GlobalPose(43.26, -79.92, 900.0), 43.261, -79.92)
        assert place.north == pytest.approx(111.12, abs=0.05)
        assert place.east == pytest.approx(0.0, abs=1e-6)

    def test_rings_are_changed_corner_by_corner_and_stay_apart(self) -> None:
        rings = (box(0, 0, 1, 1), box(5, 5, 6, 6)[:3])
        doubled = converted(rings, lambda ring: tuple((2 * n, 2 * e) for n, e in ring))
        assert doubled == (box(0, 0, 2, 2), box(10, 10, 12, 12)[:3])
        assert converted((), lambda ring: ring) == ()
        back = converted(converted(rings, lambda ring: ring_from_map(DATUM, ring)), lambda r: ring_to_map(DATUM, r))
        for one, other in zip(rings, back, strict=True):
            for here, there in zip(one, other, strict=True):
                assert there == pytest.approx(here, abs=1e-6)

    def test_a_circle_begins_north_and_goes_round_once(self) -> None:
        ring = circle(MapPoint(10.0, 20.0), 50.0)
        assert len(ring) == 48
        assert ring[0] == pytest.approx((60.0, 20.0))
        assert ring[12] == pytest.approx((10.0, 70.0))
        assert ring[24] == pytest.approx((-40.0, 20.0))
        assert ring[36] == pytest.approx((10.0, -30.0))


class TestOutline:
    def test_one_that_is_well(self) -> None:
        assert refusal(box(0, 0, 20, 20)) == ""
        assert refusal(box(0, 0, 4000, 100)) == ""
        assert refusal(box(0, 0, 100, 4000)) == ""

    @pytest.mark.parametrize(
        ("ring", "words"),
        [
            (box(0, 0, 20, 19.9), "Corners: the fence holds 398 m², too little to fly in: draw it wider."),
            (box(0, 0, 4001, 100), "Corners: the fence is 4001 m wide: draw it at most 4000 m wide."),
            (box(0, 0, 100, 4001), "Corners: the fence is 4001 m wide: draw it at most 4000 m wide."),
            (((0, 0), (0.4, 0), (40, 40), (0, 40)), "Corners: 1 and 2 lie at one place: remove one of them."),
            (((0, 0), (40, 0), (40, 40), (40, 40.4)), "Corners: 3 and 4 lie at one place: remove one of them."),
            (((0, 0), (40, 0), (40, 40), (0.4, 0)), "Corners: 4 and 1 lie at one place: remove one of them."),
            (
                ((0, 0), (40, 40), (40, 0), (0, 40)),
                "Corners: the sides 1-2 and 3-4 cross: move a corner so that no side crosses another.",
            ),
        ],
    )
    def test_the_first_fault_is_reported(self, ring: Ring, words: str) -> None:
        assert refusal(ring) == words

    def test_the_width_is_measured_wherever_the_drone_is(self) -> None:
        assert refusal(box(3000, 3000, 6000, 6000)) == ""

    def test_corners_half_a_metre_apart_are_two(self) -> None:
        assert refusal(((0, 0), (0.5, 0), (40, 0), (40, 40), (0, 40))) == ""

    def test_sides_that_touch_to_the_centimetre_cross(self) -> None:
        for gap, touches in ((0.004, True), (0.012, False)):
            ring = ((0, 0), (40, 0), (40, 40), (20, gap), (0, 40))
            assert bool(refusal(ring)) is touches
            turned = tuple((e, n) for n, e in ring)
            assert bool(refusal(turned)) is touches

    @pytest.mark.parametrize(
        ("ring", "words"),
        [
            (((0, 0), (40, 40), (40, 0), (0, 40)), "the sides 1-2 and 3-4 cross"),
            (((0, 40), (0, 0), (40, 40), (40, 0)), "the sides 2-3 and 4-1 cross"),
            (((0, 0), (40, 0), (40, 40), (20, -10), (0, 40)), "the sides 1-2 and 3-4 cross"),
            (((0, 0), (40, 0), (20, 0), (20, 30)), "the sides 1-2 and 3-4 cross"),
            (((-40, 20), (0, 0), (40, 40), (40, 0), (0, 40)), "the sides 2-3 and 4-5 cross"),
            (((0, 40), (-10, -10), (0, 0), (40, 40), (40, 0)), "the sides 3-4 and 5-1 cross"),
            (((0, 0), (40, 0), (20, 0)), "a side lies on its neighbour"),
        ],
    )
    def test_which_sides_cross(self, ring: Ring, words: str) -> None:
        assert crossing(ring) == words


class TestMargins:
    def test_ours_lies_inside_and_our_zones_reach_farther(self) -> None:
        assert sorted(FENCE.polygon) == [(-60, -60), (-60, 60), (60, -60), (60, 60)]
        assert (FENCE.autopilot_polygon, FENCE.autopilot_zones, FENCE.zones) == (OUTER, (), ())
        assert (FENCE.ceiling, FENCE.autopilot_ceiling) == (97, 100)
        assert extent(FENCE) == (120, 120)
        assert area(FENCE) == 14_400
        assert area(ZONED) == pytest.approx(14_400 - 800)
        assert extent(polygon_fence(box(0, 0, 50, 110), 5, 100, 3)) == (40, 100)
        assert sorted(ZONED.zones[0]) == [(5, 5), (5, 25), (25, 5), (25, 25)]

    def test_the_autopilots_own_limits(self) -> None:
        theirs = autopilot_fence(ZONED)
        assert (theirs.polygon, theirs.ceiling) == (OUTER, 100)
        assert theirs.zones == ZONED.autopilot_zones

    def test_a_sharp_corner_is_not_cut_off_the_inside_and_that_of_a_zone_is(self) -> None:
        inner = polygon_fence(((0, 0), (200, -50), (200, 50)), 5, 100, 3).polygon
        assert min(n for n, _ in inner) == pytest.approx(5 / math.sin(math.atan(0.25)), abs=0.01)
        needle = polygon_fence(box(-200, -200, 200, 200), 5, 100, 3, [((0, 0), (60, -4), (60, 4))])
        assert min(n for n, _ in needle.zones[0]) == pytest.approx(-10.0, abs=0.5)
        assert outside_by(needle, MapPoint(30, 0)) > 0

    def test_one_too_narrow_or_in_two_pieces(self) -> None:
        for ring in (box(0, 0, 10, 100), box(0, 0, 9, 100)):
            with pytest.raises(FenceError, match="nothing whole is left 5 m inside"):
                polygon_fence(ring, 5, 100, 3)

    @pytest.mark.parametrize(("sharpness", "reach", "cut"), [(4.5, 22.0, False), (5.5, 27.0, True)])
    def test_a_corner_that_points_inwards_keeps_up_to_five_margins(
        self, sharpness: float, reach: float, cut: bool
    ) -> None:
        """The tip of a notch; ``sharpness``: distance of the uncut corner of our limit from the tip, in margins."""
        half = 100 * math.tan(math.asin(1 / sharpness))
        notched = ((100, -100), (100, -half), (0, 0), (100, half), (100, 100), (-100, 100), (-100, -100))
        fence = polygon_fence(notched, 5, 100, 3)
        assert contains(fence, MapPoint(-reach, 0)) is cut
        assert not contains(fence, MapPoint(-4.9, 0))

    def test_two_rooms_with_a_passage_narrower_than_the_margins(self) -> None:
        rooms = ((0, 0), (60, 0), (60, 28), (100, 28), (100, 0), (160, 0), (160, 60), (100, 60), (100, 33), (60, 33))
        with pytest.raises(FenceError, match="too narrow"):
            polygon_fence((*rooms, (60, 60), (0, 60)), 5, 100, 3)

    def test_a_zone_that_cuts_off_more_than_a_sliver(self) -> None:
        with pytest.raises(FenceError, match=r"^Zone 2: with 5 m around it, it cuts 1200 m² off the inside"):
            polygon_fence(OUTER, 5, 100, 3, [box(0, 40, 1, 41), box(-65, -45, 65, -44)])
        with pytest.raises(FenceError, match=r"^Zone 1: with 5 m around it nothing is left to fly in"):
            polygon_fence(OUTER, 5, 100, 3, [box(-64, -64, 64, 64)])

    @pytest.mark.parametrize(("width", "passes"), [(0.99, True), (1.01, False)])
    def test_a_pocket_of_a_square_metre_is_forbidden_without_a_word(self, width: float, passes: bool) -> None:
        """The inside's south-west corner, ``width`` x 1 m of it, behind a zone that bends around it."""
        north, east = -60 + width + 5, -59 + 5
        hook = (
            (north, -64.0),
            (north + 3, -64.0),
            (north + 3, east + 3),
            (-64.0, east + 3),
            (-64.0, east),
            (north, east),
        )
        if passes:
            assert not contains(polygon_fence(OUTER, 5, 100, 3, [hook]), MapPoint(-59.9, -59.9))
        else:
            with pytest.raises(FenceError, match="it cuts 1 m² off"):
                polygon_fence(OUTER, 5, 100, 3, [hook])


class TestInside:
    @pytest.mark.parametrize(
        ("north", "east", "inside"),
        [
            (60, 0, True),
            (60.01, 0, False),
            (0, -60, True),
            (0, -60.01, False),
            (math.nan, 0, False),
            (0, math.inf, False),
        ],
    )
    def test_the_edge_belongs_to_it(self, north: float, east: float, inside: bool) -> None:
        assert contains(FENCE, MapPoint(north, east)) is inside

    def test_how_far_outside(self) -> None:
        assert outside_by(FENCE, MapPoint(60, 0)) == 0
        assert outside_by(FENCE, MapPoint(63, 64)) == 5
        assert outside_by(ZONED, MapPoint(15, 7)) == pytest.approx(2)

    def test_paths(self) -> None:
        inside, beyond = MapPoint(0, 50), MapPoint(0, 70)
        assert path_is_inside(FENCE, ORIGIN, inside)
        assert not path_is_inside(FENCE, ORIGIN, beyond)
        assert path_is_inside(FENCE, inside, inside)
        assert not path_is_inside(FENCE, beyond, beyond)
        for bad in (MapPoint(math.nan, 0), MapPoint(0, math.nan)):
            assert not path_is_inside(FENCE, bad, ORIGIN)
            assert not path_is_inside(FENCE, ORIGIN, bad)
        assert not path_is_inside(ZONED, ORIGIN, MapPoint(40, 40)), "through a zone"
        assert path_is_inside(ZONED, ORIGIN, MapPoint(40, -40))

    def test_a_path_back_enters_once(self) -> None:
        outside = MapPoint(0, 70)
        assert leads_inside(FENCE, outside, ORIGIN)
        assert leads_inside(FENCE, outside, MapPoint(0, 60)), "to the edge"
        assert not leads_inside(FENCE, outside, MapPoint(0, 61))
        assert not leads_inside(FENCE, ORIGIN, outside)
        assert not leads_inside(FENCE, MapPoint(math.nan, 0), ORIGIN)
        assert not leads_inside(ZONED, MapPoint(70, 70), ORIGIN), "it crosses a zone behind the edge"
        assert leads_inside(ZONED, MapPoint(70, 70), MapPoint(40, 40))
        assert leads_inside(ZONED, MapPoint(15, 15), MapPoint(15, 40)), "out of a zone"


class TestStops:
    def test_half_a_metre_before_the_edge(self) -> None:
        stop = last_inside(FENCE, ORIGIN, MapPoint(80, 0))
        assert (stop.north, stop.east) == pytest.approx((59.5, 0))
        stop = last_inside(FENCE, MapPoint(10, 20), MapPoint(10 + 60, 20 + 80))
        assert (stop.north, stop.east) == pytest.approx((10 + 29.7, 20 + 39.6))

    def test_a_stop_less_than_a_metre_on_counts_as_well(self) -> None:
        stop = last_inside(FENCE, MapPoint(59.4, 0), MapPoint(60.2, 0))
        assert (stop.north, stop.east) == pytest.approx((59.5, 0))

    def test_before_the_first_zone_on_the_path(self) -> None:
        stop = last_inside(ZONED, MapPoint(15, -40), MapPoint(15, 80))
        assert (stop.north, stop.east) == pytest.approx((15, 4.5))

    def test_nearer_than_half_a_metre_to_the_edge_it_stays(self) -> None:
        start = MapPoint(59.8, 0)
        assert last_inside(FENCE, start, MapPoint(80, 0)) == start
        assert last_inside(FENCE, ORIGIN, ORIGIN) == ORIGIN
        outside = MapPoint(70, 0)
        assert last_inside(FENCE, outside, MapPoint(80, 0)) == outside


class TestRecovery:
    def test_two_metres_inside(self) -> None:
        back = inside_point(FENCE, MapPoint(70, 10))
        assert (back.north, back.east) == pytest.approx((58, 10), abs=0.011)
        back = inside_point(FENCE, MapPoint(70, -80), 5.0)
        assert (back.north, back.east) == pytest.approx((55, -55), abs=0.026)
        assert back.north <= 55

    def test_a_place_that_deep_already_stays(self) -> None:
        for north in (58.0, 57.0, 0.0):
            assert inside_point(FENCE, MapPoint(north, 0)) == MapPoint(north, 0)
        back = inside_point(FENCE, MapPoint(59, 0))
        assert (back.north, back.east) == pytest.approx((58, 0), abs=0.011)

    def test_the_edge_about_a_corner_that_points_inwards_keeps_its_distance(self) -> None:
        bent = polygon_fence(((-65, -65), (65, -65), (65, 5), (-5, 5), (-5, 65), (-65, 65)), 5, 100, 3)
        for degrees in range(0, 95, 5):
            near = MapPoint(-10 - math.cos(math.radians(degrees)), -math.sin(math.radians(degrees)))
            back = inside_point(bent, near)
            assert 2.0 - 1e-9 <= math.dist((back.north, back.east), (-10, 0)) <= 2.003

    def test_without_zones_it_is_that_deep_even_behind_a_strip_of_the_fence(self) -> None:
        strip = ((0, 0), (60, 0), (60, 20), (1, 20), (1, 22), (50, 22), (50, 23), (0, 23))
        fence = replace(FENCE, polygon=strip)
        back = inside_point(fence, MapPoint(40, 24))
        assert (back.north, back.east) == pytest.approx((40, 18), abs=0.011)

    def test_one_too_narrow_for_the_depth_has_a_middle(self) -> None:
        narrow = polygon_fence(box(0, 0, 13, 100), 5, 100, 3)
        back = inside_point(narrow, MapPoint(30, 50))
        assert back.north == pytest.approx(6.5, abs=0.1)
        assert contains(narrow, back)

    @pytest.mark.parametrize(("gap", "deep"), [(4.2, 2.0), (3.0, 1.0), (1.5, 0.5), (0.8, 0.0)])
    def test_into_a_passage_between_two_zones_as_deep_as_it_is_wide(self, gap: float, deep: float) -> None:
        half = gap / 2 + 5
        zones = [box(-30, half, 30, half + 60), box(-30, -half - 4, 30, -half)]
        fence = polygon_fence(box(-100, -100, 100, 100), 5, 100, 3, zones)
        place = MapPoint(0.0, gap / 2 + 0.2)
        back = inside_point(fence, place)
        assert back.east == pytest.approx(gap / 2 - deep, abs=0.02)
        assert leads_inside(fence, place, back)


class TestSight:
    def test_a_simple_fence_is_seen_from_everywhere(self) -> None:
        assert sees_all(FENCE, ORIGIN)
        assert sees_all(FENCE, MapPoint(60, 60))
        assert not sees_all(FENCE, MapPoint(61, 0))

    def test_a_zone_hides_something_unless_it_is_a_bay_of_the_edge(self) -> None:
        assert not sees_all(ZONED, ORIGIN)
        bay = polygon_fence(OUTER, 5, 100, 3, [((65, -10), (65, 10), (58, 0))])
        assert sees_all(bay, ORIGIN)
        assert not sees_all(bay, MapPoint(59, -50)), "the bay hides the ground beside it"


class TestSameness:
    def test_within_the_tolerance(self) -> None:
        moved = polygon_fence(box(-65, -65, 65, 66), 5, 100, 3)
        assert is_about_same(FENCE, FENCE, 0.0)
        assert is_about_same(FENCE, moved, 1.0)
        assert not is_about_same(FENCE, moved, 0.99)
        higher = replace(FENCE, autopilot_ceiling=101.0)
        assert is_about_same(FENCE, higher, 1.0)
        assert not is_about_same(FENCE, higher, 0.99)
        assert not is_about_same(higher, FENCE, 0.99)

    def test_other_numbers_of_corners(self) -> None:
        more = replace(FENCE, autopilot_polygon=(*OUTER, (-65.0, 0.0)))
        assert not is_about_same(FENCE, more, 1000.0)
        assert not is_about_same(FENCE, ZONED, 1000.0)


class TestWords:
    def test_zones_are_numbered_from_one(self) -> None:
        assert [zone_of(ZONED, MapPoint(*at)) for at in ((15, 15), (6, 6), (-15, -15), (0, 0), (70, 0))] == [
            1,
            1,
            2,
            None,
            None,
        ]
        assert zone_of(ZONED, MapPoint(math.nan, 0)) is None

    def test_where_a_place_is(self) -> None:
        assert place_words(ZONED, MapPoint(-15, -15)) == "in zone 2 or its margin"
        assert place_words(ZONED, MapPoint(70, 0)) == "outside the fence"

    def test_where_a_drone_is_led_back_to(self) -> None:
        def words(north: float, east: float) -> str:
            return recovery_words(ZONED, MapPose(north, east, 30.0, 0.0, 0.0, 0.0))

        assert words(15, 15) == "In zone 1 or its margin: going out of it."
        outside = "Outside the fence: going back inside."
        assert words(70, 0) == outside
        assert recovery_words(None, MapPose(15, 15, 30.0, 0.0, 0.0, 0.0)) == outside
        assert recovery_words(ZONED, None) == outside

    def test_what_a_path_does(self) -> None:
        assert path_words(FENCE) == "leaves the fence"
        assert path_words(ZONED) == "leaves the fence or crosses a zone"
