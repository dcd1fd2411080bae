"""How late the event loop is: sampled always, shown in health and metrics."""

from __future__ import annotations

import asyncio
import math
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

INTERVAL_S = 0.010
"""Real seconds between two samples."""
WINDOW = 6000
"""Samples kept: one minute."""


@dataclass(frozen=True, slots=True)
class LagSummary:
    """Real milliseconds that a 10 ms timer came late, over the last minute; NaN before the first sample."""

    p50_ms: float
    p99_ms: float
    max_ms: float
    samples: int


class LoopLag:
    """Samples the lag of the running loop until it is cancelled."""

    def __init__(self, monotonic: Callable[[], float] = time.perf_counter, window: int = WINDOW) -> None:
        self._monotonic = monotonic
        self._samples: deque[float] = deque(maxlen=window)

    async def run(self) -> None:
        """Sample for ever."""
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
            return LagSummary(math.nan, math.nan, math.nan, 0)
        ordered = sorted(self._samples)
        return LagSummary(
            ordered[len(ordered) // 2], ordered[min(len(ordered) - 1, int(len(ordered) * 0.99))], ordered[-1],
            len(ordered),
        )  # fmt: skip

    def latest_ms(self) -> float:
        """Return the newest sample, 0 before the first."""
        return self._samples[-1] if self._samples else 0.0
