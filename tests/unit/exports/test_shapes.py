"""Shapes in WGS-84: longitude comes first, and rings run counter-clockwise."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.exports.shapes import lot_shape
from hawk.model.plans import Outline

corner = st.tuples(st.floats(52.0, 52.01), st.floats(5.0, 5.01))


@pytest.mark.slow
@given(st.lists(st.lists(corner, min_size=3, max_size=6).map(tuple), max_size=4))
def test_any_rings_become_valid_polygons_that_run_counter_clockwise(
    rings: list[tuple[tuple[float, float], ...]],
) -> None:
    shape = lot_shape(Outline(tuple(rings)))
    assert shape.is_valid
    for part in shape.geoms:
        assert part.exterior.is_ccw
        assert 4.99 < part.exterior.coords[0][0] < 5.02
