from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.worlds.plan import Axes, SitePlan
from hawk.worlds.rows import PARALLEL_DEPTH_M, WORN_BELOW, hatch, plan_parallel_row, plan_row
from hawk.worlds.scene.cars import footprint_m
from hawk.worlds.style import LotStyle, sample_style
from tests.unit.worlds.builders import EAST, areas_of, generator, largest_overlap, plain_plan, plain_style

SEEDS = st.integers(0, 10_000)


def row(style: LotStyle, seed: int = 0, length: float = 60.0, *, mirrored: bool = False) -> SitePlan:
    plan = plain_plan()
    assert plan_row(plan, generator(seed), EAST, length, style, mirrored=mirrored) == len(plan.stalls)
    return plan


def sides(corners: np.ndarray) -> np.ndarray:
    return np.asarray(np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1))


@settings(max_examples=20)
@given(SEEDS, st.booleans(), st.floats(15, 90), st.booleans())
def test_stalls_of_any_row_have_the_style_s_size_and_do_not_overlap(
    seed: int, calm: bool, length: float, mirrored: bool
) -> None:
    style = sample_style(generator(seed), calm=calm)
    plan = row(style, seed, length, mirrored=mirrored)
    assert largest_overlap(areas_of(plan.stalls)) < 1e-3
    for stall in plan.stalls:
        short, long, other, back = sides(stall.corners)
        assert short == pytest.approx(style.pitch)
        assert other == pytest.approx(style.pitch)
        assert long == pytest.approx(back)
        assert shapely.Polygon(stall.corners).area == pytest.approx(style.pitch * style.depth)
        assert stall.corners[:2, 1] == pytest.approx(0), "the open end is at the aisle"
        assert stall.corners[2:, 1] == pytest.approx(style.depth)


@settings(max_examples=20)
@given(SEEDS, st.floats(-50, 50))
def test_angled_stalls_lean_by_their_skew_and_mirrored_ones_by_as_much_to_the_other_side(
    seed: int, skew: float
) -> None:
    style = plain_style(skew=math.radians(skew))
    leans = []
    for mirrored in (False, True):
        corners = row(style, seed, mirrored=mirrored).stalls[0].corners
        across, along = corners[3] - corners[0]
        leans.append(math.degrees(math.atan2(across, along)))
    assert leans == pytest.approx([skew, -skew], abs=1e-6)


@settings(max_examples=15)
@given(SEEDS, st.floats(-7, 7), st.floats(-100, 100), st.floats(-100, 100))
def test_a_row_turns_and_moves_with_its_axes(seed: int, angle: float, x: float, y: float) -> None:
    style, axes = plain_style(trees=0.5), Axes.turned((x, y), angle)
    turned = plain_plan()
    plan_row(turned, generator(seed), axes, 40.0, style)
    straight = row(style, seed, 40.0)
    assert len(turned.stalls) == len(straight.stalls)
    for one, other in zip(turned.stalls, straight.stalls, strict=True):
        assert one.taken is other.taken
        assert one.corners == pytest.approx(axes.points(other.corners), abs=1e-9)
    for car, other_car in zip(turned.vehicles, straight.vehicles, strict=True):
        assert (car.x, car.y) == pytest.approx(axes.at(other_car.x, other_car.y), abs=1e-9)
        assert math.remainder(car.heading - other_car.heading - angle, math.tau) == pytest.approx(0, abs=1e-9)


@settings(max_examples=15)
@given(SEEDS)
def test_a_taken_stall_has_one_car_mostly_inside_it_and_a_free_one_none(seed: int) -> None:
    style = sample_style(generator(seed), calm=True)
    plan = row(replace(style, occupancy=0.6), seed)
    cars = [shapely.Polygon(footprint_m(car)) for car in plan.vehicles]
    centres = [shapely.Point(car.x, car.y) for car in plan.vehicles]
    for stall, area in zip(plan.stalls, areas_of(plan.stalls), strict=True):
        inside = [car for car, centre in zip(cars, centres, strict=True) if area.contains(centre)]
        assert len(inside) == int(stall.taken)
        for car in inside:
            assert area.intersection(car).area > 0.65 * min(car.area, area.area)


@pytest.mark.parametrize(("occupancy", "low", "high"), [(0.0, 0.0, 0.2), (0.5, 0.3, 0.7), (1.0, 0.8, 1.0)])
def test_the_occupancy_is_the_share_of_taken_stalls(occupancy: float, low: float, high: float) -> None:
    taken = [stall.taken for seed in range(12) for stall in row(plain_style(occupancy=occupancy), seed).stalls]
    assert low <= np.mean(taken) <= high


def test_cars_park_along_the_stall_and_tidy_ones_more_exactly() -> None:
    deviations = {}
    for tidy in (0.2, 3.0):
        style = plain_style(occupancy=1.0, tidy=tidy, skew=math.radians(30))
        cars = [car for seed in range(8) for car in row(style, seed).vehicles]
        along = math.pi / 2 - math.radians(30)  # leant by its skew from square to the aisle
        turned = [abs(math.remainder(car.heading - along, math.pi)) for car in cars]
        deviations[tidy] = np.mean(turned)
        assert max(turned) < 0.5
    assert deviations[3.0] > 5 * deviations[0.2]


