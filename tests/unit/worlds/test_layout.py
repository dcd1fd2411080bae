import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.worlds.generate import SiteSize
from hawk.worlds.layout import plan_section
from hawk.worlds.plan import Axes, SitePlan
from hawk.worlds.rows import WORN_BELOW, hatch, plan_parallel_row, plan_row
from hawk.worlds.scene.materials import Material
from hawk.worlds.style import LotStyle, sample_palette, sample_style
from tests.examples import examples
from training.sites import plan_any_lot_site, plan_bare_site

GREY = Material("asphalt", (100.0, 100.0, 100.0), 0, 0, 0)
EAST = Axes((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))


def _rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def _plan() -> SitePlan:
    return SitePlan(axes=EAST, ground=GREY, asphalt=GREY, palette=[(255.0, 255.0, 255.0)] * 4)


def _style(**changes: object) -> LotStyle:
    plain: dict[str, object] = {
        "width": 2.5, "length": 5.0, "skew": 0.0, "aisle": 6.0, "occupancy": 0.5, "line_width": 0.12, "drop": 0.0,
        "worn": 0.0, "hairpin": False, "tees": False, "front_line": 0.0, "back_line": 0.0, "hatch": 0.0,
        "wheel_stops": False, "island": GREY, "break_share": 0.0, "trees": 0.0, "crown": (1.0, 2.0), "medians": 0.0,
        "side_rows": 0.0, "accessible": 0.0, "ends": (1.0, 0.0, 0.0), "tidy": 1.0, "kerb": None, "unpainted": False,
    }  # fmt: skip
    return LotStyle(**{**plain, **changes})  # type: ignore[arg-type]


def test_a_plain_row_has_the_stalls_that_fit() -> None:
    plan = _plan()
    assert plan_row(plan, _rng(), EAST, 25.2, _style()) == 10
    assert len(plan.stalls) == 10
    assert len(plan.strokes) == 11
    assert plan.stalls[3].corners == pytest.approx(np.array([[7.5, 0], [10, 0], [10, 5], [7.5, 5]]))
    assert all(stall.kind == "perpendicular" and not stall.worn for stall in plan.stalls)


def test_a_row_too_short_for_a_stall_is_empty() -> None:
    plan = _plan()
    assert plan_row(plan, _rng(), EAST, 2.0, _style()) == 0
    assert plan.strokes == []


@pytest.mark.slow
@settings(max_examples=examples(40))
@given(st.floats(-45, 45), st.booleans(), st.floats(20, 60))
def test_angled_stalls_keep_their_width_and_stay_in_their_row(skew: float, mirrored: bool, length: float) -> None:
    plan, style = _plan(), _style(skew=math.radians(skew))
    count = plan_row(plan, _rng(), EAST, length, style, mirrored=mirrored)
    assert count == len(plan.stalls)
    for stall in plan.stalls:
        assert stall.corners[:, 0].min() >= -1e-6
        assert stall.corners[:, 0].max() <= length + 1e-6
        assert np.ptp(stall.corners[:, 1]) == pytest.approx(style.depth)
        side = stall.corners[3] - stall.corners[0]
        across = stall.corners[1] - stall.corners[0]
        width = abs(float(np.cross([*side, 0], [*across, 0])[2])) / np.linalg.norm(side)
        assert width == pytest.approx(2.5, abs=1e-6)


def test_cars_stand_in_taken_stalls_only() -> None:
    plan = _plan()
    plan_row(plan, _rng(3), EAST, 80, _style(occupancy=0.6))
    assert len(plan.vehicles) == sum(stall.taken for stall in plan.stalls)
    assert 8 < len(plan.vehicles) < 28
    for stall in plan.stalls:
        area = shapely.Polygon(stall.corners)
        assert stall.taken == any(area.contains(shapely.Point(car.x, car.y)) for car in plan.vehicles)


def test_worn_lines_make_worn_stalls() -> None:
    plan = _plan()
    plan_row(plan, _rng(1), EAST, 150, _style(worn=0.5))
    worn = [stall.worn for stall in plan.stalls]
    assert 0.2 < np.mean(worn) < 0.95
    assert all(stall.worn for stall in plan.stalls if stall.paint < WORN_BELOW)


def test_unpainted_rows_have_cars_and_no_paint() -> None:
    plan = _plan()
    plan_row(plan, _rng(1), EAST, 50, _style(unpainted=True, back_line=1.0, front_line=1.0, hatch=0.5, tees=True))
    assert plan.strokes == []
    assert len(plan.stalls) == 20
    assert all(stall.paint == 0 for stall in plan.stalls)


def test_islands_and_hatched_bays_are_no_stalls() -> None:
    islands, hatched = _plan(), _plan()
    plan_row(islands, _rng(1), EAST, 50, _style(break_share=0.5, ends=(0.0, 1.0, 0.0)))
    plan_row(hatched, _rng(1), EAST, 50, _style(hatch=0.5))
    assert len(islands.islands) > 4
    assert len(islands.stalls) < 15
    assert len(hatched.stalls) < 17
    bays = [shapely.Polygon(stall.corners).buffer(-0.3) for stall in hatched.stalls]
    slanted = [stroke for stroke in hatched.strokes if stroke.colour == 1]
    assert slanted
    assert not any(bay.intersects(shapely.Polygon(stroke.polygon)) for bay in bays for stroke in slanted)


