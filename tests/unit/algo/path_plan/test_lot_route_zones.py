"""Exploring and routes keep out of exclusion zones, and see the ground below them from the side."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
import shapely

from hawk.algo.ground import COARSE_M, Window
from hawk.algo.path_plan.field import with_bridges
from hawk.algo.path_plan.lot_ground import FenceGuard
from hawk.algo.path_plan.lot_route import NO_LOT_THERE, NO_ROUTE, RouteKeeper, lot_route
from hawk.model.plans import DesiredPose, Fence, Route
from tests.unit.algo.path_plan.flight import Flight, fence_around, fly
from tests.unit.algo.path_plan.lots import DrawnLot, fence_of, place_in

Ring = tuple[tuple[float, float], ...]
LOT = shapely.box(-45.0, -35.0, 45.0, 35.0)
NEAR_M = 10.0


def box(south: float, west: float, north: float, east: float) -> Ring:
    return ((south, west), (north, west), (north, east), (south, east))


def zoned(fence: Fence, *zones: Ring) -> Fence:
    return replace(fence, zones=zones, autopilot_zones=zones)


def ground_of(fence: Fence) -> shapely.Geometry:
    """Return the ground inside a fence."""
    zones = shapely.union_all([shapely.Polygon(zone) for zone in fence.zones])
    return shapely.Polygon(fence.polygon).difference(zones)


def keeps_out(flight: Flight, fence: Fence) -> None:
    """No place, target, or leg to a target, nor the path shown on from it, may touch a zone."""
    ground = ground_of(fence)
    assert all(ground.covers(shapely.Point(place)) for place in flight.places)
    for plan, place in zip(flight.plans, flight.places, strict=True):
        if plan.target is not None:
            assert ground.covers(shapely.LineString([place, (plan.target.north, plan.target.east)]))
            assert all(ground.covers(shapely.Point(point.north, point.east)) for point in plan.route)


@pytest.mark.flight
@pytest.mark.parametrize(
    "zones",
    [
        pytest.param([box(-12, -10, 12, 10)], id="a roof in the middle"),
        pytest.param([box(-25, -50, -12, 2), box(10, -4, 26, 50)], id="two that force a detour"),
    ],
)
@pytest.mark.nightly
def test_a_lot_with_zones_is_explored_and_no_leg_crosses_one(zones: list[Ring]) -> None:
    fence = zoned(fence_around(LOT, 15.0), *zones)
    flight = fly(LOT, (-38.0, -28.0), fence)
    assert flight.done
    assert flight.plans[-1].explore.reason == "nothing is left to learn"
    keeps_out(flight, fence)
    free = ground_of(fence).intersection(LOT)
    assert flight.coverage >= min(0.99, 1.02 * free.area / LOT.area), "and what is seen below them from their side"


@pytest.mark.flight
@pytest.mark.nightly
def test_two_parts_of_a_lot_are_explored_around_a_zone_between_them() -> None:
    lot = shapely.union(shapely.box(-55.0, -35.0, -20.0, 35.0), shapely.box(-4.0, -35.0, 30.0, 35.0))
    fence = zoned(fence_around(shapely.box(-55.0, -35.0, 30.0, 35.0), 15.0), box(-15, -28, -9, 50))
    flight = fly(lot, (-50.0, 20.0), fence)
    assert flight.done
    assert flight.coverage >= 0.97
    keeps_out(flight, fence)


# -- bridges ----------------------------------------------------------------------------------------------------------


def test_no_bridge_crosses_a_zone() -> None:
    window = Window(0, 0, 60, 80, COARSE_M)
    apart = np.zeros(window.shape, np.uint8)
    apart[10:50, 5:20] = apart[10:50, 40:60] = 1
    fence = fence_of(0, 0, 60, 80)
    wall = box(-60 * COARSE_M, 25 * COARSE_M, 0.0, 30 * COARSE_M)
    gap = box(-40 * COARSE_M, 25 * COARSE_M, 0.0, 30 * COARSE_M)
    fenced = [FenceGuard(zoned(fence, zone)).mask(window) for zone in (wall, gap)]
    closed, opened = (with_bridges(apart & mask, mask, 60.0) for mask in fenced)
    assert (closed == (apart & fenced[0])).all()
    assert (opened <= fenced[1]).all()
    rows, columns = np.nonzero(opened & ~apart)
    assert len(rows) > 0
    assert rows[(columns >= 25) & (columns < 30)].min() > 40, "below the zone, not across it"


# -- routes -----------------------------------------------------------------------------------------------------------

KNOWN = DrawnLot.of("#", scale=60)
FENCE = fence_of(0, 0, 60, 60)
WEST, EAST = place_in(30, 5), place_in(30, 55)
MIDDLE = box(-40 * COARSE_M, 20 * COARSE_M, -20 * COARSE_M, 40 * COARSE_M)


def route(fence: Fence, start: tuple[float, float] = WEST, goal: tuple[float, float] = EAST) -> Route:
    return lot_route(KNOWN, FenceGuard(fence), start, goal, NEAR_M)


def test_a_route_goes_around_a_zone() -> None:
    straight, around = route(FENCE), route(zoned(FENCE, MIDDLE))
    assert len(straight.points) == 2
    assert len(around.points) > 2
    ground = ground_of(zoned(FENCE, MIDDLE))
    for here, there in itertools.pairwise(around.points):
        assert ground.covers(shapely.LineString([(here.north, here.east), (there.north, there.east)]))


def test_into_a_zone_and_past_a_wall_of_zones_there_is_no_route() -> None:
    middle = place_in(30, 30)
    assert route(zoned(FENCE, MIDDLE), goal=middle).refused == NO_LOT_THERE
    walls = (box(-60 * COARSE_M, 28 * COARSE_M, -29 * COARSE_M, 32 * COARSE_M),
             box(-31 * COARSE_M, 28 * COARSE_M, 0.0, 32 * COARSE_M))  # fmt: skip
    assert route(zoned(FENCE, *walls)).refused == NO_ROUTE


def test_a_route_that_is_flown_is_given_up_for_one_around_a_zone_that_came_into_force() -> None:
    """Another station may arm: the fence of the arm place then comes into force in flight."""
    keeper, desired = RouteKeeper(NEAR_M), DesiredPose(1, *EAST)
    first = keeper.route(KNOWN, FenceGuard(FENCE), WEST, desired)
    kept = keeper.route(KNOWN, FenceGuard(FENCE), WEST, desired)
    other = keeper.route(KNOWN, FenceGuard(zoned(FENCE, MIDDLE)), WEST, desired)
    assert kept is first
    assert len(first.points) == 2
    assert len(other.points) > 2
