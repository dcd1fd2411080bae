from __future__ import annotations

import asyncio
import json
from dataclasses import asdict

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.runtime.performance import LoopLag, Performance, percentile
from tests.manual_clock import ManualClock


def test_nothing_measured_is_none_not_zero() -> None:
    summary = Performance(ManualClock(), LoopLag()).summary()
    assert summary.frame_to_map_p95_ms is None
    assert summary.vision_fps is None
    assert summary.frames_dropped_share is None
    assert summary.loop_lag_p99_ms is None
    json.dumps(asdict(summary), allow_nan=False)


def test_latency_rate_and_drops_of_a_steady_stream() -> None:
    clock = ManualClock(10.0)
    performance = Performance(clock, LoopLag())
    for number in range(100):
        clock.advance(0.1)
        performance.frame_received()
        if number % 2:
            performance.frame_published(clock() - 0.12, (("vision", 30.0),))
    summary = performance.summary()
    assert summary.frame_to_map_p95_ms == pytest.approx(120)
    assert summary.vision_fps == pytest.approx(5.0, rel=0.05)
    assert summary.frames_dropped_share == pytest.approx(0.5)
    assert summary.steps_p50_ms == {"vision": 30.0}


def test_only_the_last_minute_counts() -> None:
    clock = ManualClock()
    performance = Performance(clock, LoopLag())
    performance.frame_received()
    performance.frame_published(-9.0, ())
    clock.advance(61)
    performance.frame_received()
    performance.frame_published(clock() - 0.1, ())
    assert performance.summary().frame_to_map_p95_ms == pytest.approx(100)
    assert performance.vision_fps == pytest.approx(0.2)


@given(st.lists(st.floats(0, 1e6), min_size=1, max_size=50), st.floats(0, 100))
def test_a_percentile_is_one_of_the_values_with_that_share_at_or_below_it(values: list[float], percent: float) -> None:
    found = percentile(values, percent)
    assert found in values
    assert sum(v <= found for v in values) >= len(values) * percent / 100 - 1e-9


def test_no_lag_is_known_before_the_first_sample() -> None:
    lag = LoopLag()
    assert lag.summary().p99_ms is None
    assert lag.latest_ms() == 0.0


def test_percentiles_over_the_window() -> None:
    lag = LoopLag(window=100)
    for ms in range(200):
        lag.add(ms / 1000)
    summary = lag.summary()
    assert summary.samples == 100
    assert summary.p50_ms == pytest.approx(150)
    assert summary.p99_ms == pytest.approx(199)
    assert summary.max_ms == pytest.approx(199)


def test_a_timer_that_comes_early_is_not_a_negative_lag() -> None:
    lag = LoopLag()
    lag.add(-0.001)
    assert lag.latest_ms() == 0.0


async def test_the_running_loop_is_sampled() -> None:
    times = iter([0.0, 0.030, 0.030, 0.045])
    hung = asyncio.Event()

    def monotonic() -> float:
        try:
            return next(times)
        except StopIteration:
            hung.set()
            return 1.0

    lag = LoopLag(monotonic)
    task = asyncio.create_task(lag.run())
    await hung.wait()
    task.cancel()
    await asyncio.gather(task, return_exceptions=True)
    assert lag.summary().max_ms == pytest.approx(20.0)


def test_a_day_in_which_nobody_asks_holds_a_minute() -> None:
    clock = ManualClock()
    performance = Performance(clock, LoopLag())
    for _ in range(20_000):
        clock.advance(1.0)
        performance.frame_received()
        performance.frame_published(clock(), (("vision", 30.0),))
    assert len(performance._fused) <= 61
    assert len(performance._received) <= 61
