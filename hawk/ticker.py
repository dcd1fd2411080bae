"""Calls something at a fixed rate of the daemon's clock, from the event loop."""

from __future__ import annotations

import asyncio
import logging
import math
import time
from collections.abc import Callable

_LOG = logging.getLogger(__name__)


class Ticker:
    """Ticks until it is stopped. Missed ticks are not made up for; one that raises does not end the ticking.

    Ticks keep their places in time: after a late one the next comes when it would have come anyhow, but not sooner
    than half an interval later. What is done every so many ticks (the heartbeat) keeps its rhythm so.
    """

    def __init__(self, interval_s: float, tick: Callable[[], None], cost: Callable[[float], None]) -> None:
        """``interval_s`` in real seconds; ``cost`` is told the real seconds of every tick."""
        self._interval = interval_s
        self._tick = tick
        self._cost = cost
        self._handle: asyncio.TimerHandle | None = None
        self._due = 0.0
        self.failures = 0
        """Ticks that raised."""

    def start(self) -> None:
        """Tick at once, then at the interval; needs the running loop."""
        self._due = asyncio.get_running_loop().time()
        self._run()

    def stop(self) -> None:
        """Tick no more."""
        if self._handle is not None:
            self._handle.cancel()
            self._handle = None

    def _run(self) -> None:
        loop = asyncio.get_running_loop()
        late = loop.time() - self._due
        if self._interval > 0:
            self._due += max(1, math.ceil(late / self._interval + 0.5)) * self._interval
        self._handle = loop.call_at(self._due, self._run)
        started = time.perf_counter()
        try:
            self._tick()
        except Exception:
            self.failures += 1
            _LOG.exception("a tick failed")
        self._cost(time.perf_counter() - started)
