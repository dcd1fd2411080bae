import numpy as np
import shapely

from hawk.worlds.plan import SitePlan
from hawk.worlds.site import SiteSize
from training.row_ends import plant_row_end
from training.sites import plan_any_lot_site

SIZE = SiteSize(width=(50, 60), depth=(30, 40), second=0.0)


def _plans(count: int) -> list[SitePlan]:
    return [plan_any_lot_site(np.random.default_rng(seed), (0.0, 0.0), SIZE) for seed in range(count)]


def test_an_island_closes_a_row_along_the_outer_side_of_its_last_stall() -> None:
    closed = planted = 0
    for seed, plan in enumerate(_plans(20)):
        before, trees = len(plan.islands), len(plan.trees)
        plant_row_end(plan, np.random.default_rng(seed))
        if len(plan.islands) == before:
            continue  # there is no room
        island = shapely.Polygon(plan.islands[-1].polygon)
        areas = [shapely.Polygon(stall.corners) for stall in plan.stalls]
        overlaps = sorted(island.intersection(area).area for area in areas)
        closed += 1
        assert min(island.distance(area) for area in areas) < 0.15
        assert sum(area > 0.001 for area in overlaps) <= 1, "it reaches into the stall that it closes at most"
        assert overlaps[-1] < 1.0, "a strip of 15 cm"
        places = [shapely.Point(tree.x, tree.y) for tree in plan.trees[trees:]]
        assert all(island.buffer(0.01).contains(place) for place in places)
        planted += len(places)
    assert closed > 10
    assert planted > 5


def test_bushes_hang_over_the_last_stall() -> None:
    covered = 0
    for seed, plan in enumerate(_plans(20)):
        trees = len(plan.trees)
        plant_row_end(plan, np.random.default_rng(seed))
        stalls = shapely.unary_union([shapely.Polygon(stall.corners) for stall in plan.stalls])
        covered += any(
            shapely.Point(tree.x, tree.y).buffer(tree.radius).intersects(stalls) for tree in plan.trees[trees:]
        )
    assert covered > 5


def test_a_plan_without_stalls_gets_no_row_end() -> None:
    plan = _plans(1)[0]
    plan.stalls.clear()
    islands = len(plan.islands)
    plant_row_end(plan, np.random.default_rng(0))
    assert len(plan.islands) == islands
