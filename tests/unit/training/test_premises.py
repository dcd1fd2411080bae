from dataclasses import replace

import cv2
import numpy as np
import pytest
import shapely

from hawk.worlds.generate import SiteSize
from hawk.worlds.layout import plan_section
from hawk.worlds.plan import Axes, Building, SitePlan
from hawk.worlds.scene.buildings import draw_building
from hawk.worlds.scene.canvas import Canvas
from hawk.worlds.scene.cars import dimmed, draw_vehicle
from hawk.worlds.scene.light import Sun
from hawk.worlds.scene.materials import Material
from hawk.worlds.scene.render import draw_plan
from hawk.worlds.style import sample_style
from training import premises, sites
from training.crowded_roofs import draw_crowd
from training.scenes import PLAIN_SHARE, SceneStall, _implied, draw_scene
from training.sites import plan_any_lot_site, plan_plain_site

GREY = Material("asphalt", (100.0, 100.0, 100.0), 0, 0, 0)
PALE = Material("roof", (220.0, 220.0, 220.0), 0, 0, 0)
SUN = Sun((0.6, 0.3), (0.5, 0.45, 0.4), 0.0)
EAST = Axes((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
SIZE = SiteSize((40, 60), (30, 40), second=0.0)


def _rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def _plan() -> SitePlan:
    return SitePlan(axes=EAST, ground=GREY, asphalt=GREY, palette=[(255.0, 255.0, 255.0)] * 4, wear=0.0)


@pytest.mark.parametrize("kind", ["_roofscape", "_apron", "_garden", "_terrace", "_courts", "_solar_field"])
def test_premises_have_something_on_them_and_no_stall(kind: str) -> None:
    for seed in range(4):
        plan = _plan()
        getattr(premises, kind)(plan, _rng(seed), EAST, 25.0)
        assert plan.stalls == []
        assert plan.lots == []
        assert plan.surfaces
        things = (*plan.blocks, *plan.buildings, *plan.strokes, *plan.surfaces[1:])
        assert things
        middles = [building.axes.at(building.width / 2, building.depth / 2)[1] for building in plan.buildings]
        middles += [float(block.polygon[:, 1].mean()) for block in plan.blocks]
        assert all(v > 0 for v in middles), "on the far side of the edge"


@pytest.mark.slow
def test_all_premises_come_and_can_be_drawn() -> None:
    pictures = []
    for seed in range(12):
        plan = _plan()
        premises.plan_premises(plan, _rng(seed), EAST, 25.0)
        drawn = draw_plan(plan, Canvas(-15, 0, 200, 200, 0.15), SUN, _rng(seed))
        assert np.isfinite(drawn.ground).all()
        pictures.append(drawn.ground)
    assert len({round(float(picture.std()), 3) for picture in pictures}) == 12


@pytest.mark.slow
def test_a_crowded_roof_has_many_edges() -> None:
    plain = Building(EAST, 30.0, 20.0, 5.0, PALE)
    edges = {None: 0.0, draw_crowd: 0.0}
    for seed in range(6):
        for crowd in edges:
            roof = draw_building(_rng(seed), replace(plain, crowd=crowd), SUN, 0.1)[-1].pixels
            edges[crowd] += cv2.Laplacian(roof[..., 1], cv2.CV_32F).std() / 6
    assert edges[draw_crowd] > 1.1 * edges[None]


def test_a_roof_is_made_of_what_its_building_names() -> None:
    roof = draw_building(
        _rng(2), Building(EAST, 5.0, 4.0, 3.0, Material("court", (200.0, 90.0, 30.0), 0, 0, 0)), SUN, 0.1
    )
    blue, green, red = np.median(roof[-1].pixels[..., :3].reshape(-1, 3), axis=0)
    assert blue > 1.5 * green > 2 * red


def test_a_shelter_stands_where_a_stall_would_be() -> None:
    plan, style = _plan(), replace(sample_style(_rng(3)), shelters=1.0, skew=0.0, hatch=0.0, break_share=0.0)
    assert plan_section(plan, _rng(4), EAST, 40.0, 18.0, replace(style, side_rows=0.0)) == len(plan.stalls)
    assert all(stall.kind == "parallel" for stall in plan.stalls)
    shelters = [building for building in plan.buildings if building.shelter]
    assert len(shelters) > 5
    assert all(2 < building.width * building.depth < 16 for building in shelters)
    assert plan.vehicles == [] or plan.vehicles[0].kind


def test_a_plain_site_is_one_ground_with_rows_that_can_be_seen() -> None:
    for seed in range(10):
        plan = plan_plain_site(_rng(seed), (5.0, 5.0))
        assert plan.stalls
        assert len(plan.surfaces) == 1
        assert plan.buildings == [] or all(building.shelter for building in plan.buildings)
        lot = shapely.Polygon(plan.lots[0]).buffer(0.1)
        assert all(lot.contains(shapely.Polygon(stall.corners)) for stall in plan.stalls)
        assert np.abs(np.array(plan.palette[0]) - plan.asphalt.colour).max() > 40


def test_a_lot_on_a_roof_has_a_parapet_around_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sites, "ROOF_PARKING_SHARE", 1.0)
    raised = plan_any_lot_site(_rng(1), (0.0, 0.0), SIZE)
    wall, deck = raised.surfaces[-2:]
    assert shapely.Polygon(wall.polygon).buffer(0.01).contains(shapely.Polygon(deck.polygon))
    assert shapely.Polygon(wall.polygon).area > shapely.Polygon(deck.polygon).area + 10
    assert deck.material is raised.asphalt


def test_dim_vehicles_are_dark_and_flat() -> None:
    for seed in range(10):
        model = draw_vehicle(_rng(seed), "suv")
        dim = dimmed(_rng(seed), model)
        assert (dim.length, dim.width, len(dim.sprites)) == (model.length, model.width, len(model.sprites))
        body, before = dim.sprites[0].pixels, model.sprites[0].pixels
        assert np.array_equal(body[..., 3], before[..., 3])
        shown = body[..., :3][body[..., 3] > 0]
        assert np.median(shown) < 100
        assert shown.std() < 60


def _stall(x: float, covered: float) -> SceneStall:
    quad = np.array([[x, 40.0], [x + 26, 40], [x + 26, 92], [x, 92]])
    return SceneStall(quad, False, covered >= 0.7, False, True, 1.0, covered, "perpendicular")


def test_hidden_stalls_are_implied_only_near_others_and_under_crowns() -> None:
    roofs = np.zeros((140, 300), np.uint8)
    roofs[:, 26:52] = 1
    row = [_stall(0, 0.1), _stall(26, 0.9), _stall(52, 0.9), _stall(78, 0.9), _stall(104, 0.6)]
    marked = _implied(row, roofs)
    assert [stall.implied for stall in marked] == [False, False, True, False, False]
    assert not any(stall.implied for stall in _implied(row[1:], roofs)), "nobody shows"


@pytest.mark.nightly
@pytest.mark.slow
def test_scenes_have_implied_stalls_and_plain_ones_are_few() -> None:
    stalls = [s for seed in range(40) for s in draw_scene(_rng(seed), 256).stalls]
    assert any(stall.implied for stall in stalls)
    assert all(stall.hidden for stall in stalls if stall.implied)
    assert 0 < PLAIN_SHARE < 0.2
