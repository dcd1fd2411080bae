from __future__ import annotations

import functools
import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
import shapely.affinity

from hawk.algo.path_plan.app import PathPlanApp
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.model.plans import Fence, LeftOut
from hawk.model.poses import MapPoint
from tests.unit.algo.path_plan.flight import LEVEL, Flight, KnownMap, fence_around, fly, lower_bound, random_lot

pytestmark = pytest.mark.flight
nightly = pytest.mark.nightly

SETTINGS = PathPlanSettings()
WORST_RATIO = 2.6  # of the least distance that any plan could need; the mean over 24 lots was 1.92
MEAN_RATIO = 2.2


SMALL = 0.6
"""Scale of the lot that is flown each time."""


@functools.cache
def lot_of(seed: int, scale: float = 1.0) -> tuple[shapely.Polygon, tuple[float, float]]:
    """Return a drawn lot, made smaller about the origin, and a start on it."""
    lot, (north, east) = random_lot(seed)
    return shapely.affinity.scale(lot, scale, scale, origin=(0, 0)), (scale * north, scale * east)


@functools.cache
def flown_over(seed: int, scale: float = 1.0) -> Flight:
    """Return the flight of a planner that never flew, over a drawn lot: several tests look at one flight."""
    lot, start = lot_of(seed, scale)
    return fly(lot, start, fence_around(lot, 10.0))


@pytest.fixture(scope="module")
def flown() -> Flight:
    return flown_over(1, SMALL)


@pytest.mark.parametrize(
    ("seed", "scale"), [(1, SMALL), *(pytest.param(seed, 1.0, marks=nightly) for seed in (1, 4, 7, 9))]
)
def test_a_lot_is_seen_whole_and_the_drone_stays_inside_the_fence(seed: int, scale: float) -> None:
    lot, _ = lot_of(seed, scale)
    fence, flight = fence_around(lot, 10.0), flown_over(seed, scale)
    inside = shapely.Polygon(fence.polygon)
    assert flight.done
    assert flight.coverage >= 0.98
    assert flight.distance_m <= WORST_RATIO * lower_bound(lot)
    assert all(inside.covers(shapely.Point(place)) for place in flight.places)
    for plan, place in zip(flight.plans, flight.places, strict=True):
        if plan.target is not None:
            assert inside.covers(shapely.LineString([place, (plan.target.north, plan.target.east)]))


@nightly
def test_over_some_lots_the_distance_is_near_the_least() -> None:
    ratios = [flown_over(seed).distance_m / lower_bound(random_lot(seed)[0]) for seed in (4, 7, 9, 11)]
    assert np.mean(ratios) <= MEAN_RATIO


@nightly
def test_a_drone_that_stays_level_though_it_was_to_lean_sees_it_all() -> None:
    lot, start = random_lot(4)
    flight = fly(lot, start, fence_around(lot, 10.0), PathPlanApp())
    assert flight.done
    assert flight.coverage >= 0.98
    assert flight.distance_m <= WORST_RATIO * lower_bound(lot)


@nightly
def test_the_drone_stays_over_the_lot_or_near_it() -> None:
    lot, start = random_lot(5)
    flight = fly(lot, start, fence_around(lot, 60.0))
    assert max(lot.distance(shapely.Point(place)) for place in flight.places) < 14.0


def test_a_target_is_kept_until_it_is_reached_or_shows_nothing_any_more(flown: Flight) -> None:
    """A nearer one may come before it as the lot shows; it is not to be forgotten."""
    given_up = 0
    for before, after, at in zip(flown.plans, flown.plans[1:], flown.places, strict=False):
        if before.target is None or after.target is None or before.target.distance(MapPoint(*at)) <= 5:
            continue
        given_up += min(before.target.distance(point) for point in after.route) > 12  # half a picture: it is another
    assert given_up <= 1  # of some 150 plans


