from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.sim.geometry import Origin

metres = st.floats(-500.0, 500.0)


@given(metres, metres, st.floats(-120.0, 0.0))
def test_there_and_back_is_the_same_place(north: float, east: float, down: float) -> None:
    origin = Origin()
    assert origin.to_world(*origin.to_geodetic((north, east, down))) == pytest.approx((north, east, down), abs=1e-4)


def test_a_minute_of_latitude_is_a_nautical_mile() -> None:
    origin = Origin(43.0, -80.0, 0.0)
    north, east, _ = origin.to_world(43.0 + 1 / 60, -80.0, 0.0)
    assert north == pytest.approx(1852.0, rel=2e-3)
    assert east == pytest.approx(0.0, abs=1e-6)


def test_east_shrinks_with_latitude_and_altitude_is_up() -> None:
    origin = Origin(60.0, 10.0, 100.0)
    assert origin.to_world(60.0, 10.001, 100.0)[1] == pytest.approx(
        111_320 * 0.001 * math.cos(math.radians(60)), rel=5e-3
    )
    assert origin.to_geodetic((0.0, 0.0, -35.0))[2] == pytest.approx(135.0)
