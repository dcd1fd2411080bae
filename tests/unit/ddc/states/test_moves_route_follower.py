from __future__ import annotations

import math
from itertools import pairwise

import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.ddc.motion import Carrot, Goal, RouteFollower
from hawk.model.plans import Route
from hawk.model.poses import MapPoint, MapPose

ARRIVAL_M = 1.5
SPEED = 4.0
TICK_S = 0.05
ACCELERATION = 2.5  # ArduCopter's WPNAV_ACCEL


def route(*points: tuple[float, float], turns: tuple[float, ...] | None = None) -> Route:
    return Route(tuple(MapPoint(*p) for p in points), turns or (0.0,) * len(points))


def fly(path: Route, most_s: float = 300.0) -> tuple[list[MapPoint], list[float]]:
    """Fly a point mass that heads for the carrot as a position controller does; return places and speeds."""
    follower, carrot = RouteFollower(path, ARRIVAL_M), Carrot(SPEED)
    place, velocity = complex(path.points[0].north, path.points[0].east), 0j
    places, speeds = [path.points[0]], [0.0]
    for tick in range(round(most_s / TICK_S)):
        here = MapPoint(place.real, place.imag)
        if here.distance(path.points[-1]) < 0.3 and follower.heading_for == path.points[-1]:
            return places, speeds
        aim = follower.aim(here)
        pose = MapPose(here.north, here.east, 30.0, 0.0, 0.0, 0.0)
        target = carrot.step(Goal(aim.north, aim.east, 30.0, 0.0), pose, tick * TICK_S, 15.0, 60.0)
        to = complex(target.north, target.east) - place
        wanted = to / max(abs(to), 1e-9) * min(SPEED, math.sqrt(2 * ACCELERATION * abs(to)), 1.2 * abs(to))
        change = wanted - velocity
        velocity += change * min(1.0, 2 * ACCELERATION * TICK_S / max(abs(change), 1e-9))
        place += velocity * TICK_S
        places.append(MapPoint(place.real, place.imag))
        speeds.append(abs(velocity))
    raise AssertionError("never arrived")


def free_ground(path: Route, beside: float) -> shapely.Geometry:
    """The ground that the planner found free: the legs with a cell beside them, and the corners that may be cut."""
    line = shapely.LineString([(p.north, p.east) for p in path.points])
    parts, run = [line.buffer(beside)], 0.0
    for i, (a, b) in enumerate(pairwise(path.points)):
        run += a.distance(b)
        cut = path.turns[i + 1]
        if cut > 0:
            parts.append(shapely.Polygon([line.interpolate(run + d) for d in (-cut, 0, cut)]).buffer(beside))
    return shapely.union_all(parts)


@pytest.mark.nightly
@settings(max_examples=40)
@given(
    legs=st.lists(st.tuples(st.floats(17.0, 60.0), st.floats(-2.4, 2.4)), min_size=2, max_size=5),
    cuts=st.lists(st.sampled_from([0.0, 2.5, 4.0, 8.0]), min_size=4, max_size=4),
)
def test_the_flown_path_stays_on_the_legs_and_in_the_corners_that_may_be_cut(
    legs: list[tuple[float, float]], cuts: list[float]
) -> None:
    points, heading, at = [(0.0, 0.0)], 0.0, 0j
    for length, turn in legs:
        heading += turn
        at += length * complex(math.cos(heading), math.sin(heading))
        points.append((at.real, at.imag))
    path = route(*points, turns=(0.0, *cuts[: len(legs) - 1], 0.0))
    places, _ = fly(path)
    flown = shapely.LineString([(p.north, p.east) for p in places])
    assert shapely.covers(free_ground(path, 1.6), flown)


def test_a_corner_that_may_be_cut_is_flown_without_a_stop() -> None:
    path = route((0, 0), (40, 0), (40, 40), turns=(0.0, 8.0, 0.0))
    _, speeds = fly(path)
    assert min(speeds[60:-100]) > 0.5 * SPEED


def test_at_any_other_corner_it_all_but_stops_first() -> None:
    path = route((0, 0), (40, 0), (40, 40))
    places, speeds = fly(path)
    nearest = min(range(len(places)), key=lambda i: places[i].distance(path.points[1]))
    assert min(speeds[nearest - 20 : nearest + 40]) < 0.45 * SPEED
    assert max(p.north for p in places) < 41.6


def test_a_drone_that_leaves_a_corner_aside_is_not_led_past_what_was_looked_at() -> None:
    follower = RouteFollower(route((0, 0), (40, 0), (40, 40), turns=(0.0, 8.0, 0.0)), ARRIVAL_M)
    assert follower.aim(MapPoint(30, 0)) == MapPoint(40, 0)
    assert follower.aim(MapPoint(33, 0)) == MapPoint(40, 8)
    assert follower.aim(MapPoint(38, 4)) == MapPoint(40, 8)
    assert follower.aim(MapPoint(39, 7)) == MapPoint(40, 40)
    assert follower.heading_for == MapPoint(40, 40)
    assert follower.left(MapPoint(39, 7)) == (MapPoint(39, 7), MapPoint(40, 40))


def test_a_leg_of_no_length_behind_a_corner_that_may_be_cut_leads_to_its_end() -> None:
    follower = RouteFollower(route((0, 0), (40, 0), (40, 0), turns=(0.0, 8.0, 0.0)), ARRIVAL_M)
    assert follower.aim(MapPoint(35, 3)) == MapPoint(40, 0)


def test_a_route_of_no_length() -> None:
    assert RouteFollower(route((1, 2), (1, 2)), ARRIVAL_M).aim(MapPoint(1, 2)) == MapPoint(1, 2)


@pytest.mark.parametrize("points", [(), ((1.0, 2.0),)])
def test_a_route_that_leads_nowhere_is_an_error(points: tuple[tuple[float, float], ...]) -> None:
    with pytest.raises(ValueError, match="two points"):
        RouteFollower(route(*points), ARRIVAL_M)


def test_a_drone_beside_its_leg_is_led_to_the_end_of_it_where_no_corner_was_cut() -> None:
    follower = RouteFollower(route((0, 0), (40, 0), (40, 40), turns=(0.0, 0.0, 0.0)), ARRIVAL_M)
    assert follower.aim(MapPoint(38.5, 0)) == MapPoint(40, 40), "it has arrived at the corner"
    assert follower.aim(MapPoint(36, 3)) == MapPoint(40, 40)
    assert follower.heading_for == MapPoint(40, 40)


def test_a_drone_is_on_its_leg_within_a_metre() -> None:
    follower = RouteFollower(route((0, 0), (30, 40), (-10, 70), turns=(0.0, 8.0, 0.0)), ARRIVAL_M)
    follower.aim(MapPoint(30, 40))
    leg = (-0.8, 0.6)
    aside = (0.6, 0.8)
    for off, on in ((0.9, True), (1.1, False), (-0.9, True), (-1.1, False)):
        place = MapPoint(30 + 5 * leg[0] + off * aside[0], 40 + 5 * leg[1] + off * aside[1])
        aim = follower.aim(place)
        expected = MapPoint(-10, 70) if on else MapPoint(30 + 8 * leg[0], 40 + 8 * leg[1])
        assert (aim.north, aim.east) == pytest.approx((expected.north, expected.east)), off
    short = RouteFollower(route((0, 0), (40, 0), (40, 4), turns=(0.0, 8.0, 0.0)), ARRIVAL_M)
    assert short.aim(MapPoint(35, 0)) == MapPoint(40, 4), "the cut is longer than the leg"
