"""Speed of the daemon over the last minute: the event loop's lag, frames, ticks; garbage collected later."""

from __future__ import annotations

import asyncio
import contextlib
import gc
import math
import time
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass

INTERVAL_S = 0.010
"""Real seconds between two samples of the loop's lag."""
LAG_SAMPLES = 6000
"""Samples kept: one minute."""
WINDOW_S = 60.0
"""Seconds of the daemon's clock that the figures cover."""


@dataclass(frozen=True, slots=True)
class LagSummary:
    """Real milliseconds that a 10 ms timer came late, over the last minute; None before the first sample."""

    p50_ms: float | None
    p99_ms: float | None
    max_ms: float | None
    samples: int


class LoopLag:
    """Samples the lag of the running loop until it is cancelled."""

    def __init__(self, monotonic: Callable[[], float] = time.perf_counter, window: int = LAG_SAMPLES) -> None:
        self._monotonic = monotonic
        self._samples: deque[float] = deque(maxlen=window)

    async def run(self) -> None:
        """Sample until cancelled."""
        while True:
            before = self._monotonic()
            await asyncio.sleep(INTERVAL_S)
            self.add(self._monotonic() - before - INTERVAL_S)

    def add(self, lag_s: float) -> None:
        """Take one sample, seconds."""
        self._samples.append(max(0.0, lag_s) * 1e3)

    def summary(self) -> LagSummary:
        """Return the percentiles of the window."""
        if not self._samples:
            return LagSummary(None, None, None, 0)
        ordered = sorted(self._samples)
        p99 = ordered[min(len(ordered) - 1, int(len(ordered) * 0.99))]
        return LagSummary(ordered[len(ordered) // 2], p99, ordered[-1], len(ordered))

    def latest_ms(self) -> float:
        """Return the newest sample, 0 before the first."""
        return self._samples[-1] if self._samples else 0.0


@dataclass(frozen=True, slots=True)
class PerformanceSummary:
    """Figures of the last minute; None where nothing was measured. Latencies in milliseconds of the daemon's clock."""

    loop_lag_p50_ms: float | None
    loop_lag_p99_ms: float | None
    loop_lag_max_ms: float | None
    frame_to_map_p50_ms: float | None
    frame_to_map_p95_ms: float | None
    vision_fps: float | None
    frames_received: int
    frames_dropped_share: float | None
    steps_p50_ms: dict[str, float]
    tick_p50_ms: float | None
    tick_p99_ms: float | None
    tick_max_ms: float | None


class Performance:
    """Collects what happens to frames and ticks; everything is called on the loop."""

    def __init__(self, clock: Callable[[], float], lag: LoopLag) -> None:
        self._clock = clock
        self._lag = lag
        self._received: deque[float] = deque()
        self._fused: deque[tuple[float, float, tuple[tuple[str, float], ...]]] = deque()
        self._ticks: deque[float] = deque(maxlen=1200)

    def frame_received(self) -> None:
        """Count a picture of the camera."""
        self._forget()
        self._received.append(self._clock())

    def frame_published(self, captured: float, timings: tuple[tuple[str, float], ...]) -> None:
        """Take the capture time (daemon's clock) and milliseconds by step of a frame that is published now."""
        self._forget()
        now = self._clock()
        self._fused.append((now, (now - captured) * 1e3, timings))

    def ticked(self, seconds: float) -> None:
        """Take the real seconds that one tick of the state machine took."""
        self._ticks.append(seconds * 1e3)

    @property
    def vision_fps(self) -> float | None:
        """Frames fused per second of the daemon's clock over the last 5 s; None before the first."""
        if not self._fused:
            return None
        now = self._clock()
        return sum(1 for time, _, _ in self._fused if time > now - 5.0) / 5.0

    def summary(self) -> PerformanceSummary:
        """Return the figures of the last minute."""
        self._forget()
        lag = self._lag.summary()
        latencies = [latency for _, latency, _ in self._fused]
        received, fused = len(self._received), len(self._fused)
        span = self._fused[-1][0] - self._fused[0][0] if fused > 1 else 0.0
        return PerformanceSummary(
            loop_lag_p50_ms=lag.p50_ms,
            loop_lag_p99_ms=lag.p99_ms,
            loop_lag_max_ms=lag.max_ms,
            frame_to_map_p50_ms=percentile(latencies, 50),
            frame_to_map_p95_ms=percentile(latencies, 95),
            vision_fps=(fused - 1) / span if span > 0 else None,
            frames_received=received,
            frames_dropped_share=max(0.0, 1 - fused / received) if received else None,
            steps_p50_ms=self._steps(),
            tick_p50_ms=percentile(list(self._ticks), 50),
            tick_p99_ms=percentile(list(self._ticks), 99),
            tick_max_ms=max(self._ticks, default=None),
        )

    def _steps(self) -> dict[str, float]:
        steps: dict[str, list[float]] = {}
        for _, _, timings in self._fused:
            for name, milliseconds in timings:
                steps.setdefault(name, []).append(milliseconds)
        return {name: percentile(values, 50) or 0.0 for name, values in steps.items()}

    def _forget(self) -> None:
        """Drop what is older than the window: nobody may ever ask for a summary."""
        start = self._clock() - WINDOW_S
        while self._received and self._received[0] < start:
            self._received.popleft()
        while self._fused and self._fused[0][0] < start:
            self._fused.popleft()


def percentile(values: list[float], percent: float) -> float | None:
    """Return the nearest-rank percentile, None of nothing."""
    if not values:
        return None
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, max(0, math.ceil(len(ordered) * percent / 100) - 1))]


@contextlib.contextmanager
def uncollected() -> Iterator[None]:
    """Put the collection of garbage off, for every thread.

    A list of a thousand surveys is ten thousand objects for a moment. The collector takes them for lasting ones, and
    after some such lists it looks at every object of the program, 0.2 s in which no thread runs. Once they are freed,
    by their counts of references, there is nothing to look at.
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
