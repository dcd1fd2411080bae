from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.model.frames import REACH_S, Attitude, EkfPosition, PoseBuffer, wrap_angle


def position(time: float, x: float = 0.0, vx: float = 0.0) -> EkfPosition:
    return EkfPosition(time, x, 2 * x, -x, vx, 0.0, 0.0)


def test_an_empty_buffer_has_no_pose() -> None:
    buffer = PoseBuffer()
    assert buffer.position_at(0.0) is None
    assert buffer.attitude_at(0.0) is None
    assert buffer.latest_position is None


def test_between_two_samples_it_is_linear() -> None:
    buffer = PoseBuffer()
    buffer.add_position(position(1.0, 0.0, 4.0))
    buffer.add_position(position(1.1, 1.0, 6.0))
    found = buffer.position_at(1.025)
    assert found is not None
    assert (found.time, found.x, found.y, found.z, found.vx) == pytest.approx((1.025, 0.25, 0.5, -0.25, 4.5))


def test_at_the_time_of_a_sample_it_is_that_sample() -> None:
    buffer = PoseBuffer()
    for time in (1.0, 1.05, 1.1):
        buffer.add_position(position(time, time))
    found = buffer.position_at(1.05)
    assert found is not None
    assert found.x == pytest.approx(1.05)


@pytest.mark.parametrize(("off", "known"), [(0.29, True), (0.31, False), (-0.29, True), (-0.31, False)])
def test_beyond_the_samples_it_reaches_three_tenths_of_a_second_by_velocity(off: float, known: bool) -> None:
    buffer = PoseBuffer()
    buffer.add_position(position(10.0, 5.0, 4.0))
    buffer.add_attitude(Attitude(10.0, 0.1, 0.2, 0.3))
    found, attitude = buffer.position_at(10.0 + off), buffer.attitude_at(10.0 + off)
    assert (found is not None) is known
    assert (attitude is not None) is known
    if found is not None and attitude is not None:
        assert found.x == pytest.approx(5.0 + 4.0 * off)
        assert attitude.yaw == 0.3


def test_a_gap_in_the_samples_is_not_bridged() -> None:
    buffer = PoseBuffer()
    buffer.add_position(position(1.0, 0.0, 1.0))
    buffer.add_position(position(3.0, 100.0, 1.0))
    assert buffer.position_at(2.0) is None
    near = buffer.position_at(1.2)
    assert near is not None
    assert near.x == pytest.approx(0.2)
    late = buffer.position_at(2.9)
    assert late is not None
    assert late.x == pytest.approx(99.9)


def test_angles_turn_by_the_smaller_angle() -> None:
    buffer = PoseBuffer()
    buffer.add_attitude(Attitude(0.0, 0.0, 0.0, math.radians(170)))
    buffer.add_attitude(Attitude(0.1, 0.0, 0.0, math.radians(-170)))
    found = buffer.attitude_at(0.075)
    assert found is not None
    assert math.degrees(found.yaw) == pytest.approx(-175)


def test_old_and_repeated_samples_are_dropped() -> None:
    buffer = PoseBuffer(keep_s=1.0)
    buffer.add_position(position(1.0, 1.0))
    buffer.add_position(position(1.0, 99.0))
    buffer.add_position(position(0.9, 99.0))
    assert buffer.latest_position == position(1.0, 1.0)
    buffer.add_position(position(2.5, 2.0))
    assert buffer.position_at(1.0) is None


def test_cleared_it_knows_nothing() -> None:
    buffer = PoseBuffer()
    buffer.add_position(position(1.0))
    buffer.add_attitude(Attitude(1.0, 0, 0, 0))
    buffer.clear()
    assert buffer.position_at(1.0) is None
    assert buffer.attitude_at(1.0) is None


@given(st.floats(-100, 100))
def test_a_wrapped_angle_points_in_the_same_direction(angle: float) -> None:
    wrapped = wrap_angle(angle)
    assert -math.pi <= wrapped < math.pi + 1e-9
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-9)


@pytest.mark.slow
@given(
    st.lists(st.floats(0.01, 0.2), min_size=2, max_size=20),
    st.lists(st.floats(-math.pi, math.pi), min_size=21, max_size=21),
    st.floats(0, 1),
)
def test_an_interpolated_angle_lies_between_its_neighbours(gaps: list[float], yaws: list[float], share: float) -> None:
    buffer = PoseBuffer(keep_s=1000.0)
    times = [0.0]
    for gap in gaps:
        times.append(times[-1] + gap)
    for time, yaw in zip(times, yaws, strict=False):
        buffer.add_attitude(Attitude(time, 0.0, 0.0, yaw))
    first, second = yaws[0], yaws[1]
    found = buffer.attitude_at(times[0] + share * gaps[0])
    assert found is not None
    turn = abs(wrap_angle(second - first))
    assert abs(wrap_angle(found.yaw - first)) <= turn + 1e-6
    assert abs(wrap_angle(found.yaw - second)) <= turn + 1e-6
    assert REACH_S == 0.3
