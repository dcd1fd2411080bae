from __future__ import annotations

import asyncio
import math

import pytest

from hawk.comm.loop_lag import LoopLag


def test_nothing_is_known_before_the_first_sample() -> None:
    lag = LoopLag()
    assert math.isnan(lag.summary().p99_ms)
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