def test_it_begins_with_a_turn_on_the_spot_that_shows_what_lies_about_the_drone(flown: Flight) -> None:
    begin = [
        plan for plan, place in zip(flown.plans, flown.places, strict=True) if math.dist(place, flown.places[0]) < 0.5
    ]
    assert len(begin) >= 4
    assert all(plan.target and plan.target.distance(MapPoint(*flown.places[0])) < 0.5 for plan in begin[:4])
    assert max(abs(plan.yaw or 0.0) for plan in begin) > math.radians(60)  # the drone's own was 0
    assert flown.plans[len(begin)].explore.seen > begin[0].explore.seen


def test_the_route_begins_at_the_target_and_shrinks(flown: Flight) -> None:
    plans = [p for p in flown.plans if p.target is not None]
    assert all(p.route[0] == p.target for p in plans)
    assert any(len(p.route) > 2 for p in plans)
    assert all(p.height == 35.0 for p in plans)
    assert all(0 <= p.explore.seen <= 1 for p in flown.plans)
    assert flown.plans[-1].explore.remaining_m == 0.0
    assert flown.plans[-1].explore.reason == "nothing is left to learn"
    assert flown.plans[-1].explore.seen > 0.95


def test_part_of_the_lot_beyond_the_fence_does_not_hold_it_up() -> None:
    lot = shapely.box(-30.0, -35.0, 30.0, 35.0)
    polygon = ((-35.0, -40.0), (35.0, -40.0), (35.0, -8.0), (-35.0, -8.0))
    flight = fly(lot, (0.0, -30.0), Fence(polygon, polygon, 60.0, 63.0), most_s=400)
    assert flight.done
    assert all(shapely.Polygon(polygon).covers(shapely.Point(place)) for place in flight.places)


def test_a_drone_outside_the_fence_is_led_inside() -> None:
    lot = shapely.box(-30.0, -50.0, 30.0, 50.0)
    fence = fence_around(lot, 5.0)
    flight = fly(lot, (0.0, -58.0), fence, most_s=8)
    target, inside = flight.plans[5].target, shapely.Polygon(fence.polygon)
    assert target is not None
    assert inside.covers(shapely.Point(target.north, target.east))
    assert not inside.covers(shapely.Point(flight.places[0]))
    assert inside.covers(shapely.Point(flight.places[-1]))


@pytest.mark.nightly
def test_a_second_exploration_of_a_known_lot_ends_at_once() -> None:
    lot, start = shapely.box(-12.0, -15.0, 12.0, 15.0), (-8.0, -10.0)
    app, known = PathPlanApp(LEVEL), KnownMap(lot, 100.0)
    first = fly(lot, start, fence_around(lot, 10.0), app, known=known)
    assert first.done
    again = fly(lot, start, fence_around(lot, 10.0), app, known=known)
    assert again.done
    assert again.coverage >= 0.98
    assert again.distance_m < 20.0


@nightly
def test_with_a_new_battery_it_takes_up_where_it_left_off() -> None:
    """A first flight is called home early; the next one begins at home, by another planner, over the kept map."""
    lot, start = shapely.box(-55.0, -60.0, 55.0, 60.0), (-50.0, -50.0)
    fence, known = fence_around(lot, 10.0), KnownMap(lot, 140.0)
    first = fly(lot, start, fence, most_s=45, known=known)
    assert not first.done
    assert 0.3 < first.coverage < 0.8
    again = fly(lot, start, fence, known=known)
    assert again.done
    assert again.coverage >= 0.98
    whole = fly(lot, start, fence)
    assert again.distance_m < whole.distance_m - 30  # though it first flies back to where it left off
    seen_at = [plan.explore.seen for plan in again.plans]
    assert min(seen_at) >= 0.3  # nothing of what was seen is forgotten


@pytest.mark.nightly
def test_the_same_flight_twice_is_equal(flown: Flight) -> None:
    lot, start = random_lot(1)
    again = fly(lot, start, fence_around(lot, 10.0), most_s=20.0).plans
    assert len(again) > 60
    assert again == flown.plans[: len(again)]


@nightly
def test_a_small_patch_of_lot_is_looked_around_before_it_is_done() -> None:
    """The start shows a corner that nothing visible joins to the lot behind it: an entrance, a strip of trees."""
    lot = shapely.union(shapely.box(-45.0, -30.0, -35.0, -14.0), shapely.box(-40.0, 12.0, 40.0, 60.0))
    flight = fly(lot, (-40.0, -20.0), fence_around(lot.envelope, 10.0))
    assert flight.done
    assert flight.coverage > 0.95