@pytest.mark.parametrize(("bare_ends", "lines"), [(0.0, 2), (1.0, 0)])
def test_where_the_kerb_bounds_the_last_stall_it_has_no_line_there(bare_ends: float, lines: int) -> None:
    plan = _plan()
    plan_row(plan, _rng(1), EAST, 50, _style(ends=(0.0, 1.0, 0.0), bare_ends=bare_ends))
    ends = [min(s.corners[:, 0].min() for s in plan.stalls), max(s.corners[:, 0].max() for s in plan.stalls)]
    drawn = [stroke for stroke in plan.strokes if np.abs(stroke.polygon[:, 0].mean() - ends).min() < 0.1]
    assert len(drawn) == lines
    assert len(plan.strokes) == len(plan.stalls) - 1 + lines


@pytest.mark.parametrize("seed", range(12))
def test_hatching_stays_in_its_bay(seed: int) -> None:
    plan = _plan()
    bay = np.array([[0.0, 0.0], [2.5, 0.0], [3.5, 5.0], [1.0, 5.0]])
    hatch(plan, _rng(seed), bay, 0.1, 1)
    assert len(plan.strokes) >= 3
    area = shapely.Polygon(bay).buffer(0.15)
    assert all(area.contains(shapely.Polygon(stroke.polygon)) for stroke in plan.strokes)


def test_accessible_stalls_are_signed_at_the_start_of_a_row() -> None:
    plan = _plan()
    plan_row(plan, _rng(2), EAST, 50, _style(accessible=1.0))
    kinds = [stall.kind for stall in plan.stalls]
    count = kinds.count("accessible")
    assert 1 <= count <= 4
    assert kinds[:count] == ["accessible"] * count
    assert any(stroke.colour == 3 for stroke in plan.strokes)


def test_wheel_stops_stand_near_the_closed_end() -> None:
    plan = _plan()
    plan_row(plan, _rng(2), EAST, 25, _style(wheel_stops=True))
    assert len(plan.blocks) == len(plan.stalls)
    assert all(4 < block.polygon[:, 1].mean() < 5 for block in plan.blocks)


def test_parallel_stalls_have_their_short_ends_across_the_kerb() -> None:
    plan = _plan()
    count = plan_parallel_row(plan, _rng(), EAST, 40, _style())
    assert count == len(plan.stalls)
    for stall in plan.stalls:
        sides = np.linalg.norm(np.roll(stall.corners, -1, axis=0) - stall.corners, axis=1)
        assert sides[0] == pytest.approx(sides[2])
        assert sides[0] < 3 < 5.9 < sides[1]
        assert stall.kind == "parallel"


@pytest.mark.parametrize("seed", range(15))
@pytest.mark.parametrize("calm", [True, False])
def test_sections_keep_their_bounds_and_leave_aisles(seed: int, calm: bool) -> None:
    rng, plan = _rng(seed), _plan()
    style = sample_style(rng, calm=calm)
    width, depth = rng.uniform(20, 90), rng.uniform(12, 70)
    count = plan_section(plan, rng, EAST, width, depth, style)
    assert count == len(plan.stalls)
    assert count > 0
    corners = np.concatenate([stall.corners for stall in plan.stalls])
    assert corners.min() >= -0.05
    assert corners[:, 0].max() <= width + 0.05
    assert corners[:, 1].max() <= depth + 0.05
    area = shapely.union_all([shapely.Polygon(stall.corners) for stall in plan.stalls])
    assert area.area == pytest.approx(sum(shapely.Polygon(s.corners).area for s in plan.stalls), rel=0.01)
    assert area.area < 0.8 * width * depth


@pytest.mark.slow
def test_a_site_has_its_lot_in_one_piece_with_all_stalls_in_it() -> None:
    for seed in range(8):
        plan = plan_any_lot_site(_rng(seed), (50.0, 40.0), SiteSize((40, 60), (30, 40), second=1.0))
        lot = shapely.union_all([shapely.Polygon(outline) for outline in plan.lots]).buffer(0.1)
        assert lot.is_valid
        assert len(plan.lots) == 1
        assert all(lot.contains(shapely.Polygon(stall.corners)) for stall in plan.stalls)
        outside = [building for building in plan.buildings if not building.shelter]
        assert not any(lot.buffer(-0.3).intersects(shapely.Polygon(building.polygon)) for building in outside)


def test_a_bare_site_has_nothing_to_park_on() -> None:
    for seed in range(8):
        plan = plan_bare_site(_rng(seed), (0.0, 0.0))
        assert plan.stalls == []
        assert plan.lots == []
        assert plan.surfaces


def test_paint_can_always_be_distinguished_from_the_ground() -> None:
    for seed in range(60):
        asphalt = float(_rng(seed).uniform(40, 215))
        stalls, hatching, *_ = sample_palette(_rng(seed), asphalt)
        for colour in (stalls, hatching):
            assert np.abs(np.array(colour) - asphalt).max() >= 15
