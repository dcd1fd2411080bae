from dataclasses import replace

import numpy as np
import pytest

from hawk.worlds.plan import Axes, Building, RoofPainter
from hawk.worlds.scene.buildings import draw_building
from hawk.worlds.scene.canvas import Canvas
from hawk.worlds.scene.light import Sun
from hawk.worlds.scene.materials import Material
from training import house_roofs
from training.house_roofs import draw_house_roofs, draw_shed_roof
from training.streets import plan_street_site

EAST = Axes((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
TILES = Material("roof", (100.0, 100.0, 100.0), 0, 0, 0)
LOW_SUN = Sun((0.0, 1.5), (0.5, 0.45, 0.4), 0.0)
"""It stands in the north: shadows reach 1.5 m to the south from each metre."""


def _painted(painter: RoofPainter, size: tuple[float, float], seed: int = 0, sun: Sun = LOW_SUN) -> np.ndarray:
    """Return a roof's BGR picture at 0.1 m for a pixel, with the painter's things alone on it."""
    canvas = Canvas(0.0, 0.0, round(size[0] * 10), round(size[1] * 10), 0.1)
    canvas.image += 100
    painter(np.random.default_rng(seed), canvas, Building(EAST, *size, 6.0, TILES), sun)
    return canvas.image


def _bare(monkeypatch: pytest.MonkeyPatch, *, solar: float = 0.0, dormers: float = 0.0) -> None:
    monkeypatch.setattr(house_roofs, "_SOLAR_SHARE", solar)
    monkeypatch.setattr(house_roofs, "_DORMER_SHARE", dormers)


def test_the_slope_that_faces_the_sun_is_brighter(monkeypatch: pytest.MonkeyPatch) -> None:
    _bare(monkeypatch)
    north_sun = _painted(draw_house_roofs, (30.0, 10.0))
    south_sun = _painted(draw_house_roofs, (30.0, 10.0), sun=replace(LOW_SUN, shadow=(0.0, -1.5)))
    for picture, factor in ((north_sun, 1.0), (south_sun, -1.0)):
        north, south = np.median(picture[:30]), np.median(picture[-30:])
        assert factor * (north - south) > 20


def test_solar_panels_are_dark_and_blue_and_parted_by_their_frames(monkeypatch: pytest.MonkeyPatch) -> None:
    _bare(monkeypatch, solar=1.0)
    panels = 0
    for seed in range(6):
        picture = _painted(draw_house_roofs, (30.0, 10.0), seed, sun=replace(LOW_SUN, shadow=(0.0, 0.0)))
        blue, _, red = np.moveaxis(picture, 2, 0)
        is_panel = (red < 60) & (blue > red + 20)
        panels += bool(is_panel.mean() > 0.1)
        edges = np.count_nonzero(np.diff(is_panel.astype(int), axis=1) > 0)
        assert edges > 20, "many single panels, not one dark sheet"
    assert panels == 6


def test_a_dormer_has_a_pale_rim_and_casts_a_shadow(monkeypatch: pytest.MonkeyPatch) -> None:
    _bare(monkeypatch)
    without = _painted(draw_house_roofs, (30.0, 10.0))
    _bare(monkeypatch, dormers=1.0)
    dormers = _painted(draw_house_roofs, (30.0, 10.0))
    assert (dormers.min(2) > 145).mean() > (without.min(2) > 145).mean() + 0.02
    assert (dormers[50:].max(2) < 45).mean() > (without[50:].max(2) < 45).mean() + 0.02


def test_a_shed_of_felt_often_has_a_pale_rim() -> None:
    edges = [_painted(draw_shed_roof, (4.0, 3.0), seed) for seed in range(30)]
    pale = [picture[0].mean() > picture[15, 20].mean() + 40 for picture in edges]
    assert 8 < sum(pale) < 28


@pytest.mark.slow
def test_all_of_a_streets_houses_have_such_roofs_and_can_be_drawn() -> None:
    painters: set[RoofPainter | None] = set()
    for seed in range(4):
        plan = plan_street_site(np.random.default_rng(seed), (0.0, 0.0))
        painters |= {building.crowd for building in plan.buildings if not building.shelter}
        for building in plan.buildings[:4]:
            roof = draw_building(np.random.default_rng(seed), building, LOW_SUN, 0.1)[-1].pixels
            assert roof[..., :3].std() > 3
    assert painters == {draw_house_roofs, draw_shed_roof}


def test_a_roof_smaller_than_a_panel_stays_without_one(monkeypatch: pytest.MonkeyPatch) -> None:
    _bare(monkeypatch, solar=1.0)
    assert np.isfinite(_painted(draw_house_roofs, (2.0, 1.5))).all()
