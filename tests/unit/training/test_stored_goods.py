from dataclasses import replace

import numpy as np
import pytest
import shapely

from hawk.worlds.plan import SitePlan
from hawk.worlds.site import SiteSize
from training import stored_goods
from training.scenes import draw_scene
from training.sites import plan_any_lot_site
from training.stored_goods import store_goods

SIZE = SiteSize(width=(50, 60), depth=(30, 40), second=0.0)


def _plans(count: int) -> list[SitePlan]:
    return [plan_any_lot_site(np.random.default_rng(seed), (0.0, 0.0), SIZE) for seed in range(count)]


def _stored(plan: SitePlan, seed: int) -> shapely.Geometry | None:
    """Store goods in a plan whose stalls are all free; return the ground of the stalls that they take."""
    plan.vehicles = [one for one in plan.vehicles if not _stalls(plan).contains(shapely.Point(one.x, one.y))]
    plan.stalls = [replace(stall, taken=False) for stall in plan.stalls]
    store_goods(plan, np.random.default_rng(seed))
    taken = [shapely.Polygon(stall.corners) for stall in plan.stalls if stall.taken]
    return shapely.unary_union(taken) if taken else None


def _stalls(plan: SitePlan) -> shapely.Geometry:
    return shapely.unary_union([shapely.Polygon(stall.corners) for stall in plan.stalls])


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_containers_and_crates_stand_in_stalls_side_by_side_which_they_take(
    monkeypatch: pytest.MonkeyPatch, share: float
) -> None:
    monkeypatch.setattr(stored_goods, "_TENT_SHARE", 0.0)
    monkeypatch.setattr(stored_goods, "_CONTAINER_SHARE", share)
    stored = 0
    for seed, plan in enumerate(_plans(12)):
        before = len(plan.blocks)
        if (area := _stored(plan, seed)) is None:
            continue  # no row is that long
        stored += 1
        goods = [shapely.Polygon(block.polygon) for block in plan.blocks[before:]]
        assert isinstance(area.buffer(0.1), shapely.Polygon), "one piece"
        assert goods
        assert all(area.buffer(0.8).contains(piece) for piece in goods)
        assert shapely.unary_union(goods).area > 0.15 * area.area
    assert stored > 5


def test_a_car_leaves_the_stalls_that_goods_take() -> None:
    for seed, plan in enumerate(_plans(12)):
        before = list(plan.stalls)
        store_goods(plan, np.random.default_rng(seed))
        fresh = [new for old, new in zip(before, plan.stalls, strict=True) if new is not old]
        assert all(stall.taken for stall in fresh)
        areas = [shapely.Polygon(stall.corners).buffer(-0.01) for stall in fresh]
        assert not any(area.contains(shapely.Point(one.x, one.y)) for one in plan.vehicles for area in areas)


def test_tents_cover_their_stalls_and_the_ground_below_them_stays_in_the_lot(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stored_goods, "_TENT_SHARE", 1.0)
    covered = 0
    for seed, plan in enumerate(_plans(12)):
        before = len(plan.buildings)
        if (area := _stored(plan, seed)) is None:
            continue
        tents = plan.buildings[before:]
        roofs = shapely.unary_union([shapely.Polygon(tent.polygon) for tent in tents])
        assert all(tent.shelter for tent in tents)
        assert roofs.intersection(area).area > 0.6 * area.area, "angled stalls stand out of a square tent"
        covered += 1
    assert covered > 5


def test_stalls_under_a_tent_are_hidden_in_the_scene(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stored_goods, "_TENT_SHARE", 1.0)
    under: list[int] = []

    def plan(rng: np.random.Generator) -> SitePlan:
        made = plan_any_lot_site(rng, (0.0, 0.0), SIZE)
        before = len(made.buildings)
        for _ in range(5):
            store_goods(made, rng)
        under.append(len(made.buildings) - before)
        return made

    scenes = [draw_scene(np.random.default_rng(seed), 512, plan_site=plan) for seed in range(3)]
    assert sum(under) > 5
    assert sum(stall.hidden and not stall.implied for scene in scenes for stall in scene.stalls) > 5


def test_a_plan_without_stalls_gets_no_goods() -> None:
    plan = _plans(1)[0]
    plan.stalls.clear()
    blocks, buildings = len(plan.blocks), len(plan.buildings)
    store_goods(plan, np.random.default_rng(0))
    assert (len(plan.blocks), len(plan.buildings)) == (blocks, buildings)
