"""How fast the daemon is, over the last minute: what /api/performance and the benchmarks show."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import asdict, dataclass

from hawk.comm.loop_lag import LoopLag

WINDOW_S = 60.0
"""Seconds of the daemon's clock that are looked back on."""


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
    tick_p99_ms: float | None

    def to_dict(self) -> dict[str, object]:
        """Return the figures for JSON."""
        return asdict(self)


class Performance:
    """Collects what happens to frames and ticks; everything is called on the loop."""

    def __init__(self, clock: Callable[[], float], lag: LoopLag) -> None:
        self._clock = clock
        self._lag = lag
        self._received: deque[float] = deque()
        self._fused: deque[tuple[float, float, tuple[tuple[str, float], ...]]] = deque()
        self._ticks: deque[float] = deque(maxlen=1200)

    def frame_received(self) -> None:
        """Count a picture that the camera gave."""
        self._received.append(self._clock())

    def frame_published(self, captured: float, timings: tuple[tuple[str, float], ...]) -> None:
        """Take the capture time of a frame whose results are published at this moment, and its milliseconds by step."""
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
            loop_lag_p50_ms=_finite(lag.p50_ms),
            loop_lag_p99_ms=_finite(lag.p99_ms),
            loop_lag_max_ms=_finite(lag.max_ms),
            frame_to_map_p50_ms=percentile(latencies, 50),
            frame_to_map_p95_ms=percentile(latencies, 95),
            vision_fps=(fused - 1) / span if span > 0 else None,
            frames_received=received,
            frames_dropped_share=max(0.0, 1 - fused / received) if received else None,
            steps_p50_ms=self._steps(),
            tick_p99_ms=percentile(list(self._ticks), 99),
        )

    def _steps(self) -> dict[str, float]:
        steps: dict[str, list[float]] = {}
        for _, _, timings in self._fused:
            for name, milliseconds in timings:
                steps.setdefault(name, []).append(milliseconds)
        return {name: percentile(values, 50) or 0.0 for name, values in steps.items()}

    def _forget(self) -> None:
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


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
