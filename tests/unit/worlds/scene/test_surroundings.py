from __future__ import annotations

import math

import numpy as np
import pytest
import shapely

from hawk.worlds.scene.surroundings import (
    REACH_M,
    plan_clutter,
    plan_containers,
    plan_court,
    plan_road,
    plan_side,
    scatter_trees,
)
from tests.unit.worlds.builders import EAST, areas_of, generator, plain_plan
from training.sites import plan_wild

KINDS = ("road", "building", "grass", "yard", "dirt", "wild")
SEEDS = range(6)


def covered(polygons: list[np.ndarray]) -> shapely.Geometry:
    return shapely.union_all([shapely.Polygon(polygon) for polygon in polygons])


@pytest.mark.parametrize("kind", KINDS)
def test_a_side_is_ground_away_from_the_lot_and_has_no_stall(kind: str) -> None:
    for seed in SEEDS:
        plan = plain_plan()
        plan_side(plan, generator(seed), EAST, 30.0, kind=kind)
        ground = covered([surface.polygon for surface in plan.surfaces])
        assert ground.bounds[1] > -3.0, "it begins at the lot's edge"
        assert ground.contains(shapely.box(-30, 2, 30, 60).buffer(-1))
        assert plan.stalls == []
        assert plan.lots == []


def test_a_side_without_a_kind_is_of_any() -> None:
    seen = set()
    for seed in range(40):
        plan = plain_plan()
        plan_side(plan, generator(seed), EAST, 30.0)
        seen.add((bool(plan.buildings), bool(plan.vehicles), bool(plan.trees), bool(plan.strokes)))
    assert len(seen) >= 5


def test_the_building_of_a_side_is_as_long_as_its_edge_at_most() -> None:
    for seed in SEEDS:
        plan = plain_plan()
        plan_side(plan, generator(seed), EAST, 30.0, kind="building")
        (building,) = plan.buildings
        assert 0.6 * 60 <= building.width <= 60
        assert 3.5 <= building.height <= 11
        assert building.polygon[:, 1].min() >= 0


@pytest.mark.parametrize("seed", SEEDS)
def test_a_road_has_lines_and_cars_between_its_kerbs(seed: int) -> None:
    plan = plain_plan()
    width = plan_road(plan, generator(seed), EAST)
    assert 6.5 <= width <= 21
    (road,) = plan.surfaces
    assert np.ptp(road.polygon[:, 1]) == pytest.approx(width)
    assert np.ptp(road.polygon[:, 0]) == pytest.approx(2 * REACH_M)
    assert plan.strokes
    for stroke in plan.strokes:
        assert stroke.polygon[:, 1].min() > -0.3
        assert stroke.polygon[:, 1].max() < width + 0.6
    for car in plan.vehicles:
        assert 0 < car.y < width
        assert abs(math.remainder(car.heading, math.pi)) < 0.2, "it drives along the road"


@pytest.mark.parametrize("seed", SEEDS)
def test_a_court_has_its_markings_inside(seed: int) -> None:
    plan = plain_plan()
    plan_court(plan, generator(seed), EAST)
    outer, inner = (shapely.Polygon(surface.polygon) for surface in plan.surfaces)
    assert outer.contains(inner)
    assert len(plan.strokes) >= 4 + 3 + 1 + 16
    assert all(inner.buffer(0.2).contains(shapely.Polygon(stroke.polygon)) for stroke in plan.strokes)
    assert all(surface.material.kind == "court" for surface in plan.surfaces)


def test_containers_stand_side_by_side_and_do_not_overlap() -> None:
    lengths = set()
    for seed in range(12):
        plan = plain_plan()
        plan_containers(plan, generator(seed), EAST)
        boxes = [shapely.Polygon(building.polygon) for building in plan.buildings]
        lengths |= {building.depth for building in plan.buildings}
        assert all(building.width == pytest.approx(2.44) for building in plan.buildings)
        assert all(building.height in (pytest.approx(2.6), pytest.approx(5.2)) for building in plan.buildings)
        assert shapely.union_all(boxes).area == pytest.approx(sum(box.area for box in boxes), rel=1e-6)
    assert lengths == {6.1, 12.2}


def test_clutter_stays_on_its_lot_and_grows_with_it() -> None:
    counts = []
    for width in (30.0, 200.0):
        blocks = []
        for seed in range(8):
            plan = plain_plan()
            plan_clutter(plan, generator(seed), EAST, width, 50.0)
            blocks += plan.blocks
            middles = np.array([gain.points.mean(axis=0) for gain in plan.gains]).reshape(-1, 2)
            assert ((middles >= 0) & (middles <= (width, 50))).all()
        places = np.array([block.polygon.mean(axis=0) for block in blocks])
        assert ((places >= 0) & (places <= (width, 50))).all()
        assert all(0.4 <= block.height <= 1.6 for block in blocks)
        counts.append(len(blocks))
    assert counts[1] > 3 * counts[0]


@pytest.mark.parametrize("count", [0, 1, 25])
def test_scattered_trees_are_as_many_as_asked_and_inside(count: int) -> None:
    plan = plain_plan()
    scatter_trees(plan, generator(2), EAST.moved(10, 20), 30.0, 15.0, count)
    assert len(plan.trees) == count
    for tree in plan.trees:
        assert 10 <= tree.x <= 40
        assert 20 <= tree.y <= 35
        assert 1 <= tree.height <= 14


def test_no_tree_stands_in_water() -> None:
    watery = 0
    for seed in range(60):
        plan = plain_plan()
        plan_side(plan, generator(seed), EAST, 30.0, kind="wild")
        lakes = [s.polygon for s in plan.surfaces if s.material.kind == "water"]
        if lakes:
            watery += 1
            lake = covered(lakes).buffer(-3.5)
            assert not any(lake.contains(shapely.Point(tree.x, tree.y)) for tree in plan.trees)
    assert watery > 3


def test_a_driveway_joins_the_lot_to_its_road() -> None:
    joined = 0
    for seed in range(30):
        plan = plain_plan()
        plan_side(plan, generator(seed), EAST, 30.0, kind="road")
        narrow = [s for s in plan.surfaces if np.ptp(s.polygon[:, 0]) < 10]
        for surface in narrow:
            joined += 1
            assert surface.material is plan.asphalt
            assert surface.polygon[:, 1].min() == pytest.approx(0), "from the lot's edge"
            assert 5 <= np.ptp(surface.polygon[:, 0]) <= 9
    assert joined > 5


def test_a_wild_place_is_ground_everywhere_around_and_differs_by_seed() -> None:
    seen = set()
    for seed in SEEDS:
        plan = plain_plan()
        plan_wild(plan, generator(seed), EAST)
        ground = covered([surface.polygon for surface in plan.surfaces])
        assert ground.contains(shapely.box(-60, -60, 60, 60))
        assert areas_of(plan.stalls) == []
        seen.add(plan.surfaces[0].material)
    assert len(seen) == len(SEEDS)