def test_most_cars_park_nose_first_and_some_backwards() -> None:
    cars = [car for seed in range(10) for car in row(plain_style(occupancy=1.0), seed).vehicles]
    backwards = np.mean([math.sin(car.heading) < 0 for car in cars])
    assert 0.15 < backwards < 0.45


@pytest.mark.parametrize("ending", [0, 1, 2])
def test_rows_end_with_nothing_an_island_or_hatching(ending: int) -> None:
    ends = tuple(float(k == ending) for k in range(3))
    plan = row(plain_style(ends=ends), 4)
    hatched = [stroke for stroke in plan.strokes if stroke.colour == 1]
    assert len(plan.islands) == (2 if ending == 1 else 0)
    assert bool(hatched) is (ending == 2)
    stalls = shapely.union_all(areas_of(plan.stalls)).buffer(-0.1)
    assert not any(stalls.intersects(shapely.Polygon(island.polygon)) for island in plan.islands)
    assert not any(stalls.intersects(shapely.Polygon(stroke.polygon)) for stroke in hatched)


def test_a_row_with_ends_is_shorter_than_one_without() -> None:
    plain = len(row(plain_style(), 1).stalls)
    assert all(len(row(plain_style(ends=ends), 1).stalls) < plain for ends in ((0, 1, 0), (0, 0, 1)))


def test_every_stall_of_a_plain_row_has_a_line_on_both_sides() -> None:
    plan = row(plain_style())
    lines = [stroke.polygon[:, 0].mean() for stroke in plan.strokes]
    for stall in plan.stalls:
        for x in (stall.corners[0, 0], stall.corners[1, 0]):
            assert min(abs(x - line) for line in lines) < 1e-6


def test_hairpins_are_two_lines_joined_at_the_open_end() -> None:
    plain, hairpin = row(plain_style()), row(plain_style(hairpin=True))
    assert len(hairpin.strokes) == 3 * len(plain.strokes)
    first = [stroke.polygon.mean(axis=0) for stroke in hairpin.strokes[:3]]
    assert sorted(place[0] for place in first) == pytest.approx([-0.2, 0.0, 0.2], abs=1e-6)
    assert first[2][1] == pytest.approx(0, abs=1e-6)


def test_dots_are_stones_in_a_row_with_gaps_between_them() -> None:
    dotted = row(plain_style(marks="dots"))
    stones: dict[float, list[float]] = {}
    for stroke in dotted.strokes:
        assert np.ptp(stroke.polygon, axis=0).max() < 0.3
        stones.setdefault(round(float(stroke.polygon[:, 0].mean()), 3), []).append(float(stroke.polygon[:, 1].mean()))
    assert len(stones) == len(dotted.stalls) + 1
    for places in stones.values():
        assert np.ptp(places) > 4, "along the whole stall"
        assert 0.3 <= np.diff(sorted(places)).mean() <= 0.7


def test_tees_cross_each_line_at_its_open_end() -> None:
    tees = row(plain_style(tees=True))
    crossing = [s.polygon for s in tees.strokes if np.ptp(s.polygon[:, 0]) > np.ptp(s.polygon[:, 1])]
    assert len(crossing) == len(tees.stalls) + 1
    assert all(np.ptp(polygon[:, 0]) == pytest.approx(0.8) for polygon in crossing)
    assert all(abs(polygon[:, 1].mean()) < 1e-6 for polygon in crossing)


@pytest.mark.parametrize(("name", "v"), [("front_line", 0.0), ("back_line", 5.0)])
def test_front_and_back_lines_join_all_stalls(name: str, v: float) -> None:
    plan = row(plain_style(**{name: 1.0}))
    (line,) = [s.polygon for s in plan.strokes if np.ptp(s.polygon[:, 0]) > 10]
    assert line[:, 1].mean() == pytest.approx(v)
    assert np.ptp(line[:, 0]) == pytest.approx(len(plan.stalls) * 2.5)


def test_dropped_lines_are_missing_or_short() -> None:
    plan = row(plain_style(drop=0.5), 2, 200.0)
    lengths = [np.ptp(stroke.polygon[:, 1]) for stroke in plan.strokes]
    assert len(lengths) < len(plan.stalls) + 1, "some are missing"
    assert min(lengths) < 0.85 * 5 < max(lengths)
    gone = [stall for stall in plan.stalls if stall.paint == 0]
    assert all(stall.worn for stall in gone)


def test_the_paint_of_a_stall_is_that_of_its_better_long_line() -> None:
    plan = row(plain_style(worn=0.5), 3, 150.0)
    strengths = [stroke.strength for stroke in plan.strokes]
    assert len(strengths) == len(plan.stalls) + 1
    for k, stall in enumerate(plan.stalls):
        assert stall.paint == pytest.approx(max(strengths[k : k + 2]))
        assert stall.worn is bool(min(strengths[k : k + 2]) < WORN_BELOW)


