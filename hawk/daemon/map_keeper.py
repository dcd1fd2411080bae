"""Carries the map from the algorithms to the flight journal, so that it survives the process."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable, Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # see `hawk.algo.loop`
    from hawk.algo.mapper.delta import MapDelta

_LOG = logging.getLogger(__name__)

INTERVAL_S = 0.3
"""Real seconds between two requests: with the journal's own quarter of a second less than one is lost."""


class MapKeeper:
    """Puts the map's changes into the journal at an interval."""

    def __init__(
        self,
        changes_since: Callable[[int], Awaitable[MapDelta]],
        put: Callable[[Mapping[str, bytes]], None],
        interval_s: float = INTERVAL_S,
    ) -> None:
        self._changes_since = changes_since
        self._put = put
        self._interval = interval_s
        self._version = 0
        self._lock = asyncio.Lock()

    async def run(self) -> None:
        """Keep the map until cancelled; a failure is logged and tried again."""
        while True:
            await asyncio.sleep(self._interval)
            try:
                await self.keep()
            except Exception:
                _LOG.exception("the map could not be journalled")

    async def keep(self) -> None:
        """Put what changed since the last time."""
        async with self._lock:
            await self._keep()

    async def switch(self, begin: Callable[[], Awaitable[None]]) -> None:
        """Keep the last changes, let ``begin`` begin another map and journal, and keep all of it from then on.

        Raises what ``begin`` raises. What cannot be kept of the old map is logged.
        """
        async with self._lock:
            try:
                await self._keep()
            except Exception:
                _LOG.exception("the last changes of the map were not journalled")
            await begin()
            self._version = 0

    async def _keep(self) -> None:
        delta = await self._changes_since(self._version)
        if delta.parts:
            self._put(delta.parts)
        self._version = delta.version
