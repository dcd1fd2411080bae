from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from itertools import pairwise

import pytest

from hawk.runtime.process import Ticker


async def test_it_ticks_at_the_interval_and_reports_the_cost() -> None:
    times: list[float] = []
    costs: list[float] = []
    enough = asyncio.Event()
    loop = asyncio.get_running_loop()

    def tick() -> None:
        times.append(loop.time())
        if len(times) == 6:
            enough.set()

    ticker = Ticker(0.01, tick, costs.append)
    ticker.start()
    async with asyncio.timeout(5):
        await enough.wait()
    ticker.stop()
    assert times[5] - times[0] >= 0.045
    assert len(costs) >= 5
    assert all(cost >= 0 for cost in costs)


async def test_a_tick_that_raises_is_counted_and_the_next_one_comes(caplog: pytest.LogCaptureFixture) -> None:
    again = asyncio.Event()
    calls = 0

    def tick() -> None:
        nonlocal calls
        calls += 1
        if calls == 1:
            raise RuntimeError("broken")
        again.set()

    ticker = Ticker(0.001, tick, lambda _: None)
    with caplog.at_level(logging.ERROR):
        ticker.start()
        async with asyncio.timeout(5):
            await again.wait()
    ticker.stop()
    assert caplog.text.count("a tick failed") == 1


async def test_after_stop_nothing_ticks() -> None:
    calls = 0

    def tick() -> None:
        nonlocal calls
        calls += 1

    ticker = Ticker(0.0, tick, lambda _: None)
    ticker.start()
    ticker.stop()
    for _ in range(5):
        await asyncio.sleep(0)
    assert calls == 1
    ticker.stop()


@pytest.mark.slow
async def test_ticks_that_were_missed_are_not_made_up_for() -> None:
    times: list[float] = []
    enough = asyncio.Event()
    loop = asyncio.get_running_loop()

    def tick() -> None:
        times.append(loop.time())
        if len(times) == 1:
            while loop.time() < times[0] + 0.1:  # a loop that hangs for ten ticks
                pass
        if len(times) == 5:
            enough.set()

    ticker = Ticker(0.01, tick, lambda _: None)
    ticker.start()
    async with asyncio.timeout(5):
        await enough.wait()
    ticker.stop()
    gaps = [after - before for before, after in pairwise(times[1:])]
    assert min(gaps) > 0.0049


class Clock:
    """A loop for one timer whose time passes only by its own method: no scheduler makes a tick late."""

    def __init__(self) -> None:
        self.now = 0.0
        self._due = 0.0
        self._callback: Callable[[], None] = lambda: None

    def time(self) -> float:
        return self.now

    def call_at(self, when: float, callback: Callable[[], None]) -> None:
        self._due, self._callback = when, callback

    def run_one(self) -> None:
        """Wait for the timer, and run it."""
        self.now = max(self.now, self._due)
        self._callback()


def test_after_a_late_tick_the_others_keep_their_places_in_time(monkeypatch: pytest.MonkeyPatch) -> None:
    clock, times = Clock(), list[float]()
    monkeypatch.setattr(asyncio, "get_running_loop", lambda: clock)

    def tick() -> None:
        times.append(clock.now)
        if len(times) == 2:
            clock.now += 0.175  # the third tick, due at 0.2, comes at 0.275

    Ticker(0.1, tick, lambda _: None).start()
    for _ in range(4):
        clock.run_one()
    # the tick at 0.3 would be too soon after the one at 0.275
    assert times == pytest.approx([0.0, 0.1, 0.275, 0.4, 0.5])
