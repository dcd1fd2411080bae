from __future__ import annotations

import numpy as np
import pytest
import shapely

from hawk.worlds.generate import SiteSize
from hawk.worlds.plan import PlannedStall, SitePlan
from hawk.worlds.scene.cars import LONG_KINDS, footprint_m
from training.long_vehicles import park_long_vehicle
from training.paved import plan_paved_site
from training.streets import plan_street_site

SIZE = SiteSize(width=(40, 60), depth=(30, 50), second=0.0)


def streets(count: int) -> list[SitePlan]:
    return [plan_street_site(np.random.default_rng(seed), (0.0, 0.0)) for seed in range(count)]


def paved(count: int) -> list[SitePlan]:
    return [plan_paved_site(np.random.default_rng(seed), (0.0, 0.0), SIZE) for seed in range(count)]


def area_of(stall: PlannedStall) -> shapely.Polygon:
    return shapely.Polygon(stall.corners)


@pytest.mark.slow
def test_streets_have_parallel_and_square_stalls_that_do_not_overlap() -> None:
    kinds: set[str] = set()
    for plan in streets(12):
        kinds |= {stall.kind for stall in plan.stalls}
        areas = [area_of(stall).buffer(-0.05) for stall in plan.stalls]
        pairs = shapely.STRtree(areas).query(areas, predicate="intersects")
        assert (pairs[0] == pairs[1]).all()
    assert {"parallel", "perpendicular"} <= kinds


@pytest.mark.slow
def test_taken_stalls_of_a_street_have_a_vehicle_and_free_ones_have_none() -> None:
    for plan in streets(8):
        places = [shapely.Point(one.x, one.y) for one in plan.vehicles]
        for stall in plan.stalls:
            assert stall.taken == any(area_of(stall).contains(place) for place in places)


@pytest.mark.slow
def test_a_street_has_houses_on_both_sides_and_none_over_its_stalls() -> None:
    for plan in streets(6):
        houses = [shapely.Polygon(building.polygon) for building in plan.buildings]
        away = [plan.axes.points(np.zeros((1, 2)))[0] @ plan.axes.v, *(h.centroid.coords[0] for h in houses)]
        sides = [np.sign((np.array(place) - plan.axes.origin) @ plan.axes.v) for place in away[1:]]
        assert {-1.0, 1.0} <= set(sides)
        assert not any(house.intersects(area_of(stall)) for house in houses for stall in plan.stalls)


@pytest.mark.slow
def test_some_lots_without_paint_have_no_mark_at_all_and_some_have_stones() -> None:
    plans = [plan for plan in paved(16) if plan.stalls]
    unmarked = [all(stall.paint == 0 for stall in plan.stalls) for plan in plans]
    assert 0 < sum(unmarked) < len(plans)
    for plan, is_unmarked in zip(plans, unmarked, strict=True):
        assert is_unmarked or any(stroke.colour == 0 for stroke in plan.strokes)


@pytest.mark.slow
def test_some_bays_are_the_aisles_stones_with_moss_between_them() -> None:
    mossy = 0
    for plan in paved(40):
        ground = np.array(plan.asphalt.colour)
        shares = [
            np.array(one.material.colour) / ground for one in plan.surfaces if one.material.kind == plan.asphalt.kind
        ]
        mossy += any((share < 0.97).all() and share[1] == share.max() for share in shares)
    assert 2 <= mossy < 20


@pytest.mark.slow
def test_stones_differ_less_from_the_ground_than_white_paint_does() -> None:
    apart = [abs(np.mean(plan.palette[0]) - np.mean(plan.asphalt.colour)) for plan in paved(20)]
    assert np.median(apart) < 60


@pytest.mark.slow
def test_a_long_vehicle_takes_every_stall_that_it_covers_and_no_car_stays_in_them() -> None:
    kinds: set[str] = set()
    for seed, plan in enumerate(paved(12)):
        park_long_vehicle(plan, np.random.default_rng(seed))
        vehicle = plan.vehicles[-1]
        if not plan.stalls or vehicle.kind not in LONG_KINDS:
            continue  # no run of stalls is long enough
        kinds.add(vehicle.kind)
        body = shapely.Polygon(footprint_m(vehicle))
        others = [shapely.Point(one.x, one.y) for one in plan.vehicles[:-1]]
        covered = [
            stall for stall in plan.stalls if area_of(stall).intersection(body).area > 0.35 * area_of(stall).area
        ]
        assert covered
        for stall in covered:
            assert stall.taken
            assert not any(area_of(stall).contains(place) for place in others)
    assert len(kinds) > 1


def test_a_plan_without_stalls_gets_no_long_vehicle() -> None:
    plan = paved(1)[0]
    plan.stalls.clear()
    before = len(plan.vehicles)
    park_long_vehicle(plan, np.random.default_rng(0))
    assert len(plan.vehicles) == before
