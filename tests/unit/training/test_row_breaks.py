import numpy as np
import pytest
import shapely

from hawk.worlds.generate import SiteSize
from hawk.worlds.plan import SitePlan, Stroke
from hawk.worlds.scene.canvas import Canvas
from hawk.worlds.scene.light import Sun
from hawk.worlds.scene.render import draw_plan
from training import row_breaks
from training.paved import plan_paved_site
from training.row_breaks import break_row
from training.sites import plan_any_lot_site

SIZE = SiteSize(width=(50, 60), depth=(30, 40), second=0.0)


def _plans(count: int) -> list[SitePlan]:
    return [plan_any_lot_site(np.random.default_rng(seed), (0.0, 0.0), SIZE) for seed in range(count)]


def _broken(plan: SitePlan, seed: int) -> shapely.Geometry | None:
    """Break a row; return the ground of the stalls that went."""
    before = list(plan.stalls)
    break_row(plan, np.random.default_rng(seed))
    kept = {id(stall) for stall in plan.stalls}
    gone = [shapely.Polygon(stall.corners) for stall in before if id(stall) not in kept]
    return shapely.unary_union(gone) if gone else None


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.0, 1.0])
def test_a_break_takes_stalls_side_by_side_with_their_cars_and_lines(
    monkeypatch: pytest.MonkeyPatch, share: float
) -> None:
    monkeypatch.setattr(row_breaks, "_DRIVEWAY_SHARE", share)
    breaks = 0
    for seed, plan in enumerate(_plans(20)):
        area = _broken(plan, seed)
        if area is None:
            continue  # no row is that long
        breaks += 1
        assert isinstance(area.buffer(0.1), shapely.Polygon), "one piece"
        assert not any(area.contains(shapely.Point(one.x, one.y)) for one in plan.vehicles)
        last = len(plan.surfaces) - 1
        ground = shapely.Polygon(plan.surfaces[last].polygon)
        assert ground.buffer(0.01).contains(area)
        assert ground.area < 1.4 * area.area
        assert not any(_shows_in(stroke, area, last) for stroke in plan.strokes)
    assert breaks > 6


def _shows_in(stroke: Stroke, area: shapely.Geometry, last_surface: int) -> bool:
    return stroke.order > last_surface and area.intersects(shapely.Polygon(stroke.polygon))


@pytest.mark.slow
def test_many_driveways_pass_between_two_islands(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(row_breaks, "_DRIVEWAY_SHARE", 1.0)
    islands = []
    for seed, plan in enumerate(_plans(16)):
        before = len(plan.islands)
        if (area := _broken(plan, seed)) is None:
            continue
        fresh = [shapely.Polygon(island.polygon) for island in plan.islands[before:]]
        islands.append(len(fresh))
        assert all(area.contains(island) for island in fresh)
        assert not fresh or fresh[0].distance(fresh[1]) > 1.5, "room to drive through"
    assert {0, 2} == set(islands)


@pytest.mark.nightly
@pytest.mark.slow
def test_racks_hold_bicycles_that_show_in_the_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(row_breaks, "_DRIVEWAY_SHARE", 0.0)
    held = []
    for seed, plan in enumerate(_plans(14)):
        before = len(plan.blocks)
        if (area := _broken(plan, seed)) is None:
            continue
        bicycles = [shapely.Polygon(block.polygon) for block in plan.blocks[before:]]
        held.append(len(bicycles) // 2)
        assert all(area.buffer(0.6).contains(bicycle) for bicycle in bicycles)
        rough = []
        for blocks in (plan.blocks, plan.blocks[:before]):
            plan.blocks = blocks
            x, y = area.centroid.coords[0]
            sun, rng = Sun((0.3, 0.3), (0.5, 0.45, 0.4), 0.0), np.random.default_rng(0)
            drawn = draw_plan(plan, Canvas(x - 4, y - 4, 80, 80, 0.1), sun, rng).ground
            rough.append(float(np.abs(np.diff(drawn.mean(2), axis=1)).mean()))
        assert not bicycles or rough[0] > rough[1]
    assert len(held) > 4
    assert max(held) > 6


def test_a_plan_without_a_row_stays_as_it_is() -> None:
    plan = plan_paved_site(np.random.default_rng(0), (0.0, 0.0), SIZE)
    plan.stalls = plan.stalls[:1]
    surfaces, stalls = list(plan.surfaces), list(plan.stalls)
    for seed in range(5):
        break_row(plan, np.random.default_rng(seed))
    assert (plan.surfaces, plan.stalls) == (surfaces, stalls)
    plan.stalls.clear()
    break_row(plan, np.random.default_rng(0))
    assert plan.stalls == []