def half_known_lots() -> tuple[shapely.Geometry, KnownMap]:
    """Two lots with a lane between them; the first, and the begin of the lane, was seen."""
    parts = [shapely.box(-25, -14, 25, 14), shapely.box(24, -2.5, 71, 2.5), shapely.box(70, -14, 95, 14)]
    lots = shapely.union_all(parts)
    known = KnownMap(lots, 190.0)
    rows = known.window.rows
    for layer in (known.seen, known.well):
        layer[round(-known.window.row - 32.0 / known.window.cell_m) : rows] = 1.0
    return lots, known


@pytest.mark.nightly
def test_the_end_of_a_lane_is_looked_at_and_leads_to_the_other_lot() -> None:
    lots, known = half_known_lots()
    flight = fly(lots, (0.0, 0.0), fence_around(lots, 40.0), known=known)
    assert flight.done
    assert flight.coverage >= 0.98


def test_ground_that_is_not_worth_the_distance_is_left_out() -> None:
    lots, known = half_known_lots()
    hurried = PathPlanApp(replace(LEVEL, open_end_m2=0.0, beyond_worth=0.0))
    flight = fly(lots, (0.0, 0.0), fence_around(lots, 40.0), hurried, known=known)
    assert flight.done
    assert flight.coverage < 0.75


@pytest.mark.nightly
def test_looking_around_ends_where_there_is_nothing() -> None:
    lot = shapely.box(-8.0, -12.0, 8.0, 12.0)
    flight = fly(lot, (0.0, 0.0), fence_around(lot, 150.0))
    assert flight.done
    assert flight.distance_m < 200
    assert flight.coverage > 0.98


@nightly
def test_a_lot_that_goes_on_across_other_ground_is_seen_whole() -> None:
    """A drive, a footpath and a planted strip part it, 14 m; the fence is drawn about both parts."""
    lot = shapely.union(shapely.box(-25, -30, 25, 30), shapely.box(-25, 44, 25, 100))
    flight = fly(lot, (-20.0, -25.0), fence_around(lot.convex_hull, 10.0))
    assert flight.done
    assert flight.coverage >= 0.97
    assert flight.plans[-1].explore.left_out == LeftOut()


@nightly
def test_ground_beyond_the_border_waits_until_the_lot_was_seen() -> None:
    """Two arms, in a fence drawn about them: until all of it was seen the drone flies as without looks beyond."""
    arms = [shapely.box(-9, -32, 26, -16), shapely.box(-9, 18, 26, 32)]
    lot = shapely.union_all([shapely.box(-30, -32, -8, 32), *arms])
    start, fence = (-20.0, 0.0), fence_around(lot, 20.0)
    without = fly(lot, start, fence, PathPlanApp(replace(LEVEL, beyond_worth=0.0)))
    careful = fly(lot, start, fence, most_s=without.seconds)
    tour = len(without.places) - SETTINGS.quiet_plans - 1
    assert careful.places[:tour] == without.places[:tour]
    assert without.coverage >= 0.98
    assert not careful.done, "what lies between the arms and beside them is looked at after it"


@nightly
def test_a_wide_fence_does_not_make_the_drone_wander() -> None:
    """Nothing lies beyond the lot; 60 m of ground inside the fence are not looked at, and reported."""
    lot = shapely.box(-40, -50, 40, 50)
    fence, careless = fence_around(lot, 60.0), PathPlanApp(replace(LEVEL, beyond_worth=0.0))
    wide, without = fly(lot, (-30.0, -40.0), fence), fly(lot, (-30.0, -40.0), fence, careless)
    assert wide.done
    most = SETTINGS.beyond_path_m + (1 + SETTINGS.beyond_path_share) * without.distance_m
    assert wide.distance_m <= 1.1 * most, "by far less than what lies inside the fence would take"
    left = wide.plans[-1].explore.left_out
    assert left is not None
    assert left.beside_m2 > 500
    assert (left.outside_m2, left.hidden_m2, left.given_up_m2) == (0, 0, 0)
