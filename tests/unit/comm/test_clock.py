from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.comm.clock import Clock, OffsetEstimator
from tests.manual_clock import ManualClock


def test_scaled_clock_starts_at_zero_and_runs_n_times_as_fast() -> None:
    real = ManualClock(100.0)
    clock = Clock(3.0, real)
    assert clock() == 0.0
    real.advance(2.0)
    assert clock() == pytest.approx(6.0)
    assert clock.speed == 3.0


@pytest.mark.parametrize("speed", [0.0, -1.0, math.inf, math.nan])
def test_a_speed_that_is_no_speed_is_refused(speed: float) -> None:
    with pytest.raises(ValueError, match="speed must be a positive number"):
        Clock(speed)


def test_manual_clock_moves_by_hand_and_never_back() -> None:
    clock = ManualClock(5.0)
    clock.advance(1.5)
    assert clock() == 6.5
    assert clock.speed == 1.0
    with pytest.raises(ValueError, match="backwards"):
        clock.advance(-0.1)


def test_the_least_delay_is_the_offset() -> None:
    estimator = OffsetEstimator()
    estimator.update(10.0, 110.30)
    assert estimator.update(10.1, 110.15) == pytest.approx(110.15)
    assert estimator.update(10.2, 110.50) == pytest.approx(110.25)  # late by 0.25: the stamp stays where it belongs


def test_a_known_latency_is_taken_off() -> None:
    estimator = OffsetEstimator(latency_s=0.08)
    assert estimator.update(1.0, 5.08) == pytest.approx(5.0)


def test_nothing_is_known_before_the_first_stamp() -> None:
    with pytest.raises(LookupError):
        OffsetEstimator().to_ours(1.0)


def test_drift_is_followed_within_the_window() -> None:
    estimator = OffsetEstimator(window_s=30.0)
    for second in range(600):
        drifted = second * (1 + 1e-4)  # our clock gains 0.1 ms a second
        mapped = estimator.update(float(second), drifted)
    assert abs(mapped - drifted) < 0.0035


@pytest.mark.parametrize(("arrival", "offset"), [(40.0, 10.0), (40.5, 12.0), (50.0, 12.0), (50.5, 13.0)])
def test_the_least_delay_of_the_window_counts(arrival: float, offset: float) -> None:
    """Delays over the least possible one: 10 at 10 s, 15 at 16 s, 12 at 20 s, and 13 now."""
    estimator = OffsetEstimator()
    for came, late in ((10.0, 10.0), (16.0, 15.0), (20.0, 12.0)):
        estimator.update(came - late, came)
    assert estimator.update(arrival - 13.0, arrival) == arrival - 13.0 + offset


def test_the_latest_of_equal_delays_counts() -> None:
    estimator = OffsetEstimator()
    estimator.update(0.0, 10.0)
    estimator.update(20.0, 30.0)
    assert estimator.update(40.0, 55.0) == 50.0


@pytest.mark.parametrize(("back", "mapped"), [(0.9, 60.0), (1.0, 60.0), (1.1, 69.0)])
def test_a_stamp_out_of_order_is_no_reboot(back: float, mapped: float) -> None:
    estimator = OffsetEstimator()
    estimator.update(10.0, 60.0)
    assert estimator.update(10.0 - back, 69.0) == pytest.approx(mapped - back if back <= 1.0 else mapped)


def test_a_reboot_starts_the_estimate_again() -> None:
    estimator = OffsetEstimator()
    estimator.update(1000.0, 50.0)
    assert estimator.update(0.5, 60.0) == pytest.approx(60.0)
    assert estimator.to_ours(1.5) == pytest.approx(61.0)


@pytest.mark.slow
@given(st.lists(st.floats(0.0, 0.5), min_size=5, max_size=100), st.floats(-1e6, 1e6))
def test_a_stamp_is_never_mapped_after_its_arrival_nor_before_its_time(delays: list[float], offset: float) -> None:
    estimator = OffsetEstimator()
    least = math.inf
    for index, delay in enumerate(delays):
        remote = index * 0.05
        arrival = remote + offset + delay
        least = min(least, delay)
        mapped = estimator.update(remote, arrival)
        assert mapped <= arrival + 1e-6
        assert mapped == pytest.approx(remote + offset + least, abs=1e-6)
