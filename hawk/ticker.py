"""Calls something at a fixed rate of the daemon's clock, from the event loop."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable

_LOG = logging.getLogger(__name__)


class Ticker:
    """Ticks until it is stopped. A late tick is not made up for; one that raises does not end the ticking."""

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
        self._due += self._interval
        if self._due <= loop.time():
            self._due = loop.time() + self._interval
        self._handle = loop.call_at(self._due, self._run)
        started = time.perf_counter()
        try:
            self._tick()
        except Exception:
            self.failures += 1
            _LOG.exception("a tick failed")
        self._cost(time.perf_counter() - started)
