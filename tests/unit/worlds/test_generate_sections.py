from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.worlds.generate import SiteSize, plan_lot_site
from hawk.worlds.layout import asphalt_details, plan_section
from hawk.worlds.plan import SitePlan
from hawk.worlds.style import LotStyle, sample_style
from tests.unit.worlds.builders import EAST, areas_of, generator, largest_overlap, plain_plan, plain_style
from training.sites import plan_any_lot_site, plan_bare_site, plan_plain_site

SEEDS = st.integers(0, 10_000)
SIZE = SiteSize((40, 60), (30, 40), second=0.0)


def section(style: LotStyle, seed: int, width: float, depth: float) -> SitePlan:
    plan = plain_plan()
    assert plan_section(plan, generator(seed), EAST, width, depth, style) == len(plan.stalls)
    return plan


def aisles(plan: SitePlan, depth: float) -> list[float]:
    """Return the widths of the free strips (v) between the rows, in the middle of a section."""
    rows = shapely.union_all([shapely.box(0, a.bounds[1], 1, a.bounds[3]) for a in areas_of(plan.stalls)])
    free = shapely.box(0, 0, 1, depth).difference(rows.buffer(1e-6))
    strips = free.geoms if hasattr(free, "geoms") else [free]
    return [strip.bounds[3] - strip.bounds[1] for strip in strips if strip.bounds[3] - strip.bounds[1] > 0.01]


@pytest.mark.slow
@settings(max_examples=30)
@given(SEEDS, st.booleans(), st.floats(16, 90), st.floats(12, 70))
def test_stalls_of_a_section_do_not_overlap_and_stay_inside(seed: int, calm: bool, width: float, depth: float) -> None:
    plan = section(sample_style(generator(seed), calm=calm), seed, width, depth)
    assert largest_overlap(areas_of(plan.stalls)) < 1e-3
    inside = shapely.box(0, 0, width, depth).buffer(0.05)
    assert all(inside.contains(area) for area in areas_of(plan.stalls))


@pytest.mark.slow
@settings(max_examples=25)
@given(SEEDS, st.floats(17, 80))
def test_every_aisle_is_at_least_as_wide_as_the_style_s(seed: int, depth: float) -> None:
    style = plain_style(aisle=6.5)
    plan = section(style, seed, 40.0, depth)
    widths = aisles(plan, depth)
    assert widths
    assert all(width >= 6.5 - 0.01 for width in widths if width > 3.1), "narrower strips are medians"


@pytest.mark.parametrize("seed", range(6))
def test_every_stall_opens_onto_an_aisle(seed: int) -> None:
    plan = section(plain_style(), seed, 50.0, 45.0)
    taken = shapely.union_all(areas_of(plan.stalls)).buffer(-0.01)
    for stall in (stall for stall in plan.stalls if stall.kind != "parallel"):
        front, back = stall.corners[:2].mean(axis=0), stall.corners[2:].mean(axis=0)
        outside = front + (front - back) / np.linalg.norm(front - back) * 2.5
        assert not taken.contains(shapely.Point(outside)), "a car can drive out"


@pytest.mark.slow
def test_medians_are_planted_islands_between_double_rows() -> None:
    islands, trees = 0, 0
    for seed in range(8):
        plan = section(plain_style(medians=1.0, trees=1.0), seed, 60.0, 60.0)
        islands += len(plan.islands)
        trees += len(plan.trees)
        stalls = shapely.union_all(areas_of(plan.stalls)).buffer(-0.01)
        assert not any(stalls.intersects(shapely.Polygon(island.polygon)) for island in plan.islands)
    assert islands > 6
    assert trees > 20


def test_without_medians_the_rows_of_a_double_row_touch() -> None:
    plan = section(plain_style(), 3, 60.0, 40.0)
    assert plan.islands == []
    heads = sorted({round(float(area.bounds[k]), 3) for area in areas_of(plan.stalls) for k in (1, 3)})
    assert min(np.diff(heads)) > 1.0, "rows share their heads' line or are an aisle apart"


@pytest.mark.slow
def test_rows_across_close_the_ends_of_wide_sections() -> None:
    sideways = 0
    for seed in range(12):
        plan = section(plain_style(side_rows=1.0), seed, 70.0, 40.0)
        turned = [stall for stall in plan.stalls if abs(stall.corners[1, 0] - stall.corners[0, 0]) < 0.01]
        sideways += bool(turned)
        assert largest_overlap(areas_of(plan.stalls)) < 1e-3
    assert sideways == 12
    narrow = section(plain_style(side_rows=1.0), 1, 30.0, 40.0)
    assert all(abs(stall.corners[1, 0] - stall.corners[0, 0]) > 0.01 for stall in narrow.stalls)


