from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hawk.algo.ground import Window
from hawk.algo.path_plan.lot_ground import FenceGuard
from hawk.model import Fence

POLYGON = ((0.0, 0.0), (40.0, 0.0), (40.0, 40.0), (20.0, 40.0), (20.0, 20.0), (0.0, 20.0))
"""An L: the corner about (10, 30) is outside."""
GUARD = FenceGuard(Fence(POLYGON, POLYGON, 60.0, 63.0))
WINDOW = Window.around(np.array([[-10.0, -10.0], [50.0, 50.0]]), 1.6)


def test_ends_inside_do_not_make_a_way_inside() -> None:
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