def test_worn_lines_come_in_stretches() -> None:
    plan = row(plain_style(worn=0.4), 5, 400.0)
    worn = np.array([stroke.strength < WORN_BELOW for stroke in plan.strokes])
    changes = np.abs(np.diff(worn.astype(int))).sum()
    assert 0.15 < worn.mean() < 0.7
    assert changes < worn.sum(), "a worn line mostly has a worn neighbour"


def test_islands_between_stalls_carry_trees_and_no_stall() -> None:
    plan = row(plain_style(break_share=0.3), 1, 120.0)
    stalls = shapely.union_all(areas_of(plan.stalls)).buffer(-0.05)
    assert len(plan.islands) > 5
    assert not any(stalls.intersects(shapely.Polygon(island.polygon)) for island in plan.islands)
    assert plan.trees
    grown = shapely.union_all([shapely.Polygon(island.polygon) for island in plan.islands]).buffer(0.3)
    assert all(grown.contains(shapely.Point(tree.x, tree.y)) for tree in plan.trees)


def test_trees_stand_at_the_closed_ends() -> None:
    plan = row(plain_style(trees=1.0), 1, 200.0)
    assert len(plan.trees) > 5
    assert all(tree.y == pytest.approx(5.0) for tree in plan.trees)
    assert all(1.0 <= tree.radius <= 2.0 for tree in plan.trees)


def test_wheel_stops_lie_in_their_stalls() -> None:
    plan = row(plain_style(wheel_stops=True))
    for stall, block in zip(areas_of(plan.stalls), plan.blocks, strict=True):
        assert stall.contains(shapely.Polygon(block.polygon))
        assert block.height == pytest.approx(0.15)


def test_accessible_stalls_are_less_often_taken_and_carry_a_sign() -> None:
    stalls, signs = [], 0
    for seed in range(60):
        plan = row(plain_style(accessible=1.0, occupancy=0.8), seed, 30.0)
        stalls += plan.stalls
        signs += any(stroke.colour == 2 for stroke in plan.strokes)
    taken = {kind: np.mean([s.taken for s in stalls if s.kind == kind]) for kind in ("accessible", "perpendicular")}
    assert taken["accessible"] < 0.6 * taken["perpendicular"]
    assert signs > 25


def test_unpainted_accessible_stalls_have_no_sign() -> None:
    assert row(plain_style(accessible=1.0, unpainted=True), 2).strokes == []


def test_a_shelter_replaces_a_stall_of_a_straight_row_only() -> None:
    straight = row(plain_style(shelters=0.5), 1, 100.0)
    leaning = row(plain_style(shelters=0.5, skew=0.4), 1, 100.0)
    assert len(straight.stalls) + len(straight.buildings) == 40
    assert all(building.shelter for building in straight.buildings)
    assert leaning.buildings == []
    roofs = shapely.union_all([shapely.Polygon(building.polygon) for building in straight.buildings])
    assert shapely.intersection(roofs, shapely.union_all(areas_of(straight.stalls))).area < 1e-6


@settings(max_examples=15)
@given(SEEDS, st.floats(8, 80))
def test_kerbside_stalls_stand_end_to_end_in_their_strip(seed: int, length: float) -> None:
    plan = plain_plan()
    count = plan_parallel_row(plan, generator(seed), EAST, length, plain_style(occupancy=0.7))
    assert count == len(plan.stalls) == len({stall.corners.tobytes() for stall in plan.stalls})
    corners = np.concatenate([stall.corners for stall in plan.stalls]) if count else np.zeros((1, 2))
    assert corners.min() >= -1e-9
    assert corners[:, 0].max() <= length + 1e-9
    assert corners[:, 1].max() <= PARALLEL_DEPTH_M
    assert largest_overlap(areas_of(plan.stalls)) < 1e-6
    assert len(plan.vehicles) == sum(stall.taken for stall in plan.stalls)
    for car in plan.vehicles:
        assert abs(math.remainder(car.heading, math.pi)) < 0.2, "along the kerb"


@settings(max_examples=20)
@given(SEEDS, st.floats(1.0, 4.0), st.floats(3.0, 7.0), st.floats(-2.0, 2.0))
def test_hatching_stays_in_any_bay(seed: int, width: float, depth: float, lean: float) -> None:
    plan = plain_plan()
    bay = np.array([[0.0, 0.0], [width, 0.0], [width + lean, depth], [lean, depth]])
    hatch(plan, generator(seed), bay, 0.1, 1, strength=0.7)
    area = shapely.Polygon(bay).buffer(0.2)
    assert plan.strokes
    assert all(area.contains(shapely.Polygon(stroke.polygon)) for stroke in plan.strokes)
    assert {stroke.strength for stroke in plan.strokes} == {0.7}