@pytest.mark.parametrize("width", [3.0, 4.9])
def test_a_section_narrower_than_two_stalls_is_left_empty(width: float) -> None:
    assert section(plain_style(), 1, width, 20.0).stalls == []


def test_moving_cars_and_arrows_are_in_the_aisles() -> None:
    cars, strokes = 0, 0
    for seed in range(10):
        plan = section(plain_style(occupancy=0.0), seed, 80.0, 30.0)
        stalls = shapely.union_all(areas_of(plan.stalls)).buffer(-0.3)
        moving = plan.vehicles
        cars += len(moving)
        strokes += sum(stroke.colour == 3 for stroke in plan.strokes)
        assert sum(stalls.contains(shapely.Point(car.x, car.y)) for car in moving) <= sum(s.taken for s in plan.stalls)
    assert cars > 3
    assert strokes > 10


@settings(max_examples=20)
@given(SEEDS, st.floats(10, 100), st.floats(10, 100))
def test_details_of_the_asphalt_stay_on_it(seed: int, width: float, depth: float) -> None:
    plan = plain_plan()
    asphalt_details(plan, generator(seed), EAST, width, depth)
    for gain in plan.gains:
        assert 0.5 < gain.gain < 1.2
        if gain.width is None:
            assert gain.points.min() >= 0
            assert (gain.points <= np.array([width, depth]) + 1e-9).all()


def test_a_larger_lot_has_more_cracks_and_patches() -> None:
    counts = []
    for side in (20.0, 120.0):
        plan = plain_plan()
        asphalt_details(plan, generator(1), EAST, side, side)
        counts.append(len(plan.gains))
    assert counts[1] > 8 * max(1, counts[0])


@pytest.mark.parametrize("seed", range(6))
def test_a_calm_site_has_a_road_and_a_building_and_stalls_in_its_lot(seed: int) -> None:
    plan = plan_lot_site(generator(seed), (60.0, 50.0), replace(SIZE, second=0.5))
    lot = shapely.union_all([shapely.Polygon(outline) for outline in plan.lots]).buffer(0.05)
    assert all(lot.contains(area) for area in areas_of(plan.stalls))
    assert largest_overlap(areas_of(plan.stalls)) < 1e-3
    assert any(surface.material.kind == "asphalt" and not lot.contains(shapely.Polygon(surface.polygon)) for
               surface in plan.surfaces), "a road"  # fmt: skip
    assert plan.buildings
    assert max(plan.asphalt.colour) <= 165 + 1e-6, "white paint shows on it"


@pytest.mark.parametrize("seed", range(5))
def test_a_site_lies_about_its_centre(seed: int) -> None:
    plan = plan_lot_site(generator(seed), (500.0, -300.0), SIZE)
    centre = shapely.union_all([shapely.Polygon(outline) for outline in plan.lots]).centroid
    assert math.dist((centre.x, centre.y), (500.0, -300.0)) < 1.0


@pytest.mark.slow
def test_a_lot_of_two_sections_is_larger_than_its_main_one() -> None:
    single = [plan_any_lot_site(generator(seed), (0, 0), SIZE) for seed in range(5)]
    double = [plan_any_lot_site(generator(seed), (0, 0), replace(SIZE, second=1.0)) for seed in range(5)]
    area = [np.mean([shapely.Polygon(plan.lots[0]).area for plan in plans]) for plans in (single, double)]
    assert area[1] > 1.1 * area[0]


@pytest.mark.parametrize("plan_site", [plan_plain_site, plan_bare_site])
def test_sites_follow_from_their_generator(plan_site: object) -> None:
    one, two = (plan_site(generator(8), (1.0, 2.0)) for _ in range(2))  # type: ignore[operator]
    assert repr(one) == repr(two)
    assert repr(one) != repr(plan_site(generator(9), (1.0, 2.0)))  # type: ignore[operator]


def test_nothing_of_the_surroundings_stands_on_the_lot() -> None:
    for seed in range(6):
        plan = plan_any_lot_site(generator(seed), (0.0, 0.0), SIZE)
        lot = shapely.Polygon(plan.lots[0])
        houses = [shapely.Polygon(one.polygon) for one in plan.buildings if not one.shelter]
        assert all(lot.intersection(house).area < 0.35 * house.area for house in houses)


@pytest.mark.nightly
def test_shade_from_outside_falls_on_some_lots_to_train_on_and_on_no_calm_one() -> None:
    wild = [plan_any_lot_site(generator(seed), (0.0, 0.0), SIZE).shades for seed in range(30)]
    calm = [plan_lot_site(generator(seed), (0.0, 0.0), SIZE).shades for seed in range(10)]
    assert 1 <= sum(map(bool, wild)) <= 15
    assert not any(calm)
