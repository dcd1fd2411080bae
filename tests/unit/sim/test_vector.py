from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.sim.geometry import add, clamp, limit, sqrt_controller, subtract, wrap_angle

numbers = st.floats(-1e3, 1e3)


@given(numbers, numbers, st.floats(0.0, 100.0))
def test_limit_keeps_the_direction_and_never_lengthens(x: float, y: float, longest: float) -> None:
    short = limit(x, y, longest)
    assert math.hypot(*short) <= longest + 1e-6 or short == (x, y)
    assert abs(short[0] * y - short[1] * x) <= 1e-6 * (1 + abs(x) + abs(y)) ** 2


@given(st.floats(-100.0, 100.0))
def test_wrapped_angles_point_in_the_same_direction(angle: float) -> None:
    wrapped = wrap_angle(angle)
    assert -math.pi < wrapped <= math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-9)


@given(st.floats(0.0, 200.0), st.floats(0.5, 5.0))
def test_the_square_root_controller_can_stop_in_time(distance: float, acceleration: float) -> None:
    speed = sqrt_controller(distance, 1.0, acceleration)
    assert speed**2 / (2 * acceleration) <= distance + 1e-9
    assert sqrt_controller(-distance, 1.0, acceleration) == -speed


def test_the_square_root_controller_is_continuous_where_it_bends() -> None:
    assert sqrt_controller(2.5 - 1e-9, 1.0, 2.5) == pytest.approx(sqrt_controller(2.5 + 1e-9, 1.0, 2.5), abs=1e-6)


def test_sums_and_limits() -> None:
    assert add((1, 2, 3), (4, 5, 6)) == (5, 7, 9)
    assert subtract((4, 5, 6), (1, 2, 3)) == (3, 3, 3)
    assert [clamp(value, -1, 1) for value in (-5.0, 0.5, 5.0)] == [-1, 0.5, 1]
