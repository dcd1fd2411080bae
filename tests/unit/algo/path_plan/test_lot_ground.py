from __future__ import annotations

import numpy as np
import shapely
from hypothesis import given
from hypothesis import strategies as st

from hawk.algo.ground import Window
from hawk.algo.path_plan.lot_ground import FenceGuard
from hawk.model.plans import Fence

POLYGON = ((0.0, 0.0), (40.0, 0.0), (40.0, 40.0), (20.0, 40.0), (20.0, 20.0), (0.0, 20.0))
"""An L: the corner about (10, 30) is outside."""
GUARD = FenceGuard(Fence(POLYGON, POLYGON, 60.0, 63.0))
WINDOW = Window.around(np.array([[-10.0, -10.0], [50.0, 50.0]]), 1.6)


def test_ends_inside_do_not_make_a_path_inside() -> None:
    assert GUARD.contains(5.0, 15.0)
    assert GUARD.contains(25.0, 38.0)
    assert not GUARD.contains_line((5.0, 15.0), (25.0, 38.0))
    assert GUARD.contains_line((25.0, 5.0), (25.0, 38.0))


def test_without_a_fence_everything_is_inside() -> None:
    guard = FenceGuard(None)
    assert guard.contains(1e4, 0)
    assert guard.contains_line((0, 0), (1e4, 0))
    assert guard.mask(WINDOW).all()


@given(st.integers(0, WINDOW.rows - 1), st.integers(0, WINDOW.columns - 1))
def test_a_cell_of_the_mask_lies_wholly_inside(row: int, column: int) -> None:
    if GUARD.mask(WINDOW)[row, column]:
        north, east = -(WINDOW.row + row + 0.5) * 1.6, (WINDOW.column + column + 0.5) * 1.6
        for corner in ((-0.8, -0.8), (-0.8, 0.8), (0.8, -0.8), (0.8, 0.8)):
            assert GUARD.contains(north + corner[0], east + corner[1])


def test_the_mask_is_not_empty() -> None:
    assert GUARD.mask(WINDOW).sum() * 1.6**2 > 0.6 * 1200


ZONES = (
    ((22.0, 3.0), (30.0, 3.0), (30.0, 12.0), (22.0, 12.0)),
    ((26.0, 9.0), (34.0, 9.0), (34.0, 16.0)),
    ((10.0, 10.0), (10.3, 10.0), (10.3, 10.3), (10.0, 10.3)),
)
"""Two that cross, and a mast that is smaller than a cell."""
ZONED = FenceGuard(Fence(POLYGON, POLYGON, 60.0, 63.0, ZONES, ZONES))


def test_in_a_zone_is_outside_and_a_line_across_one_leaves_the_fence() -> None:
    assert not ZONED.contains(25.0, 8.0)
    assert not ZONED.contains(30.0, 10.0)
    assert ZONED.contains(20.0, 8.0)
    assert not ZONED.contains_line((20.0, 8.0), (36.0, 8.0))
    assert not ZONED.contains_line((8.0, 8.0), (12.0, 12.0))
    assert ZONED.contains_line((20.0, 1.0), (36.0, 1.0))


@given(st.integers(0, WINDOW.rows - 1), st.integers(0, WINDOW.columns - 1))
def test_no_cell_of_the_mask_touches_a_zone(row: int, column: int) -> None:
    if ZONED.mask(WINDOW)[row, column]:
        north, east = -(WINDOW.row + row + 0.5) * 1.6, (WINDOW.column + column + 0.5) * 1.6
        cell = shapely.box(north - 0.8, east - 0.8, north + 0.8, east + 0.8)
        assert GUARD.mask(WINDOW)[row, column]
        assert not any(cell.intersects(shapely.Polygon(zone)) for zone in ZONES)


@given(st.integers(0, WINDOW.rows - 1), st.integers(0, WINDOW.columns - 1))
def test_ground_belongs_to_the_survey_by_the_fence_as_it_was_drawn(row: int, column: int) -> None:
    """Our own limit lies inside it, and holds larger zones."""
    small = (((23.0, 4.0), (29.0, 4.0), (29.0, 11.0), (23.0, 11.0)),)
    drawn = Fence(((18.0, 4.0), (36.0, 4.0), (36.0, 16.0)), POLYGON, 60.0, 63.0, zones=ZONES, autopilot_zones=small)
    north, east = -(WINDOW.row + row + 0.5) * 1.6, (WINDOW.column + column + 0.5) * 1.6
    place = shapely.Point(north, east)
    ours = shapely.Polygon(POLYGON).difference(shapely.union_all([shapely.Polygon(zone) for zone in small]))
    if ours.boundary.distance(place) > 1e-6:
        assert bool(FenceGuard(drawn).ours(WINDOW)[row, column]) is ours.covers(place)


def test_without_a_fence_all_ground_belongs_to_the_survey() -> None:
    assert FenceGuard(None).ours(WINDOW).all()


def test_zones_leave_the_ground_around_them() -> None:
    lost = (GUARD.mask(WINDOW) > ZONED.mask(WINDOW)).sum() * 1.6**2
    within = shapely.union_all([shapely.Polygon(zone) for zone in ZONES]).buffer(2 * 1.6 * 1.5).area
    assert 0 < lost < within


def test_a_cell_beside_a_zone_is_the_same_in_every_window() -> None:
    part = Window(WINDOW.row + 7, WINDOW.column + 9, 11, 8, 1.6)
    assert (ZONED.mask(WINDOW)[WINDOW.part(part)] == ZONED.mask(part)).all()
